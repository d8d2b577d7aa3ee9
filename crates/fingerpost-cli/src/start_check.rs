//! Whether a given start, a GPS track and a route can belong to one drive.

use anyhow::{Context, Result, bail};
use fingerpost::fix::NearPlace;
use fingerpost::progress::RouteProgressConfig;
use fingerpost_geometry::Polyline;
use fingerpost_map::{ARE_EXCHANGED, LatLon, MapBounds, OffRoad, RoadGraph, Route, TangentPlane};
use nalgebra::Point2;

use crate::arguments::Place;
use crate::run::NEAR_SIGMA_M;

/// Standard deviations of start and GPS by which the two may lie apart, beyond what a position may lie off the route.
const APART_SIGMAS: f64 = 3.0;

/// Where on the route a place is, metres along it, that is known to this standard deviation; none for one that is too far beside the
/// route to be on it, and where there is no route.
pub(crate) fn place_on_route(route: &Route, place: LatLon, sigma_m: f64) -> Option<f64> {
    let p_in_map = route.plane()?.map_from_wgs84(place);
    let nearest = route.polyline().ok()?.nearest(p_in_map);
    ((p_in_map - nearest.point).norm() <= APART_SIGMAS * sigma_m).then_some(nearest.along_m)
}

/// The place that `--near` gives; refused where it is on no road of the map, as the stops of a route are.
pub(crate) fn near_place(roads: &RoadGraph, near: Option<Place>) -> Result<Option<NearPlace>> {
    let Some(Place(at)) = near else { return Ok(None) };
    roads.place_on_road(at).context("--near")?;
    Ok(Some(NearPlace { at, sigma_m: NEAR_SIGMA_M }))
}

/// Refuses a GPS track of which no position is on a road of the map.
pub(crate) fn check_on_map(roads: &RoadGraph, gps: &[LatLon]) -> Result<()> {
    let mut nearest: Option<OffRoad> = None;
    for at in gps {
        let Err(off_road) = roads.place_on_road(*at) else { return Ok(()) };
        if nearest.is_none_or(|nearest| off_road.nearest_m < nearest.nearest_m) {
            nearest = Some(off_road);
        }
    }
    nearest.map_or(Ok(()), Err).context(
        "the GPS track never comes to a road of the map; give the track and the map of this drive, or leave --gps out: its position \
         nearest to a road",
    )
}

/// Distance between places of a route at which positions are held against it, metres: a few lie within any gate.
const PLACES_M: f64 = 5.0;

/// Whether positions can have been driven along a line in their order: each that is within the gate of the line anywhere is within it
/// at or behind the place of the one before.
fn follows(line: &Polyline, map: &TangentPlane, gps: &[LatLon], gate_m: f64) -> bool {
    let places: Vec<Point2<f64>> =
        (0..=(line.length_m() / PLACES_M) as usize).map(|i| line.at(PLACES_M * i as f64).0).collect();
    let mut from = 0;
    gps.iter().map(|at| map.map_from_wgs84(*at)).all(|p_in_map| {
        let is_near = |place: &Point2<f64>| (p_in_map - place).norm() <= gate_m;
        match places[from..].iter().position(is_near) {
            Some(on) => {
                from += on;
                true
            }
            // A position beside the whole route says nothing of the order.
            None => !places.iter().any(is_near),
        }
    })
}

/// Refuses a start that is not on the route.
pub(crate) fn check_on_route(line: &Polyline, start_m: f64) -> Result<()> {
    let length_m = line.length_m();
    if (0.0..=length_m).contains(&start_m) {
        return Ok(());
    }
    bail!("--start-m {start_m} is not on the route, which is {length_m:.0} m long; give 0 to {length_m:.0}");
}

/// Refuses a start that is not on the route and a GPS track that never comes near it. The answer are contradictions that a run
/// can begin with, each a sentence: one of the two is wrong, and nothing says which.
pub(crate) fn check(
    config: &RouteProgressConfig,
    route: &Route,
    start_m: Option<f64>,
    gps: &[LatLon],
) -> Result<Vec<String>> {
    let line = route.polyline()?;
    start_m.map_or(Ok(()), |start_m| check_on_route(&line, start_m))?;
    let (Some(map), Some(first)) = (route.plane(), gps.first()) else { return Ok(Vec::new()) };
    let off_m = |at: &LatLon| {
        let p_in_map = map.map_from_wgs84(*at);
        (p_in_map - line.nearest(p_in_map).point).norm()
    };
    let gate_m = config.gps_gate_m;
    let nearest_m = gps.iter().map(off_m).min_by(f64::total_cmp).unwrap_or_default();
    if nearest_m > gate_m {
        let bounds = MapBounds::of(route.line.iter().map(|point| point.at));
        let is_right = |at: LatLon| {
            bounds.is_some_and(|bounds| bounds.contains(at))
                || LatLon::new(at.lat_deg, at.lon_deg).is_ok() && off_m(&at) <= gate_m
        };
        let more = if gps.iter().any(|at| is_right(at.exchanged())) {
            format!("or leave --gps out; {ARE_EXCHANGED}")
        } else {
            "leave --gps out, or make route_progress.gps_gate_m larger".to_owned()
        };
        bail!(
            "the GPS track never comes nearer to the route than {nearest_m:.0} m, and positions more than {gate_m} m off are not \
             believed; give the track and the route of this drive, {more}"
        );
    }
    let first_off_m = off_m(first);
    if first_off_m > gate_m {
        return Ok(vec![format!(
            "the first GPS position lies {first_off_m:.0} m off the route, more than {gate_m} m, and is not believed; does the drive \
             begin on the route?"
        )]);
    }
    if !follows(&line, &map, gps, gate_m) && follows(&line.reversed(), &map, gps, gate_m) {
        return Ok(vec![
            "the GPS track runs against the route: its positions lie on it in the opposite order; plan the route the other way, or from \
             this track (route --gpx)"
                .to_owned(),
        ]);
    }
    let most_m = gate_m + APART_SIGMAS * libm::hypot(config.start_sigma_m, config.gps_sigma_m);
    let apart = start_m.and_then(|start_m| {
        let apart_m = (map.map_from_wgs84(*first) - line.at(start_m).0).norm();
        (apart_m > most_m).then(|| {
            format!(
                "--start-m {start_m} lies {apart_m:.0} m from the first GPS position, which is at {:.0} m of the route; more than \
                 {most_m:.0} m cannot be, so one of them is wrong",
                line.nearest(map.map_from_wgs84(*first)).along_m
            )
        })
    });
    Ok(apart.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use fingerpost_map::{TangentPlane, read_route};
    use nalgebra::Vector2;

    use super::*;

    fn route() -> Route {
        read_route(fingerpost_sim::TOWN_ROUTE).unwrap()
    }

    #[test]
    fn a_place_beside_the_route_is_on_it_as_far_as_it_may_be_off() {
        let (route, line) = (route(), route().polyline().unwrap());
        let (on_line, ahead) = line.at(120.0);
        let left = Vector2::new(-ahead.y, ahead.x);
        let place = |left_m: f64| route.plane().unwrap().wgs84_from_map(on_line + left * left_m);
        assert!((place_on_route(&route, place(10.0), 20.0).unwrap() - 120.0).abs() < 3.0);
        assert_eq!(place_on_route(&route, place(2000.0), 20.0), None);
    }

    /// A position a second over the whole route, 10 m apart, each moved by so much.
    fn track(route: &Route, from_m: f64, moved: impl Fn(usize) -> Vector2<f64>) -> Vec<LatLon> {
        let (line, map) = (route.polyline().unwrap(), TangentPlane::new(route.line[0].at));
        let count = ((line.length_m() - from_m) / 10.0) as usize;
        let place = |index: usize| line.at(from_m + 10.0 * index as f64).0 + moved(index);
        (0..count).map(|index| map.wgs84_from_map(place(index))).collect()
    }

    #[test]
    fn what_fits_is_said_nothing_of() {
        let (route, config) = (route(), RouteProgressConfig::default());
        for from_m in [0.0, 30.0, 77.0] {
            for side in 0..8 {
                let error = 15.0 * Vector2::new(libm::cos(f64::from(side)), libm::sin(f64::from(side)));
                let gps = track(&route, from_m, |_| error);
                for start_m in [None, Some(from_m), Some(from_m + 10.0)] {
                    assert!(check(&config, &route, start_m, &gps).unwrap().is_empty(), "{from_m} {side}");
                }
            }
        }
        assert!(check(&config, &route, Some(3.0), &[]).unwrap().is_empty());
    }

    #[test]
    fn a_track_of_another_drive_is_refused() {
        let (route, config) = (route(), RouteProgressConfig::default());
        for off_m in [1e3, 2e4, 3e5] {
            for side in 0..8 {
                let away = off_m * Vector2::new(libm::cos(f64::from(side)), libm::sin(f64::from(side)));
                let refused = check(&config, &route, None, &track(&route, 0.0, |_| away)).unwrap_err();
                assert!(refused.to_string().contains("never comes nearer"), "{refused}");
            }
        }
    }

    #[test]
    fn a_track_with_latitude_and_longitude_exchanged_is_asked_about() {
        let (route, config) = (route(), RouteProgressConfig::default());
        let refused = |gps: &[LatLon]| check(&config, &route, Some(3.0), gps).unwrap_err().to_string();
        let exchanged = |gps: Vec<LatLon>| -> Vec<LatLon> { gps.iter().map(|at| at.exchanged()).collect() };
        for from_m in [0.0, 100.0, 300.0] {
            for off in [Vector2::zeros(), Vector2::new(-30.0, 20.0), Vector2::new(25.0, 25.0)] {
                let said = refused(&exchanged(track(&route, from_m, |_| off)));
                assert!(said.contains("exchanged?") && said.contains("leave --gps out"), "{said}");
                assert!(!said.contains("gps_gate_m"), "a larger gate is no help: {said}");
            }
            // Exchanged or not, that is another place.
            let away = track(&route, from_m, |_| Vector2::new(3e5, 0.0));
            for gps in [exchanged(away.clone()), away] {
                let said = refused(&gps);
                assert!(!said.contains("exchanged?") && said.contains("gps_gate_m"), "{said}");
            }
        }
    }

    #[test]
    fn a_first_position_far_off_is_named() {
        let (route, config) = (route(), RouteProgressConfig::default());
        for off_m in [60.0, 5e3] {
            let first = |index| if index == 0 { Vector2::new(-off_m, -off_m) } else { Vector2::zeros() };
            let said = check(&config, &route, Some(0.0), &track(&route, 0.0, first)).unwrap();
            assert!(said.len() == 1 && said[0].contains("first GPS position"), "{off_m}: {said:?}");
        }
    }

    #[test]
    fn a_start_that_gps_contradicts_is_named() {
        let (route, config) = (route(), RouteProgressConfig::default());
        let line = route.polyline().unwrap();
        let gps = track(&route, 0.0, |_| Vector2::zeros());
        let mut named = 0;
        for start_m in (0..).map(|tens| 10.0 * f64::from(tens)).take_while(|m| *m <= line.length_m()) {
            let said = check(&config, &route, Some(start_m), &gps).unwrap();
            let apart_m = (line.at(start_m).0 - line.at(0.0).0).norm();
            // 40 m and three times the 6.7 m of both.
            assert_eq!(said.len(), usize::from(apart_m > 60.2), "{start_m}: {said:?}");
            named += said.len();
        }
        assert!(named > 3, "the route is long enough to be wrong on");
    }

    #[test]
    fn a_track_that_runs_against_the_route_is_named() {
        let (route, config) = (route(), RouteProgressConfig::default());
        for from_m in [0.0, 100.0, 300.0] {
            for side in 0..8 {
                let error = 15.0 * Vector2::new(libm::cos(f64::from(side)), libm::sin(f64::from(side)));
                let mut gps = track(&route, from_m, |_| error);
                gps.reverse();
                let said = check(&config, &route, None, &gps).unwrap();
                assert!(
                    said.len() == 1 && said[0].contains("against the route"),
                    "{from_m} {side}: {said:?}"
                );
            }
        }
        // Standing, and backing up by less than positions may be off, is no drive against it.
        let mut backing = track(&route, 100.0, |_| Vector2::zeros());
        backing.truncate(3);
        backing.reverse();
        assert!(check(&config, &route, None, &backing).unwrap().is_empty());
    }

    #[test]
    fn a_start_off_the_route_is_refused() {
        let (route, config) = (route(), RouteProgressConfig::default());
        for start_m in [-1.0, f64::NAN, f64::INFINITY, route.polyline().unwrap().length_m() + 1.0] {
            assert!(check(&config, &route, Some(start_m), &[]).is_err(), "{start_m}");
        }
    }
}
