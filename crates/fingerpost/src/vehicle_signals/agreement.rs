//! Whether a signal of the bus agrees with the camera over what has been driven.
//!
//! A single frame tells little: a yaw rate of the wrong sign is small while the road is straight, and a speed may be a quarter
//! off for a moment because the road is wet. So both are summed over stretches, at least 25 m driven or 15 degrees turned.
//! Bends to either side count as one where the bus turns from one to the other: on a winding road they would cancel, and a
//! wrong sign with them. The relative difference of the sums is held against what two sound instruments can differ by. What it
//! exceeds that by is evidence, gathered with Page's cumulative sum test: the logarithm of a likelihood ratio, never below
//! zero, that names a disagreement at [`ENOUGH`].
//!
//! Nothing says which of the two is wrong: the camera's metres are as good as its calibrated height.

use std::f64::consts::PI;

/// Evidence that is enough, ln(1e6). By Lorden (Procedures for reacting to a change in distribution, 1971), a false alarm then
/// comes twice in a million stretches at the most, 12 000 km driven, even where both differ by all that is allowed.
const ENOUGH: f64 = 13.815_510_557_964_274;
/// Longest stretch, seconds: a bias adds up over time, and so a longer one would tell nothing.
const LONGEST_S: f64 = 20.0;
/// Latency of a bus, seconds: a filtered wheel speed that goes through a gateway.
const LATENCY_S: f64 = 0.3;
/// What a change of the rate makes of that latency is waited out until it is no more than this share of the scale error: a turn is
/// judged when it is over.
const LATENCY_SHARE: f64 = 0.25;

/// By what a sound bus and a sound camera may differ.
#[derive(Debug, Clone, Copy)]
pub(super) struct AgreementLimits {
    /// What a stretch sums up to, metres or radians.
    pub(super) stretch: f64,
    /// From how much a second the bus says which way it goes, forward or back, left or right: beyond bias and noise.
    pub(super) clear: f64,
    /// Largest scale error of both together, as a share of the larger sum.
    pub(super) scale: f64,
    /// Largest bias, per second.
    pub(super) bias: f64,
    /// Standard deviation of a stretch's relative difference.
    pub(super) sigma: f64,
    /// Relative differences beyond what is allowed that are to be found soonest, each by a test of its own, two at the most: a
    /// small one, and one as of a wrong sign, which few stretches tell then. The first decides when both agree again.
    pub(super) sought: &'static [f64],
    /// Fewest stretches that name a disagreement: a lorry that fills the picture makes any difference, but not for long.
    pub(super) least_stretches: f64,
}

impl AgreementLimits {
    /// Of the speed: tyres and the camera's height are each known to 5 %, the way by the road's texture to 2 %; wheels are told in
    /// steps of up to half a metre a second; 30 % too fast is 0.23 of the larger, a tenth beyond.
    pub(super) const SPEED: Self = Self {
        stretch: 25.0,
        clear: 1.0,
        scale: 0.12,
        bias: 0.25,
        sigma: 0.06,
        sought: &[0.08],
        least_stretches: 5.0,
    };
    /// Of the yaw rate: 5 % of gain each, and the bias of half a degree a second that gyroscopes of series cars have.
    pub(super) const YAW_RATE: Self = Self {
        stretch: PI / 12.0,
        clear: PI / 180.0,
        scale: 0.1,
        bias: PI / 360.0,
        sigma: 0.1,
        sought: &[0.1, 1.0],
        least_stretches: 3.0,
    };

    /// Evidence for a relative difference as the one sought, from one that exceeds the scale error by so much, where bias and
    /// latency may add `other`: the less sure a stretch is, the less it weighs.
    fn evidence(&self, sought: f64, excess: f64, other: f64) -> f64 {
        let variance = self.sigma.powi(2) + other.powi(2);
        let weight = sought / variance;
        (weight * (excess - other) - 0.5 * weight * weight * variance).min(ENOUGH / self.least_stretches)
    }
}

/// A signal of the bus and the camera that do not agree: what both say of the same stretches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disagreement {
    /// By the bus: metres driven, or radians turned.
    pub bus: f64,
    /// By the camera; of turns, those to either side count as one, so that a wrong sign stays one.
    pub camera: f64,
    /// By what share of the larger they may differ.
    pub allowed_share: f64,
}

/// A stretch that is being driven.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    bus: f64,
    camera: f64,
    /// Of the time to one side less that to the other, seconds: a bias of the bus adds up over no more.
    one_sided_s: f64,
    time_s: f64,
    /// What a latency may have moved the sums by at each change of side.
    by_latency: f64,
    /// What the camera said at the beginning of the stretch, or when the side changed last.
    first_camera: Option<f64>,
}

/// Evidence of one kind with the stretches that it comes from.
#[derive(Debug, Clone, Copy, Default)]
struct Evidence {
    sum: f64,
    bus: f64,
    camera: f64,
}

/// What has been gathered for and against a signal.
#[derive(Debug, Clone)]
pub(super) struct Agreement {
    limits: AgreementLimits,
    stretch: Stretch,
    /// To which side the bus went when that was last clear, as a sign.
    side: f64,
    /// That the bus says more than the camera, and less, for each difference that is sought.
    more_and_less: [[Evidence; 2]; 2],
    /// That they agree again.
    agreeing: f64,
    found: Option<Disagreement>,
}

impl Agreement {
    pub(super) fn new(limits: AgreementLimits) -> Self {
        Self {
            limits,
            stretch: Stretch::default(),
            side: 1.0,
            more_and_less: [[Evidence::default(); 2]; 2],
            agreeing: 0.0,
            found: None,
        }
    }

    /// The disagreement that stands.
    pub(super) const fn found(&self) -> Option<Disagreement> {
        self.found
    }

    /// Takes in what both say of the last `dt_s`, per second.
    pub(super) fn add(&mut self, bus: f64, camera: f64, dt_s: f64) {
        let stretch = &mut self.stretch;
        let change = |from: f64| LATENCY_S * (camera - from).abs();
        if bus.abs() >= self.limits.clear && bus * self.side < 0.0 {
            self.side = bus.signum();
            stretch.by_latency += stretch.first_camera.replace(camera).map_or(0.0, change);
        }
        stretch.bus += self.side * bus * dt_s;
        stretch.camera += self.side * camera * dt_s;
        stretch.one_sided_s += self.side * dt_s;
        stretch.time_s += dt_s;
        let by_latency = change(*stretch.first_camera.get_or_insert(camera));
        let larger = stretch.bus.abs().max(stretch.camera.abs());
        let (is_long, is_late) = (larger >= self.limits.stretch, stretch.time_s > LONGEST_S);
        let is_settled = by_latency <= LATENCY_SHARE * self.limits.scale * larger;
        if is_late || is_long && is_settled {
            let mut ended = std::mem::take(stretch);
            ended.by_latency += by_latency;
            if is_long {
                self.judge(&ended);
            }
        }
    }

    /// Judges a stretch.
    fn judge(&mut self, stretch: &Stretch) {
        let Stretch { bus, camera, one_sided_s, by_latency, .. } = *stretch;
        let limits = &self.limits;
        // A small sum has the sign of its noise, so that the side is that of the larger one unless the camera's is clear.
        let side = if camera.abs() < 0.25 * bus.abs() { bus.signum() } else { camera.signum() };
        let larger = bus.abs().max(camera.abs());
        let difference = side * (bus - camera) / larger;
        let other = (limits.bias * one_sided_s.abs() + by_latency) / larger;
        if self.found.is_some() {
            let sought = limits.sought.first().copied().unwrap_or_default();
            let evidence = limits.evidence(sought, limits.scale + other - difference.abs(), other);
            self.agreeing = (self.agreeing + evidence).max(0.0);
            if self.agreeing >= ENOUGH {
                *self = Self::new(*limits);
            }
            return;
        }
        for (&sought, more_and_less) in limits.sought.iter().zip(&mut self.more_and_less) {
            for (sign, evidence) in [1.0, -1.0].into_iter().zip(more_and_less) {
                evidence.sum += limits.evidence(sought, sign * difference - limits.scale, other);
                evidence.bus += side * bus;
                evidence.camera += side * camera;
                if evidence.sum <= 0.0 {
                    *evidence = Evidence::default();
                } else if evidence.sum >= ENOUGH {
                    let Evidence { bus, camera, .. } = *evidence;
                    self.found = Some(Disagreement { bus, camera, allowed_share: limits.scale });
                }
            }
        }
    }
}
