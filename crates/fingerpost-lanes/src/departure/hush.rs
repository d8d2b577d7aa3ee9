//! When a wheel at the edge of its lane is no cause for a warning.

use super::DepartureConfig;
use super::filter::Seen;
use crate::Side;
use fingerpost_control::{TurnSignal, VehicleState};

/// How long a warning stays at the most, seconds: who has not reacted by then will not.
const LONGEST_WARNING_S: f64 = 3.0;
/// Speed across a lane below which the vehicle has settled in it, m/s.
pub(super) const SETTLED_MPS: f64 = 0.3;

/// Why no warning is given although a wheel is at an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Silence {
    /// The driver signals towards that side, or has done so just before.
    TurnSignal,
    /// The vehicle is slow. One whose speed is not known is not: a standing one is seen to stand.
    Slow,
    /// The vehicle has crossed an edge and has not settled in a lane since.
    LaneChange,
    /// There has been a warning just before.
    CoolDown,
}

impl Silence {
    /// The reason as it stands in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::TurnSignal => "turn_signal",
            Self::Slow => "slow",
            Self::LaneChange => "lane_change",
            Self::CoolDown => "cool_down",
        }
    }
}

/// What happened lately.
#[derive(Debug, Clone)]
pub(super) struct Hush {
    /// Since the driver signalled to the left and to the right, seconds.
    since_signal_s: [f64; 2],
    /// Since the last warning began, seconds.
    since_warning_s: f64,
    slow: bool,
    /// While a lane is being changed, for how long the vehicle has been settled, seconds.
    changing: Option<f64>,
    /// Whether the vehicle has been inside of the edge that is known on the left, on the right.
    has_been_inside: [bool; 2],
}

impl Default for Hush {
    fn default() -> Self {
        Self {
            since_signal_s: [f64::INFINITY; 2],
            since_warning_s: f64::INFINITY,
            slow: false,
            changing: None,
            has_been_inside: [false; 2],
        }
    }
}

impl Hush {
    /// What the vehicle says in a frame.
    pub(super) fn begin_frame(
        &mut self,
        config: &DepartureConfig,
        state: &VehicleState,
        speed_mps: Option<f64>,
        seen: &Seen,
        dt_s: f64,
    ) {
        for (inside, other_edge) in self.has_been_inside.iter_mut().zip(seen.other_edge) {
            *inside &= !other_edge;
        }
        self.slow = speed_mps.is_some_and(|mps| mps < config.min_speed_mps);
        self.since_warning_s += dt_s;
        for (since_s, signal) in self.since_signal_s.iter_mut().zip([TurnSignal::Left, TurnSignal::Right]) {
            *since_s = if state.turn_signal == signal { 0.0 } else { *since_s + dt_s };
        }
        if seen.lane_changed {
            self.changing = Some(0.0);
        }
    }

    /// Nothing is known any more of where the vehicle was between its edges; what the driver meant stays.
    pub(super) const fn forget_edges(&mut self) {
        self.has_been_inside = [false; 2];
    }

    /// Whether the vehicle has been inside of the edge that is known on that side.
    pub(super) const fn has_been_inside(&self, side: Side) -> bool {
        self.has_been_inside[side.index()]
    }

    /// Why a wheel at the edge on that side is passed over.
    pub(super) fn silence(&self, config: &DepartureConfig, side: Side) -> Option<Silence> {
        if self.since_signal_s[side.index()] <= config.signal_hold_s {
            Some(Silence::TurnSignal)
        } else if self.slow {
            Some(Silence::Slow)
        } else if self.changing.is_some() {
            Some(Silence::LaneChange)
        } else if self.since_warning_s < config.cool_down_s {
            Some(Silence::CoolDown)
        } else {
            None
        }
    }

    pub(super) const fn has_warned(&mut self) {
        self.since_warning_s = 0.0;
    }

    pub(super) fn has_warned_long_enough(&self) -> bool {
        self.since_warning_s > LONGEST_WARNING_S
    }

    /// A lane change that is under way goes on; nothing tells whether the vehicle keeps between two edges.
    pub(super) fn unsettle(&mut self) {
        self.changing = self.changing.map(|_| 0.0);
    }

    /// A wheel that has come over an edge begins a lane change, warned of or not; it ends when the vehicle keeps between two
    /// edges. An edge that comes into view under the vehicle is none that was crossed: it may be a seam.
    pub(super) fn end_frame(
        &mut self,
        config: &DepartureConfig,
        clearance_m: [Option<f64>; 2],
        lateral_mps: f64,
        dt_s: f64,
    ) {
        let least_m = clearance_m.into_iter().flatten().fold(f64::INFINITY, f64::min);
        let mut crossed = false;
        for (inside, clearance_m) in self.has_been_inside.iter_mut().zip(clearance_m) {
            *inside |= clearance_m.is_some_and(|m| m >= 0.0);
            crossed |= *inside && clearance_m.is_some_and(|m| m < 0.0);
        }
        if crossed {
            self.changing = Some(0.0);
        } else if let Some(settled_s) = &mut self.changing {
            let settled = least_m > config.hysteresis_m && lateral_mps.abs() < SETTLED_MPS;
            *settled_s = if settled { *settled_s + dt_s } else { 0.0 };
            if *settled_s >= config.settle_s {
                self.changing = None;
            }
        }
    }
}
