//! What the driver does, and what the truth says of it.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost_format::{Side, TruthRecord};
use fingerpost_sim::{
    Conditions, DrivingManner, DrivingPlan, Manoeuvre, RoadCourse, SimConfig, Simulator, windscreen_camera,
};

/// Half of the width of the vehicle over its tyres, and its wheelbase, metres.
const HALF_WIDTH_M: f64 = 0.9;
const WHEELBASE_M: f64 = 2.7;

fn simulator(course: &RoadCourse, speed_mps: f64, driving: DrivingPlan) -> Simulator {
    let (graph, route) = course.roads().unwrap();
    let bare = Conditions { trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::LANE_CONTINUOUS };
    let config = SimConfig {
        conditions: bare,
        cruise_speed_mps: speed_mps,
        end_gap_m: 100.0,
        fps: 20.0,
        driving,
        ..SimConfig::default()
    };
    Simulator::new(&graph, &route, &windscreen_camera(160, 120).unwrap(), &config).unwrap()
}

fn truths(simulator: &Simulator) -> Vec<TruthRecord> {
    (0..simulator.frames()).map(|index| simulator.truth(index)).collect()
}

#[test]
fn keeping_the_lane_sways_slowly_and_crosses_nothing() {
    for seed in 1..=3 {
        let course = RoadCourse::highway(seed, 1500.0);
        let plan = DrivingPlan::draw(DrivingManner::Keeping, seed, 5.0, 1500.0, 30.0);
        let simulator = simulator(&course, 30.0, plan);
        assert_eq!(simulator.crossings(), []);
        let mut swayed_m = 0.0_f64;
        for truth in truths(&simulator) {
            // Lanes are 3.5 m wide, lines 0.15 m: in the middle both edges are 1.675 m away.
            let aside_m = 0.5 * (truth.lane_left_m[0][1] + truth.lane_right_m[0][1]);
            swayed_m = swayed_m.max(aside_m.abs());
            assert_eq!(truth.turn_signal, None);
        }
        assert!((0.05..0.45).contains(&swayed_m), "{swayed_m} m");
    }
}

#[test]
fn a_drift_crosses_when_the_wheel_comes_over_the_edge() {
    for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        let drift = Manoeuvre::Drift { at_m: 100.0, side, lateral_mps: 0.5, reach_m: 1.3, hold_s: 1.0 };
        let plan = DrivingPlan { sway_m: 0.0, manoeuvres: vec![drift] };
        let simulator = simulator(&RoadCourse::straight(500.0), 20.0, plan);
        let crossings = simulator.crossings();
        assert_eq!(crossings.len(), 1, "{crossings:?}");
        assert_eq!(crossings[0].side, side);
        // The road's axis is the x axis; the vehicle's lane is 3.5 m wide to its right. A wheel is on the inner edge at
        // 1.675 m from the lane's middle.
        let wheel_m = |truth: &TruthRecord| {
            let front_m = WHEELBASE_M * libm::sin(truth.heading_rad);
            let out_m = sign * (truth.y_m + 1.75 + front_m.max(0.0) * f64::from(sign > 0.0))
                + if sign < 0.0 { (-front_m).max(0.0) } else { 0.0 };
            out_m + HALF_WIDTH_M * libm::cos(truth.heading_rad) - 1.675
        };
        let truths = truths(&simulator);
        let frame = crossings[0].frame as usize;
        assert!(wheel_m(&truths[frame]) > 0.0 && wheel_m(&truths[frame - 1]) <= 0.005);
        // Half a metre a second: 0.775 m after 1.55 s and half of the onset's 0.8 s, from 100 m at 20 m/s.
        assert!((crossings[0].t_s - (95.0 / 20.0 + 1.55 + 0.4)).abs() < 0.15, "{crossings:?}");
        let farthest = truths.iter().map(|truth| (truth.y_m + 1.75) * sign).fold(0.0, f64::max);
        assert!((farthest - 1.3).abs() < 0.01, "{farthest}");
        assert!((truths.last().unwrap().y_m + 1.75).abs() < 1e-3, "back in the middle");
    }
}

#[test]
fn a_lane_change_is_signalled_and_ends_in_the_next_lane() {
    let change = Manoeuvre::LaneChange { at_m: 150.0, side: Side::Left, for_s: 4.0 };
    let plan = DrivingPlan { sway_m: 0.0, manoeuvres: vec![change] };
    let course = RoadCourse { two_way: false, width_m: 9.4, ..RoadCourse::straight(700.0) };
    let simulator = simulator(&course, 25.0, plan);
    let truths = truths(&simulator);
    let signalled: Vec<f64> =
        truths.iter().filter(|truth| truth.turn_signal == Some(Side::Left)).map(|truth| truth.t_s).collect();
    let (first, last) = (signalled[0], signalled[signalled.len() - 1]);
    assert!((first - (145.0 / 25.0 - 2.0)).abs() < 0.1 && (last - first - 6.5).abs() < 0.2, "{first} {last}");
    let crossings = simulator.crossings();
    assert_eq!(crossings.len(), 1, "{crossings:?}");
    assert_eq!(truths[crossings[0].frame as usize].turn_signal, Some(Side::Left));
    let end = truths.last().unwrap();
    assert!((end.y_m - 1.75).abs() < 1e-3);
    for truth in [&truths[0], end] {
        assert!(
            (truth.lane_left_m[0][1] - 1.675).abs() < 0.02 && (truth.lane_right_m[0][1] + 1.675).abs() < 0.02
        );
    }
    let switched =
        truths.windows(2).filter(|pair| pair[1].lane_left_m[0][1] - pair[0].lane_left_m[0][1] > 3.0);
    assert_eq!(switched.count(), 1, "the lane becomes the next one once");
}

#[test]
fn a_stop_stands_and_goes_on() {
    let plan = DrivingPlan { sway_m: 0.2, manoeuvres: vec![Manoeuvre::Stop { at_m: 200.0, for_s: 5.0 }] };
    let simulator = simulator(&RoadCourse::straight(500.0), 20.0, plan);
    let truths = truths(&simulator);
    let standing: Vec<&TruthRecord> = truths.iter().filter(|truth| truth.speed_mps < 1e-9).collect();
    assert!((98..=102).contains(&standing.len()), "{} frames of 20 a second", standing.len());
    assert!(standing.iter().all(|truth| (truth.x_m - 200.0).abs() < 0.2 && truth.yaw_rate_rps.abs() < 1e-9));
    assert_eq!(standing[0].lane_left_m, standing[standing.len() - 1].lane_left_m);
    assert!(truths.last().unwrap().x_m > 390.0);
}

#[test]
fn the_place_on_the_road_is_known_without_lines() {
    let straight = simulator(&RoadCourse::straight(300.0), 20.0, DrivingPlan::default());
    let truth = straight.truth(40);
    let place = straight.road_place(40).unwrap();
    assert!((place.left_m - truth.y_m).abs() < 1e-9 && (place.half_width_m - 4.0).abs() < 1e-9);
    assert!((place.heading_rad - truth.heading_rad).abs() < 1e-9);
    let bends = simulator(&RoadCourse::country(3, 800.0), 20.0, DrivingPlan::default());
    for index in 0..bends.frames() {
        let place = bends.road_place(index).unwrap();
        assert!((place.left_m + 1.75).abs() < 0.02 && place.heading_rad.abs() < 0.02, "{index}: {place:?}");
    }
}

#[test]
fn plans_follow_from_their_seed_and_fit_the_road() {
    for manner in [DrivingManner::Drifting, DrivingManner::Changing, DrivingManner::Stopping] {
        let plan = |seed| DrivingPlan::draw(manner, seed, 5.0, 3000.0, 25.0);
        assert_eq!(plan(1), plan(1));
        assert_ne!(plan(1), plan(2));
        assert!(plan(1).manoeuvres.len() >= 3, "{manner:?}");
    }
}

#[test]
fn every_drift_of_a_drawn_plan_crosses_its_line_once() {
    let plan = DrivingPlan::draw(DrivingManner::Drifting, 4, 5.0, 2000.0, 20.0);
    let drifts = plan.manoeuvres.clone();
    let simulator = simulator(&RoadCourse::country(4, 2300.0), 20.0, plan);
    let crossings = simulator.crossings();
    let sides: Vec<Side> = crossings.iter().map(|crossing| crossing.side).collect();
    let planned = |manoeuvre: &Manoeuvre| match *manoeuvre {
        Manoeuvre::Drift { side, .. } => Some(side),
        _ => None,
    };
    assert_eq!(sides, drifts.iter().filter_map(planned).collect::<Vec<_>>());
}

#[test]
fn absurd_plans_are_named() {
    let drift =
        Manoeuvre::Drift { at_m: 10.0, side: Side::Left, lateral_mps: f64::NAN, reach_m: 1.0, hold_s: 0.0 };
    let driving = DrivingPlan { sway_m: 0.0, manoeuvres: vec![drift] };
    let refused = SimConfig { driving, ..SimConfig::default() }.check().unwrap_err().to_string();
    assert!(refused.starts_with("lateral_mps"), "{refused}");
}

#[test]
fn the_bus_says_speed_yaw_rate_and_turn_signal_of_the_truth() {
    let plan = DrivingPlan::draw(DrivingManner::Changing, 3, 5.0, 900.0, 25.0);
    let simulator = simulator(&RoadCourse::highway(3, 1000.0), 25.0, plan);
    let mut truths = truths(&simulator);
    let log = simulator.bus_log();
    let of_message = |id: &str| -> Vec<(f64, Vec<u8>)> {
        let lines = log.lines().filter_map(|line| {
            let [at, interface, frame] = line.split(' ').collect::<Vec<_>>().try_into().ok()?;
            assert_eq!(interface, "can0");
            let data = frame.strip_prefix(id)?.strip_prefix('#')?;
            let bytes = (0..data.len()).step_by(2).map(|i| u8::from_str_radix(&data[i..i + 2], 16).unwrap());
            Some((at.trim_matches(['(', ')']).parse().unwrap(), bytes.collect()))
        });
        lines.collect()
    };
    let (motions, levers) = (of_message("1A1"), of_message("316"));
    let last_s = truths[truths.len() - 1].t_s;
    assert_eq!(motions.len(), (50.0 * last_s + 1e-6) as usize + 1);
    assert_eq!(levers.len(), (10.0 * last_s + 1e-6) as usize + 1);
    // The driver's sway stops dead where the drive ends, a turn faster than what lies between two frames.
    truths.truncate(truths.len() - 10);
    let (mut fastest_deg, mut before) = (0.0_f64, None::<&TruthRecord>);
    for truth in &truths {
        let newest = |frames: &[(f64, Vec<u8>)]| {
            frames
                .iter()
                .rev()
                .find(|(t_s, _)| *t_s <= truth.t_s + 1e-9)
                .map(|(_, data)| data.clone())
                .unwrap()
        };
        let motion = newest(&motions);
        let speed_mps = 0.01 / 3.6 * f64::from(u16::from_le_bytes([motion[0], motion[1]]));
        let yaw_rate_deg = 0.1 * f64::from(i16::from_le_bytes([motion[2], motion[3]]));
        // Frames are 0.05 s apart, those of the bus 0.02 s: one may be half of that old, and braking is 1.5 m/s2.
        assert!((speed_mps - truth.speed_mps).abs() < 0.02, "{}: {speed_mps} m/s", truth.frame);
        let off_deg = yaw_rate_deg - truth.yaw_rate_rps.to_degrees();
        assert!(off_deg.abs() < 0.15, "{}: {off_deg} degrees a second off", truth.frame);
        let signalled = [None, Some(Side::Left), Some(Side::Right)][usize::from(newest(&levers)[0])];
        let changing = before.is_some_and(|before| before.turn_signal != truth.turn_signal);
        assert!(changing || signalled == truth.turn_signal, "{}: {signalled:?}", truth.frame);
        (fastest_deg, before) = (fastest_deg.max(yaw_rate_deg.abs()), Some(truth));
    }
    // What the heading itself does, whatever the truth says of its rate: half seconds of ten frames, and 25 of the bus.
    for (half, pair) in truths.chunks(10).map(|frames| &frames[0]).collect::<Vec<_>>().windows(2).enumerate()
    {
        let turned_rad = pair[1].heading_rad - pair[0].heading_rad;
        let turned_deg = libm::atan2(libm::sin(turned_rad), libm::cos(turned_rad)).to_degrees();
        let rates = &motions[25 * half..25 * (half + 1)];
        let sum_deg: f64 =
            rates.iter().map(|(_, data)| 0.1 * f64::from(i16::from_le_bytes([data[2], data[3]]))).sum();
        assert!((0.02 * sum_deg - turned_deg).abs() < 0.06, "{half}: {} and {turned_deg}", 0.02 * sum_deg);
    }
    assert!(fastest_deg > 1.0, "something was turned: {fastest_deg} degrees a second");
    assert!(truths.iter().any(|truth| truth.turn_signal == Some(Side::Right)));
}
