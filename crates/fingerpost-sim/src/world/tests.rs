//! Drawn worlds against what they are drawn from.

use fingerpost_geometry::{Mount, View, wrap_angle};
use fingerpost_map::RoadAttributes;
use nalgebra::{Point2, Vector2};

use super::*;

fn town() -> OsmData {
    OsmData::from_bytes(include_bytes!("../../assets/town.osm")).unwrap()
}

/// Small pictures: what is tested is not in them.
const TINY: WorldOptions = WorldOptions {
    size_px: Some([64, 48]),
    fps: Some(4.0),
    features: None,
    route_m: None,
    ranges: WorldRanges::Usual,
};

fn worlds(seeds: std::ops::Range<u64>) -> Vec<World> {
    let town = town();
    seeds.map(|seed| World::draw(seed, &town, &TINY).unwrap()).collect()
}

fn mount(camera: &Camera) -> Mount {
    let View::Calibrated { mount, .. } = camera.view() else { panic!("every drawn camera has a lens") };
    *mount
}

fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

#[test]
fn cameras_cover_their_ranges_and_calibrations_are_off_by_what_they_are_said_to_be() {
    let drawn: Vec<DrawnCamera> = (0..600)
        .map(|seed| {
            let mut stream = Stream::new(seed, 1);
            let carrier = stream.choose(&ranges::VEHICLES).unwrap();
            DrawnCamera::draw(&mut stream, &carrier, &ranges::CAMERA, None).unwrap()
        })
        .collect();
    let mounts: Vec<[Mount; 2]> =
        drawn.iter().map(|drawn| [mount(&drawn.camera), mount(&drawn.calibration)]).collect();
    let off_deg = |angle: fn(&Mount) -> f64| -> f64 {
        let off = mounts.iter().map(|[real, known]| (angle(real) - angle(known)).to_degrees());
        spread(&off.collect::<Vec<_>>())
    };
    for (name, sigma_deg) in [
        ("pitch", off_deg(|mount| mount.pitch_rad)),
        ("yaw", off_deg(|mount| mount.yaw_rad)),
        ("roll", off_deg(|mount| mount.roll_rad)),
    ] {
        assert!((sigma_deg - 0.5).abs() < 0.06, "{name}: {sigma_deg} degrees");
    }
    let heights: Vec<f64> = mounts.iter().map(|[real, known]| real.height_m / known.height_m).collect();
    assert!((spread(&heights) - 0.03).abs() < 0.004, "{}", spread(&heights));
    let [low, high] = extent(mounts.iter().map(|[_, known]| known.height_m));
    assert!((1.0..1.1).contains(&low) && (2.65..2.8).contains(&high), "heights {low} to {high} m");
    let [low, high] = extent(mounts.iter().map(|[_, known]| known.pitch_rad.to_degrees()));
    assert!((2.0..3.5).contains(&low) && (15.0..20.0).contains(&high), "pitch {low} to {high} degrees");
    let field_deg = |camera: &Camera| {
        let row = 0.5 * (camera.height() as f64 - 1.0);
        let edge = |u: f64| camera.ray_in_camera(fingerpost_geometry::Pixel::new(u, row)).unwrap();
        edge(0.0).angle(&edge(camera.width() as f64 - 1.0)).to_degrees()
    };
    let [low, high] = extent(drawn.iter().map(|drawn| field_deg(&drawn.camera)));
    assert!((47.0..56.0).contains(&low) && (102.0..115.0).contains(&high), "fields {low} to {high} degrees");
}

#[test]
fn known_maps_are_off_by_what_they_are_said_to_be() {
    let town = town();
    let (mut largest_m, mut missing, mut invented, mut nodes_inside) = (0.0_f64, 0, 0, 0);
    let seeds = 1..=12;
    for seed in seeds.clone() {
        let roads = RoadGraph::from_osm(&drawn_map::as_built(&town, seed, 1.0)).unwrap();
        let mapped = drawn_map::as_mapped(&town, &roads, seed);
        for (real, known) in town.nodes.iter().zip(mapped.nodes.iter().filter(|node| node.id > 0)) {
            assert_eq!(real.id, known.id);
            let [real, known] = [real, known].map(|node| roads.plane().map_from_wgs84(node.at));
            largest_m = largest_m.max((real - known).norm());
        }
        assert!(mapped.nodes.is_sorted_by_key(|node| node.id) && mapped.ways.is_sorted_by_key(|way| way.id));
        invented += mapped.ways.iter().filter(|way| way.id < 0).count();
        missing += town.ways.len() - mapped.ways.iter().filter(|way| way.id > 0).count();
        nodes_inside += roads.nodes().iter().filter(|node| node.segments.len() == 2).count();
    }
    // Two metres, and three standard deviations of a node's own error both ways.
    assert!((1.5..2.0 + 0.75 * 2.0_f64.sqrt()).contains(&largest_m), "{largest_m} m");
    let drivable = town.ways.iter().filter(|way| RoadAttributes::from_tags(&way.tags).is_some()).count();
    let share = missing as f64 / (seeds.clone().count() * drivable) as f64;
    assert!((share - ranges::MISSING_WAYS).abs() < 0.02, "{share} of the ways are missing");
    let share = invented as f64 / nodes_inside as f64;
    assert!((share - ranges::INVENTED_ARMS).abs() < 0.01, "side roads at {share} of the nodes");
}

#[test]
fn streets_differ_from_their_tags_and_are_as_wide_all_along() {
    let town = town();
    let mut logs = Vec::new();
    for seed in 1..=8 {
        let built = drawn_map::as_built(&town, seed, 1.0);
        let mut of_name = std::collections::BTreeMap::new();
        for (known, real) in town.ways.iter().zip(&built.ways) {
            let widths = [known, real].map(|way| RoadAttributes::from_tags(&way.tags));
            let [Some(known), Some(real)] = widths else { continue };
            let log = libm::log(real.width_m / known.width_m);
            match known.name {
                Some(name) => {
                    let first = *of_name.entry(name).or_insert(log);
                    assert!((first - log).abs() < 1e-3, "one street, two factors");
                }
                None => logs.push(log),
            }
        }
        logs.extend(of_name.into_values());
    }
    assert!((spread(&logs) - ranges::WIDTH_LOG_SIGMA).abs() < 0.01, "{}", spread(&logs));
}

#[test]
fn routes_are_planned_on_the_known_map_and_driven_from_node_to_node_of_the_world() {
    let worlds = worlds(1..41);
    let (mut missing_features, mut left, mut apart_m) = (0, 0, 0.0_f64);
    for world in &worlds {
        let ids = |route: &Route| route.line.iter().map(|point| point.node.unwrap()).collect::<Vec<_>>();
        assert_eq!(ids(&world.route), ids(&world.driven));
        let plane = world.driven.plane().unwrap();
        let mut features = world.route.features.iter();
        for real in &world.driven.features {
            let known = features.find(|known| known.id == real.id).unwrap();
            let node = &world.roads.nodes()[world.roads.node_index(real.id).unwrap()];
            assert_eq!(real.at, node.at, "a feature is where the world has it");
            let [here, there] = [real.at, known.at].map(|at| plane.map_from_wgs84(at));
            apart_m = apart_m.max((here - there).norm());
            let line = world.driven.polyline().unwrap();
            assert!((line.at(real.route_m).0 - here).norm() < 1e-6);
        }
        missing_features += world.route.features.len() - world.driven.features.len();
        left += usize::from(world.config.traffic == TrafficSide::Left);
        assert!((world.start_m - world.config.start_m).abs() <= 3.0 * ranges::START_SIGMA_M);
    }
    assert!((0.8..3.1).contains(&apart_m), "{apart_m} m between a node and its place on the map");
    assert!((1..25).contains(&missing_features), "{missing_features} features that are not there");
    assert!((6..24).contains(&left), "{left} of 40 worlds drive on the left");
}

#[test]
fn the_truth_is_where_the_world_has_its_features() {
    for world in worlds(50..54) {
        let simulator = world.simulator().unwrap();
        let plane = world.driven.plane().unwrap();
        let mut seen = 0;
        for index in (0..simulator.frames()).step_by(5) {
            let truth = simulator.truth(index);
            let Some(id) = truth.feature_id else { continue };
            let node = &world.roads.nodes()[world.roads.node_index(id).unwrap()];
            let place = plane.map_from_wgs84(node.at);
            let (sin, cos) = libm::sincos(truth.heading_rad);
            let (forward, left) = (truth.feature_forward_m.unwrap(), truth.feature_left_m.unwrap());
            let claimed =
                Point2::new(truth.x_m + cos * forward - sin * left, truth.y_m + sin * forward + cos * left);
            assert!((claimed - place).norm() < 1e-6);
            seen += 1;
        }
        assert!(seen > 5);
    }
}

#[test]
fn vehicles_keep_to_the_road_and_their_side_of_it() {
    let (mut frames, mut over_the_edge) = (0, 0);
    for world in worlds(60..70) {
        let simulator = world.simulator().unwrap();
        let (mut off_road, mut on_side, mut straight) = (0, 0, 0);
        for index in 0..simulator.frames() {
            let truth = simulator.truth(index);
            let to_the_left = Vector2::new(-libm::sin(truth.heading_rad), libm::cos(truth.heading_rad));
            let place = Point2::new(truth.x_m, truth.y_m);
            off_road += usize::from(!simulator.is_on_road(place));
            let wheels = [0.5, -0.5].map(|side| place + to_the_left * (side * world.config.vehicle.track_m));
            over_the_edge += usize::from(wheels.iter().any(|wheel| !simulator.is_on_road(*wheel)));
            frames += 1;
            let Some(place) = simulator.road_place(index) else { continue };
            if wrap_angle(place.heading_rad).abs() < 0.05 && place.half_width_m > 2.6 {
                straight += 1;
                let side = if world.config.traffic == TrafficSide::Left { 1.0 } else { -1.0 };
                on_side += usize::from(place.left_m * side > 0.0);
            }
        }
        let seed = world.config.seed;
        assert_eq!(off_road, 0, "seed {seed}: frames with the rear axle beside the road");
        assert!(on_side * 10 >= straight * 9, "seed {seed}: {on_side} of {straight}");
    }
    // Lorries at square corners, and lanes of narrow roads.
    assert!(over_the_edge * 50 < frames, "{over_the_edge} of {frames} frames with a wheel beside the road");
}

#[test]
fn a_world_follows_from_its_seed_on_any_number_of_threads() {
    let frame = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let world = World::draw(3, &town(), &TINY).unwrap();
            (world.start_m, world.calibration.clone(), world.simulator().unwrap().frame(12))
        })
    };
    assert!(frame(1) == frame(2));
    let [one, other] = [3, 4].map(|seed| World::draw(seed, &town(), &TINY).unwrap());
    assert!(one.config != other.config && one.calibration != other.calibration);
}

#[test]
fn pictures_that_show_no_street_are_refused() {
    let ribbon = WorldOptions { size_px: Some([3000, 64]), ..WorldOptions::default() };
    let refused = World::draw(1, &town(), &ribbon).unwrap_err().to_string();
    assert!(refused.contains("3000 x 64"), "{refused}");
}

#[test]
fn wide_worlds_reach_from_low_narrow_cameras_to_high_wide_ones_and_make_drives() {
    let town = town();
    let options = WorldOptions { ranges: WorldRanges::Wide, ..TINY };
    let drawn: Vec<World> = (0..60).map(|seed| World::draw(seed, &town, &options).unwrap()).collect();
    let [low, high] = extent(drawn.iter().map(|world| mount(&world.camera).height_m));
    assert!(low < 0.8 && high > 2.4, "heights {low} to {high} m");
    let looks: Vec<crate::CameraLook> = drawn.iter().map(|world| world.config.conditions.camera).collect();
    let share = |is: fn(&crate::CameraLook) -> bool| looks.iter().filter(|look| is(look)).count();
    assert!((3..20).contains(&share(|look| look.saturation <= 0.0)), "grey cameras");
    assert!((6..28).contains(&share(|look| look.bonnet > 0.0)), "bonnets in view");
    assert!((12..45).contains(&share(|look| look.compression > 0.0)), "compressed pictures");
    assert!(drawn.iter().any(|world| world.config.conditions.kerbs > 0.0));
    for world in drawn.iter().step_by(12) {
        let frame = world.simulator().unwrap().frame(4);
        let road = frame.road.as_slice().iter().filter(|&&road| road > 0).count();
        assert!(road > 100, "{road} pixels of road");
    }
}
