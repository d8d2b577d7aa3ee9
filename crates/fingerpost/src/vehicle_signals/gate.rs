//! Whether a number from the bus can be believed.

use super::agreement::{Agreement, AgreementLimits, Disagreement};
use super::{NotUsed, Sample, SignalSource, SignalUse};

/// What a signal may do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Oldest sample that is used, seconds.
    pub(super) max_age_s: f64,
    /// Largest magnitude.
    pub(super) max: f64,
    /// Fastest change, a second.
    pub(super) max_change_per_s: f64,
    /// A change that is no jump however soon it comes.
    pub(super) step: f64,
    /// How far it may differ from the camera: absolute, and as a share of the larger of the two.
    pub(super) tolerance: (f64, f64),
    /// How long it may differ farther than that, seconds.
    pub(super) contradiction_s: f64,
    /// By what it may differ from the camera over what has been driven.
    pub(super) agreement: AgreementLimits,
}

/// The limits of a signal with what it has said so far.
#[derive(Debug, Clone)]
pub(super) struct Gate {
    limits: Limits,
    /// The last value that was no jump, and how long ago it came, seconds.
    last: Option<(f64, f64)>,
    /// For how long it has contradicted the camera, seconds; time in agreement is taken off.
    contradicting_s: f64,
    disbelieved: bool,
    agreement: Agreement,
}

/// Whether a sample is too old; a negative age is of a sample from the future, which no frame can have.
pub(super) fn is_late(age_s: f64, max_age_s: f64) -> bool {
    !(0.0..=max_age_s).contains(&age_s)
}

impl Gate {
    pub(super) fn new(limits: Limits) -> Self {
        let agreement = Agreement::new(limits.agreement);
        Self { limits, last: None, contradicting_s: 0.0, disbelieved: false, agreement }
    }

    /// Where the signal and the camera do not agree over what has been driven.
    pub(super) const fn disagreement(&self) -> Option<Disagreement> {
        self.agreement.found()
    }

    /// The bus's value if it can be believed, else the camera's. `dt_s` is the time since the last call.
    pub(super) fn choose(
        &mut self,
        sample: Option<Sample<f64>>,
        camera: Option<f64>,
        dt_s: f64,
    ) -> (Option<f64>, SignalUse) {
        if let Some((_, ago_s)) = &mut self.last {
            *ago_s += dt_s;
        }
        match self.judge(sample, camera, dt_s) {
            Ok(value) => (Some(value), SignalUse { source: SignalSource::Can, not_used: None }),
            Err(not_used) => {
                let source = camera.map_or(SignalSource::Nowhere, |_| SignalSource::Camera);
                (camera, SignalUse { source, not_used: Some(not_used) })
            }
        }
    }

    fn judge(&mut self, sample: Option<Sample<f64>>, camera: Option<f64>, dt_s: f64) -> Result<f64, NotUsed> {
        let Limits { max_age_s, max, max_change_per_s, step, .. } = self.limits;
        let Sample { value, age_s } = sample.ok_or(NotUsed::Missing)?;
        if is_late(age_s, max_age_s) {
            return Err(NotUsed::Late { age_s });
        }
        if let Some(camera) = camera.filter(|_| value.is_finite()) {
            // A value that no vehicle reaches is none to use, but it tells of a wrong unit.
            self.agreement.add(value.clamp(-max, max), camera, dt_s);
        }
        if !(-max..=max).contains(&value) {
            return Err(NotUsed::OutOfRange);
        }
        if let Some((last, ago_s)) = self.last {
            // The time between the two samples; it grows while the signal is refused, so that a change that stays is
            // believed in the end.
            let between_s = (ago_s - age_s).max(0.0);
            if (value - last).abs() > step + max_change_per_s * between_s {
                return Err(NotUsed::Jump);
            }
        }
        self.last = Some((value, age_s));
        if let Some(camera) = camera {
            self.compare(value, camera, dt_s);
        }
        if self.agreement.found().is_some() {
            return Err(NotUsed::DisagreesWithCamera);
        }
        if self.disbelieved { Err(NotUsed::ContradictsCamera) } else { Ok(value) }
    }

    /// A signal is disbelieved after contradicting for long, and believed again after agreeing for as long.
    fn compare(&mut self, value: f64, camera: f64, dt_s: f64) {
        let Limits { tolerance: (absolute, share), contradiction_s, .. } = self.limits;
        let agrees = (value - camera).abs() <= absolute.max(share * value.abs().max(camera.abs()));
        let signed_s = if agrees { -dt_s } else { dt_s };
        self.contradicting_s = (self.contradicting_s + signed_s).clamp(0.0, contradiction_s);
        if self.contradicting_s >= contradiction_s {
            self.disbelieved = true;
        } else if self.contradicting_s <= 0.0 {
            self.disbelieved = false;
        }
    }
}
