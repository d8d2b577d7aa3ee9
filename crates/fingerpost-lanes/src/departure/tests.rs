use super::*;
use crate::geometry::EdgeOnRoad;
use fingerpost_control::TurnSignal;

const DT_S: f64 = 0.05;
/// Half of the lane and of the vehicle, metres.
const HALF_LANE_M: f64 = 1.75;
const HALF_BODY_M: f64 = 0.9;

/// A warning with what its frames need.
#[derive(Default)]
struct Watch {
    warning: DepartureWarning,
    config: DepartureConfig,
    left_m: f64,
}

impl Watch {
    fn step(&mut self, lane: &LaneOnRoad, turn_signal: TurnSignal, dt_s: f64) -> DepartureOutput {
        let state = VehicleState { speed_mps: Some(20.0), yaw_rate_rps: Some(0.0), turn_signal };
        self.warning.step(&self.config, &VehicleConfig::default(), lane, &state, dt_s).0
    }

    /// Drives on for a while with all edges in view, moving across at `lateral_mps`, positive to the left; what was said.
    fn see(&mut self, for_s: f64, lateral_mps: f64, turn_signal: TurnSignal) -> Vec<DepartureOutput> {
        let frames = (for_s / DT_S).round() as usize;
        let seen = (0..frames).map(|_| {
            self.left_m += DT_S * lateral_mps;
            self.look(lateral_mps, turn_signal, DT_S)
        });
        seen.collect()
    }

    /// One frame with all edges in view, `dt_s` after the one before.
    fn look(&mut self, lateral_mps: f64, turn_signal: TurnSignal, dt_s: f64) -> DepartureOutput {
        let edge = |offset_m: f64| {
            let heading_rad = -(lateral_mps / 20.0);
            Some(EdgeOnRoad { offset_m: offset_m - self.left_m, heading_rad, ..EdgeOnRoad::default() })
        };
        let lane = LaneOnRoad { left: edge(HALF_LANE_M), right: edge(-HALF_LANE_M) };
        self.step(&lane, turn_signal, dt_s)
    }

    /// Drives on for a while without any edge in view.
    fn miss(&mut self, for_s: f64) -> DepartureOutput {
        let frames = (for_s / DT_S).round() as usize;
        (0..frames)
            .map(|_| self.step(&LaneOnRoad::default(), TurnSignal::Off, DT_S))
            .last()
            .unwrap_or_default()
    }
}

fn warned(said: &[DepartureOutput]) -> bool {
    said.iter().any(|output| output.warning.is_some())
}

fn silent_because(said: &[DepartureOutput], silence: Silence) -> bool {
    said.iter().any(|output| output.silence == Some(silence))
}

/// A vehicle whose left wheels are 0.15 m from the edge when its edges come back into view.
fn beside_the_edge() -> Watch {
    Watch { left_m: HALF_LANE_M - HALF_BODY_M - 0.15, ..Watch::default() }
}

#[test]
fn a_place_beyond_an_edge_after_a_gap_in_time_is_no_departure() {
    for i in 0..400 {
        // Multiples of irrational numbers spread evenly over gaps, places and drifts.
        let part = |factor: f64| (factor * f64::from(i)).fract();
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let mut watch = beside_the_edge();
        watch.left_m *= side * part(0.618_034);
        let drift_mps = side * (0.05 + 0.3 * part(0.414_214));
        watch.see(1.0, 0.05 * drift_mps, TurnSignal::Off);
        let gap_s = 0.6 + 20.0 * part(0.732_051);
        // Nobody saw how the wheel came over the edge.
        watch.left_m = side * (HALF_LANE_M - HALF_BODY_M + 0.01 + 0.2 * part(0.236_068));
        let mut said = vec![watch.look(drift_mps, TurnSignal::Off, gap_s)];
        said.extend(watch.see(0.5, drift_mps, TurnSignal::Off));
        assert!(!warned(&said), "after {gap_s} s at {drift_mps} m/s");
    }
}

#[test]
fn a_drift_after_a_gap_is_warned_of() {
    let mut watch = beside_the_edge();
    watch.see(2.0, 0.0, TurnSignal::Off);
    assert_eq!(watch.miss(4.0).lateral_speed_mps, None);
    assert!(warned(&watch.see(2.0, 0.4, TurnSignal::Off)));
}

#[test]
fn a_signal_before_a_gap_is_still_the_drivers_intent_behind_it() {
    let mut watch = beside_the_edge();
    watch.config.signal_hold_s = 8.0;
    watch.see(2.0, 0.0, TurnSignal::Left);
    assert_eq!(watch.miss(4.0).lateral_speed_mps, None, "no edge is known any more");
    let said = watch.see(2.0, 0.4, TurnSignal::Off);
    assert!(!warned(&said) && silent_because(&said, Silence::TurnSignal), "{said:?}");
}

#[test]
fn a_signal_ages_while_nothing_is_seen() {
    let mut watch = beside_the_edge();
    watch.see(2.0, 0.0, TurnSignal::Left);
    watch.miss(6.0);
    assert!(warned(&watch.see(2.0, 0.4, TurnSignal::Off)));
}

#[test]
fn a_signal_that_comes_while_nothing_is_seen_counts() {
    let mut watch = beside_the_edge();
    for _ in 0..40 {
        let nothing = watch.step(&LaneOnRoad::default(), TurnSignal::Left, DT_S);
        assert_eq!(nothing, DepartureOutput::default());
    }
    let said = watch.see(2.0, 0.4, TurnSignal::Off);
    assert!(!warned(&said) && silent_because(&said, Silence::TurnSignal), "{said:?}");
}

#[test]
fn a_lane_change_goes_on_where_no_edge_is_seen() {
    let mut watch = beside_the_edge();
    watch.config.cool_down_s = 0.0;
    // Over the left edge, and on into the next lane without a line in view.
    watch.see(2.0, 0.4, TurnSignal::Left);
    assert_eq!(watch.miss(6.0).lateral_speed_mps, None);
    watch.left_m = HALF_LANE_M - HALF_BODY_M - 0.15;
    let said = watch.see(1.0, 0.4, TurnSignal::Off);
    assert!(!warned(&said) && silent_because(&said, Silence::LaneChange), "{said:?}");
    // Once it has kept between two edges, the next drift is one again.
    watch.left_m = 0.0;
    watch.see(6.0, 0.0, TurnSignal::Off);
    assert!(warned(&watch.see(4.0, 0.4, TurnSignal::Off)));
}

#[test]
fn a_seam_that_is_taken_for_an_edge_for_a_moment_is_no_lane_change() {
    let mut watch = Watch::default();
    watch.see(2.0, 0.0, TurnSignal::Off);
    // Towards the seam, faster than what is taken for a drift.
    assert!(!warned(&watch.see(1.5, -0.3, TurnSignal::Off)));
    let edge = |offset_m| Some(EdgeOnRoad { offset_m, heading_rad: 0.015, ..EdgeOnRoad::default() });
    let seam = LaneOnRoad { left: None, right: edge(0.1) };
    for _ in 0..2 {
        assert!(!warned(&[watch.step(&seam, TurnSignal::Off, DT_S)]));
    }
    let drift = watch.see(3.2, 0.5, TurnSignal::Off);
    assert!(warned(&drift) && !silent_because(&drift, Silence::LaneChange), "{drift:?}");
}

#[test]
fn edges_of_another_lane_are_a_lane_change() {
    let drift_with_left_edge_moved_by = |farther_m: f64| {
        let mut watch = Watch::default();
        watch.see(2.0, 0.0, TurnSignal::Off);
        watch.see(1.0, -0.4, TurnSignal::Off);
        let edge = |offset_m| Some(EdgeOnRoad { offset_m, heading_rad: 0.02, ..EdgeOnRoad::default() });
        let lane = |moved_m: f64| LaneOnRoad {
            left: edge(HALF_LANE_M + 0.4 + moved_m + farther_m),
            right: edge(-HALF_LANE_M + 0.4 + moved_m),
        };
        let moved_m = |frame| 0.4 * DT_S * f64::from(frame);
        (1..40).map(|frame| watch.step(&lane(moved_m(frame)), TurnSignal::Off, DT_S)).collect::<Vec<_>>()
    };
    let another_lane = drift_with_left_edge_moved_by(2.5);
    assert!(!warned(&another_lane) && silent_because(&another_lane, Silence::LaneChange), "{another_lane:?}");
    assert!(warned(&drift_with_left_edge_moved_by(1.5)));
}
