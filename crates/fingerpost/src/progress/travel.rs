//! How far the vehicle came in a step: as measured by the camera, as the vehicle's bus says, or within what it can have done.

/// What is known of the distance that the vehicle came since the step before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Travel {
    /// Measured by the camera: it errs by the scale error, and by noise anew in each step.
    Measured {
        /// Distance forward, metres; negative backwards. A vehicle that stands gives 0.
        forward_m: f64,
        /// Standard deviation of the noise alone, metres.
        sigma_m: f64,
    },
    /// A speed from the vehicle's bus, whose error stays the same from step to step.
    Speed {
        /// Speed, metres a second; negative backwards.
        forward_mps: f64,
        /// Standard deviation, metres a second.
        sigma_mps: f64,
    },
    /// Nothing is known: the vehicle may have braked to a stop or gone as fast as it can since its speed was last known.
    Unknown,
}

/// No road vehicle is faster, metres a second: what says so is a fault and counts as unknown.
const IMPOSSIBLE_MPS: f64 = 100.0;
/// Speed that a vehicle may have by default, metres a second: 50 km/h, the limit in most towns. A vehicle that was seen to go
/// faster may go so again.
const TOWN_MPS: f64 = 50.0 / 3.6;
/// Hardest braking and acceleration, metres a second squared: dry tyres, and a strong car in its lowest gears.
const BRAKING_MPS2: f64 = 8.0;
const ACCELERATION_MPS2: f64 = 4.0;
/// A longer gap is this long, seconds: an hour, after which the vehicle may be anywhere.
const LONGEST_S: f64 = 3600.0;
/// Width of a uniform distribution in its standard deviations.
const UNIFORM_WIDTH: f64 = 3.464_101_615_137_754_6;

/// What a step adds to the progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) dt_s: f64,
    /// Distance that errs by the scale error, metres.
    pub(crate) measured_m: f64,
    /// Distance that does not, metres.
    pub(crate) unscaled_m: f64,
    /// Noise of this step alone, metres.
    pub(crate) white_sigma_m: f64,
    /// Standard deviation that has added up, in one direction, over the run of steps before this one, metres.
    pub(crate) run_before_m: f64,
    /// What this step adds to it, metres.
    pub(crate) run_added_m: f64,
}

/// Steps in a row whose error goes in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Run {
    /// Measured by the camera: no such error beside the scale's.
    Measured,
    /// By the bus's speed; standard deviation so far, metres.
    Speed { sigma_m: f64 },
    /// Nothing known; least and greatest distance so far, metres.
    Unknown { within_m: [f64; 2] },
}

/// The range of the vehicle's speed, and what has added up.
#[derive(Debug, Clone)]
pub(crate) struct Travelled {
    /// Least and greatest speed that the vehicle may have now, metres a second.
    within_mps: [f64; 2],
    fastest_mps: f64,
    run: Run,
}

impl Travelled {
    pub(crate) fn new() -> Self {
        Self { within_mps: [0.0, TOWN_MPS], fastest_mps: TOWN_MPS, run: Run::Measured }
    }

    /// What `travel` over `dt_s` seconds adds; none where no time passed or the time is no number.
    pub(crate) fn step(&mut self, travel: Travel, dt_s: f64, scale_sigma: f64) -> Option<Step> {
        if dt_s.is_nan() || dt_s <= 0.0 {
            return None;
        }
        let dt_s = dt_s.min(LONGEST_S);
        match travel {
            Travel::Measured { forward_m, sigma_m }
                if is_possible(forward_m / dt_s) && is_possible(sigma_m / dt_s) =>
            {
                let spread_mps = scale_sigma * forward_m.abs() / dt_s + sigma_m.abs() / dt_s;
                self.know(forward_m / dt_s, spread_mps);
                self.run = Run::Measured;
                Some(Step {
                    dt_s,
                    measured_m: forward_m,
                    unscaled_m: 0.0,
                    white_sigma_m: sigma_m.abs(),
                    run_before_m: 0.0,
                    run_added_m: 0.0,
                })
            }
            Travel::Speed { forward_mps, sigma_mps }
                if is_possible(forward_mps) && is_possible(sigma_mps) =>
            {
                self.know(forward_mps, sigma_mps.abs());
                let before_m = if let Run::Speed { sigma_m } = self.run { sigma_m } else { 0.0 };
                let added_m = sigma_mps.abs() * dt_s;
                self.run = Run::Speed { sigma_m: before_m + added_m };
                Some(Step {
                    dt_s,
                    measured_m: 0.0,
                    unscaled_m: forward_mps * dt_s,
                    white_sigma_m: 0.0,
                    run_before_m: before_m,
                    run_added_m: added_m,
                })
            }
            _ => Some(self.unknown(dt_s)),
        }
    }

    fn know(&mut self, forward_mps: f64, spread_mps: f64) {
        let half_mps = 0.5 * UNIFORM_WIDTH * spread_mps;
        self.within_mps = [forward_mps - half_mps, forward_mps + half_mps].map(|mps| mps.max(0.0));
        self.fastest_mps = self.fastest_mps.max(forward_mps);
    }

    /// The distance lies between that of the hardest braking and that of the hardest acceleration to the fastest speed.
    fn unknown(&mut self, dt_s: f64) -> Step {
        let before_m = if let Run::Unknown { within_m } = self.run { within_m } else { [0.0; 2] };
        let [slow_mps, quick_mps] = self.within_mps;
        let fastest_mps = self.fastest_mps.max(quick_mps);
        let braking_s = dt_s.min(slow_mps / BRAKING_MPS2);
        let speeding_s = dt_s.min((fastest_mps - quick_mps) / ACCELERATION_MPS2);
        let least_m = (slow_mps - 0.5 * BRAKING_MPS2 * braking_s) * braking_s;
        let quickest_mps = quick_mps + ACCELERATION_MPS2 * speeding_s;
        let most_m = 0.5 * (quick_mps + quickest_mps) * speeding_s + quickest_mps * (dt_s - speeding_s);
        self.within_mps = [slow_mps - BRAKING_MPS2 * braking_s, quickest_mps];
        let within_m = [before_m[0] + least_m, before_m[1] + most_m];
        self.run = Run::Unknown { within_m };
        let sigma_m = |[least_m, most_m]: [f64; 2]| (most_m - least_m) / UNIFORM_WIDTH;
        Step {
            dt_s,
            measured_m: 0.0,
            unscaled_m: 0.5 * (least_m + most_m),
            white_sigma_m: 0.0,
            run_before_m: sigma_m(before_m),
            run_added_m: sigma_m(within_m) - sigma_m(before_m),
        }
    }
}

fn is_possible(mps: f64) -> bool {
    mps.abs() <= IMPOSSIBLE_MPS
}
