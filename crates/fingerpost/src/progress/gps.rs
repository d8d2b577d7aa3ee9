//! What GPS says of the progress.
//!
//! Its error is mostly slow, and a part of the state; a fix adds what has changed since the one before. A receiver that stands,
//! repeats itself or jumps is no new witness.

use std::f64::consts::PI;

use fingerpost_geometry::Polyline;
use nalgebra::Point2;

use super::component::{Component, GPS, PROGRESS, gaussian};
use super::mixture::Mixture;
use super::noise::Noise;
use super::{Progress, WORKING};
use crate::progress::elsewhere::Elsewhere;

mod feet;

use self::feet::{Feet, Foot};

/// What became of a GPS position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GpsUse {
    /// It agrees with what was believed, or is the first that is known.
    Accepted {
        /// Measured minus believed distance along the route, of the likeliest component, metres; 0 where there was none.
        innovation_m: f64,
    },
    /// It contradicts most of what was believed, and was taken as a jump of the receiver, or of the vehicle.
    Jumped {
        /// Measured minus believed distance along the route, of the likeliest component, metres.
        innovation_m: f64,
    },
    /// It lies too far from the route and was not used.
    OffRoute {
        /// Distance from the route, metres.
        distance_m: f64,
    },
    /// The vehicle has not moved since the last fix, or the receiver repeats it to the bit, or it is no number: it tells nothing.
    NothingNew,
}

/// A fix farther from what a component expects is a jump to it, standard deviations.
const GATE_SIGMAS: f64 = 3.0;
/// Probability that a receiver jumps between two fixes.
const JUMP_SHARE: f64 = 0.01;

/// What is remembered of the receiver.
#[derive(Debug, Clone)]
pub(super) struct Receiver {
    last_in_map: Option<Point2<f64>>,
    /// Metres driven since the last fix that was used.
    moved_m: f64,
    /// Share of what lies elsewhere of which no fix has told yet.
    untold_share: f64,
    jumps: u32,
}

impl Receiver {
    pub(super) const fn new() -> Self {
        Self { last_in_map: None, moved_m: 0.0, untold_share: 1.0, jumps: 0 }
    }

    pub(super) const fn jumps(&self) -> u32 {
        self.jumps
    }

    /// The vehicle moved on, and `lost` of the probability is to join the `elsewhere` that there is.
    pub(super) fn moved(&mut self, forward_m: f64, lost: f64, elsewhere: f64) {
        self.moved_m += forward_m;
        if lost > 0.0 {
            self.untold_share = (self.untold_share * elsewhere + lost) / (elsewhere + lost);
        }
    }

    fn repeats(&self, p_in_map: Point2<f64>, noise: &Noise) -> bool {
        self.last_in_map.is_some_and(|last| last == p_in_map || self.moved_m.abs() < noise.gps_white_m)
    }
}

/// Density of a fix of a receiver that jumped, per metre: mostly within the gate, but it may be anywhere (Cauchy).
fn jumped_per_m(innovation_m: f64, noise: &Noise) -> f64 {
    let gate_m = noise.gps_gate_m;
    1.0 / (PI * gate_m * (1.0 + (innovation_m / gate_m).powi(2)))
}

/// How a component takes a fix.
enum Taken {
    /// As one of these parts, together so likely.
    Sound { per_m: f64 },
    /// As a jump, so likely.
    Jump { per_m: f64 },
}

impl Progress {
    /// Takes in a GPS position, in the map frame, with `route` in the same.
    pub fn observe_gps(&mut self, route: &Polyline, p_in_map: Point2<f64>) -> GpsUse {
        let is_number = p_in_map.x.is_finite() && p_in_map.y.is_finite();
        if !is_number || self.receiver.repeats(p_in_map, &self.noise) {
            return GpsUse::NothingNew;
        }
        let feet = Feet::of(route, p_in_map, &self.noise);
        if feet.as_slice().is_empty() {
            return GpsUse::OffRoute { distance_m: feet.nearest_m() };
        }
        self.receiver.last_in_map = Some(p_in_map);
        self.receiver.moved_m = 0.0;
        let likeliest = self.components.as_slice().first().copied();
        let innovation_m = likeliest.and_then(|likeliest| feet.innovation_m(&likeliest)).unwrap_or_default();

        let mut weighed = Mixture::<WORKING>::new();
        let (mut best_per_m, mut jumped) = (0.0_f64, 0.0);
        for component in self.components.as_slice() {
            match component.take_fix(&feet, &self.noise, &mut weighed) {
                Taken::Sound { per_m } => best_per_m = best_per_m.max(per_m),
                Taken::Jump { per_m } => {
                    best_per_m = best_per_m.max(per_m);
                    jumped += component.weight;
                }
            }
        }
        let has_jumped = jumped > 0.5 * self.components.weight();
        if has_jumped {
            self.receiver.jumps = self.receiver.jumps.saturating_add(1);
        }
        let untold_share = if has_jumped || likeliest.is_none() { 1.0 } else { self.receiver.untold_share };
        self.receiver.untold_share = 0.0;
        for foot in feet.as_slice() {
            weighed.push(found_elsewhere(&self.elsewhere, foot, untold_share, &self.noise));
        }
        let noise = &self.noise;
        self.elsewhere.weigh(|route_m| {
            let jumped_per_m = JUMP_SHARE * jumped_per_m(feet.apart_m(route_m), noise);
            untold_share * jumped_per_m + (1.0 - untold_share) * best_per_m
        });
        self.settle(weighed);
        if has_jumped { GpsUse::Jumped { innovation_m } } else { GpsUse::Accepted { innovation_m } }
    }
}

/// The vehicle may be elsewhere, at `foot`, and the receiver right.
fn found_elsewhere(elsewhere: &Elsewhere, foot: &Foot, untold_share: f64, noise: &Noise) -> Component {
    let sigma_m = libm::hypot(noise.gps_slow_m, noise.gps_white_m);
    let weight = untold_share * (1.0 - JUMP_SHARE) * foot.weight * elsewhere.density(foot.along_m, sigma_m);
    // As after a fix when nothing was known: the progress errs as GPS does.
    let unknown_m = 1e3 * sigma_m;
    Component::at(weight, foot.along_m, unknown_m, noise).with_fix(foot.along_m, noise)
}

impl Component {
    /// Adds what a fix leaves of this component, and says how likely the fix was.
    fn take_fix(&self, feet: &Feet, noise: &Noise, weighed: &mut Mixture<WORKING>) -> Taken {
        let white_m2 = noise.gps_white_m.powi(2);
        let (_, before) = self.predicted(&GPS);
        let (expected_m, gate_m) = self.fix_within_m(noise);
        let within = || feet.as_slice().iter().filter(|foot| (foot.along_m - expected_m).abs() <= gate_m);
        let nearest_weight = within().map(|foot| foot.weight).fold(0.0, f64::max);
        let mut sound_per_m = 0.0;
        for foot in within() {
            // How far a fix lies beside the road errs for as long as its error along it: it tells passes of the same place apart,
            // once, and says nothing against the only pass.
            let per_m = (1.0 - JUMP_SHARE)
                * (foot.weight / nearest_weight)
                * gaussian(foot.along_m - expected_m, before + white_m2);
            let part = self.with_fix(foot.along_m, noise);
            weighed.push(Self { weight: self.weight * per_m, ..part });
            sound_per_m += per_m;
        }
        if sound_per_m > 0.0 {
            return Taken::Sound { per_m: sound_per_m };
        }
        let innovation_m = feet.innovation_m(self).unwrap_or_default();
        let per_m = JUMP_SHARE * jumped_per_m(innovation_m, noise);
        let jumped = self.after_jump(expected_m + innovation_m, noise);
        weighed.push(Self { weight: self.weight * per_m, ..jumped });
        Taken::Jump { per_m }
    }

    /// Where along the route a fix is expected, and how far from there it may be, metres.
    fn fix_within_m(&self, noise: &Noise) -> (f64, f64) {
        let (expected_m, before) = self.predicted(&GPS);
        (expected_m, GATE_SIGMAS * (before + noise.gps_white_m.powi(2)).sqrt())
    }

    /// The same after a fix of a receiver that has not jumped.
    #[must_use]
    pub(crate) fn with_fix(&self, fix_m: f64, noise: &Noise) -> Self {
        self.measured(&GPS, fix_m, noise.gps_white_m.powi(2))
    }

    /// The receiver jumped to `fix_m`: back to where a sound one may be, or to an error that it keeps.
    #[must_use]
    pub(crate) fn after_jump(&self, fix_m: f64, noise: &Noise) -> Self {
        let (route_m, variance) = self.predicted(&PROGRESS);
        let (slow_m, white_m2) = (noise.gps_slow_m, noise.gps_white_m.powi(2));
        let apart_m = fix_m - route_m;
        let is_sound = apart_m.abs() <= GATE_SIGMAS * (variance + slow_m * slow_m + white_m2).sqrt();
        let (level_m, sigma_m) = if is_sound { (0.0, slow_m) } else { (apart_m, noise.gps_gate_m) };
        self.with_gps_error(level_m, sigma_m).with_fix(fix_m, noise)
    }
}
