//! Nights, showers, other vehicles and shadows: where they must be, and the same bytes however they are made.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost_sim::{Conditions, RoadCourse, SimConfig, SimFrame, Simulator, windscreen_camera};

/// On a straight road that runs east, at 20 m/s.
fn simulator(conditions: Conditions, [width, height]: [usize; 2]) -> Simulator {
    let (graph, route) = RoadCourse::straight(400.0).roads().unwrap();
    let config = SimConfig { conditions, cruise_speed_mps: 20.0, end_gap_m: 150.0, ..SimConfig::default() };
    Simulator::new(&graph, &route, &windscreen_camera(width, height).unwrap(), &config).unwrap()
}

fn grey(frame: &SimFrame, u: f64, v: f64) -> f64 {
    let [r, g, b] = frame.picture.get(u.round() as usize, v.round() as usize).unwrap().map(f64::from);
    (r + g + b) / 3.0
}

#[test]
fn bytes_do_not_depend_on_threads_or_order() {
    for conditions in
        [Conditions::LANE_TRAFFIC, Conditions::LANE_NIGHT, Conditions::LANE_RAIN, Conditions::LANE_SHADOWS]
    {
        let on_threads = |threads: usize, indices: [usize; 2]| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| indices.map(|index| simulator(conditions, [160, 120]).frame(index)))
        };
        let (one, [last, first]) = (on_threads(1, [4, 60]), on_threads(2, [60, 4]));
        assert!(one == [first, last], "the frames differ");
    }
}

#[test]
fn the_lane_is_where_it_is_whatever_the_day() {
    let truth = |conditions| simulator(conditions, [160, 120]).truth(30);
    let plain = truth(Conditions { lanes: Conditions::LANE_TRAFFIC.lanes, ..Conditions::LANE_CONTINUOUS });
    for other in [
        Conditions::LANE_TRAFFIC,
        Conditions::LANE_NIGHT,
        Conditions::LANE_RAIN,
        Conditions::LANE_SHADOWS,
        Conditions::LANE_PATCHES,
        Conditions::LANE_WORN,
    ] {
        assert_eq!(truth(other), plain);
    }
}

#[test]
fn at_night_paint_shines_and_lamps_dazzle() {
    let bare = Conditions {
        trees_per_100_m: 0.0,
        houses_per_100_m: 0.0,
        noise_levels: 0.0,
        ..Conditions::LANE_NIGHT
    };
    let night = simulator(bare, [640, 480]).frame(30);
    let unlit = simulator(Conditions { lamps: 0.0, ..bare }, [640, 480]).frame(30);
    let edge = night.truth.lane_right_px.iter().find(|pixel| pixel[1] < 300.0).unwrap();
    let (paint, road) = (grey(&unlit, edge[0] + 4.0, edge[1]), grey(&unlit, edge[0] - 8.0, edge[1]));
    assert!(paint > 2.0 * road && road > 10.0, "{paint} on {road}");
    assert!(grey(&night, 320.0, 30.0) < 60.0, "a dark sky");
    let pairs = night.picture.as_slice().chunks_exact(3).zip(unlit.picture.as_slice().chunks_exact(3));
    let dazzled = pairs.filter(|(lit, dark)| lit[1] > dark[1].saturating_add(60)).count();
    assert!(dazzled > 20, "{dazzled} pixels");
}

#[test]
fn the_rails_shadow_lies_where_the_sun_throws_it() {
    // The sun stands in the south, 0.6 rad high: a metre of height throws its shadow 1.46 m to the north.
    let sunny = Conditions {
        sun_azimuth_rad: -std::f64::consts::FRAC_PI_2,
        sun_elevation_rad: 0.6,
        guard_rails: 1.0,
        trees_per_100_m: 0.0,
        houses_per_100_m: 0.0,
        noise_levels: 0.0,
        road_wear: 0.0,
        posts_per_100_m: 0.0,
        ..Conditions::LANE_SHADOWS
    };
    let simulator = simulator(Conditions { markings: Conditions::LANE_NONE.markings, ..sunny }, [640, 480]);
    let frame = simulator.frame(20);
    let camera = simulator.camera_at(20).unwrap();
    // The road is 8 m wide, the rail 0.6 m beside it, its plank from 0.45 to 0.76 m high.
    let at = |south_m: f64| {
        let p = nalgebra::Point2::new(9.0, -south_m - frame.truth.y_m);
        let pixel = camera.pixel_of_ground(p).unwrap();
        grey(&frame, pixel.u, pixel.v)
    };
    let throw = 1.0 / libm::tan(0.6_f64);
    let (near, far) = (4.6 - 0.76 * throw, 4.6 - 0.45 * throw);
    let (lit, dark) = (at(near - 0.12), at(0.5 * (near + far)));
    assert!(dark < 0.75 * lit, "{dark} beside {lit}");
    assert!(at(near + 0.08) < 0.8 * lit, "just inside");
}

#[test]
fn drops_and_vehicles_hide_and_change_the_picture() {
    let dry = Conditions { rain: 0.0, ..Conditions::LANE_RAIN };
    let frames = [Conditions::LANE_RAIN, dry, Conditions { traffic: 0.0, ..dry }]
        .map(|conditions| simulator(conditions, [320, 240]).frame(35));
    let differing = |one: &SimFrame, other: &SimFrame| {
        one.picture.as_slice().iter().zip(other.picture.as_slice()).filter(|(a, b)| a != b).count()
    };
    assert!(differing(&frames[0], &frames[1]) > 5000, "rain");
    assert!(differing(&frames[1], &frames[2]) > 500, "vehicles");
    let hidden = frames[1].road.as_slice().iter().zip(frames[2].road.as_slice());
    assert!(hidden.filter(|(with, without)| with < without).count() > 20, "vehicles hide the road");
}
