//! What changes over a run, a value a frame.

use fingerpost_format::FrameRecord;
use serde::Serialize;

/// What a curve shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Probability that the feature which is followed or searched for is there.
    Present,
    /// P(F) of that feature (paper 1, equation 2).
    MatchP,
    /// Distance ahead of the followed feature.
    Forward,
    /// Standard deviation of that distance.
    Sigma,
    /// Speed by the vehicle's bus, else by the camera's motion.
    Speed,
}

impl Quantity {
    /// Every quantity, in the order in which a page shows them.
    pub const ALL: [Self; 5] = [Self::Present, Self::MatchP, Self::Forward, Self::Sigma, Self::Speed];

    /// What people call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Present => "present",
            Self::MatchP => "P(F)",
            Self::Forward => "distance ahead",
            Self::Sigma => "sigma ahead",
            Self::Speed => "speed",
        }
    }

    /// Its unit; empty for probabilities.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Present | Self::MatchP => "",
            Self::Forward | Self::Sigma => "m",
            Self::Speed => "m/s",
        }
    }

    /// Its value in a frame; none where the record does not say it. `before_s` is the time of the frame before.
    fn of(self, record: &FrameRecord, before_s: Option<f64>) -> Option<f64> {
        let (feature, sought) = (record.feature.as_ref(), record.sought.as_ref());
        match self {
            Self::Present => match feature {
                Some(feature) => feature.present,
                None => sought?.present,
            },
            Self::MatchP => match feature {
                Some(feature) => feature.p,
                None => sought?.p,
            },
            Self::Forward => Some(feature?.forward_m),
            Self::Sigma => Some(feature?.sigma_m[0]),
            Self::Speed => speed_mps(record, before_s),
        }
    }
}

fn speed_mps(record: &FrameRecord, before_s: Option<f64>) -> Option<f64> {
    if let Some(by_bus) = record.signals.as_ref().and_then(|signals| signals.speed_mps) {
        return Some(by_bus);
    }
    let passed_s = record.t_s - before_s?;
    let motion = record.motion.as_ref().filter(|motion| motion.doubt.is_none() && passed_s > 0.0)?;
    Some(motion.forward_m / passed_s)
}

/// A quantity over a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Which.
    pub quantity: Quantity,
    /// What people call it.
    pub name: &'static str,
    /// Its unit; empty for probabilities.
    pub unit: &'static str,
    /// A value a frame, in the order of the run; none where it is not known.
    pub values: Vec<Option<f64>>,
}

impl Curve {
    pub(crate) const fn of(quantity: Quantity) -> Self {
        Self { quantity, name: quantity.name(), unit: quantity.unit(), values: Vec::new() }
    }

    pub(crate) fn add(&mut self, record: &FrameRecord, before_s: Option<f64>) {
        let value = self.quantity.of(record, before_s).filter(|value| value.is_finite());
        // Finer than a pixel of any curve, and short.
        self.values.push(value.map(|value| (value * 1e3).round() / 1e3));
    }
}
