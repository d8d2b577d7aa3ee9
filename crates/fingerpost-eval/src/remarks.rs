//! Why nothing was found on a drive, as sentences.

use std::fmt::{self, Display, Formatter};

use fingerpost_format::{FeatureOutcome, FeatureSummary};

/// What a reader of a run should know first.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Remark {
    /// No frame could be used.
    NothingUsed,
    /// No picture showed anything.
    NothingShown { frames: u64 },
    /// The motion is wrong by what else the pictures show, in so many frames of those behind another one, and what was seen in most of
    /// them; in how many of them the bus gave no speed, without which nothing is advised.
    MotionNotBelieved { seen: String, frames: u64, of: u64, without_speed: u64 },
    /// No motion was measured.
    NoMotion,
    /// The drive ended before the first feature of the route.
    EndedBefore { route_m: f64, first: String, at_m: f64 },
    /// Features were passed and none was found; the highest P(F) of those.
    AllMissed { passed: usize, best_p: Option<f64> },
    /// Nothing says how far along the route the drive went.
    PlaceUnknown,
    /// How far along the route the drive went is only known up to here.
    PlaceLost { known_m: f64 },
    /// No edge of a lane was found.
    NoLane,
}

impl Remark {
    /// Why no feature of the route was found by a vehicle whose place is known last at `route_m` of it; none where there is none.
    pub(crate) fn no_feature(route_m: Option<f64>, features: &[FeatureSummary]) -> Option<Self> {
        let first = features.first()?;
        let missed = || features.iter().filter(|feature| feature.outcome == Some(FeatureOutcome::Missed));
        let passed = missed().count();
        let best_p = missed().filter_map(|feature| feature.max_p).reduce(f64::max);
        Some(match (first.outcome, route_m.zip(first.at_m)) {
            (Some(FeatureOutcome::NotReached), Some((route_m, at_m))) => {
                let first = format!("{} {}", first.kind.replace('_', " "), first.name).trim_end().to_owned();
                Self::EndedBefore { route_m, first, at_m }
            }
            _ if passed > 0 => Self::AllMissed { passed, best_p },
            _ => route_m.map_or(Self::PlaceUnknown, |known_m| Self::PlaceLost { known_m }),
        })
    }
}

impl Display for Remark {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NothingUsed => f.write_str("nothing was found: no frame could be used"),
            Self::NothingShown { frames } => write!(
                f,
                "nothing was found: in none of the {frames} frames did the camera show anything new (covered, black or frozen)"
            ),
            Self::MotionNotBelieved { seen, frames, of, without_speed } => {
                write!(f, "the motion is not believed in {frames} of {of} frames: {seen}")?;
                f.write_str("; how far the vehicle went in these frames is not known")?;
                match without_speed {
                    0 => {}
                    n if n == frames => f.write_str(", and nothing is advised in them")?,
                    n => write!(f, ", and nothing is advised in the {n} of them in which the bus gave no speed")?,
                }
                f.write_str("; set ground_view.near_m beyond the bonnet")?;
                if *without_speed > 0 {
                    f.write_str(", or give the speed of the vehicle's bus (--can)")?;
                }
                Ok(())
            }
            Self::NoMotion => f.write_str(
                "no motion was measured: the road ahead shows too little that differs from place to place (darkness, glare, smooth asphalt)",
            ),
            Self::EndedBefore { route_m, first, at_m } => write!(
                f,
                "no feature was found: the drive ended at {route_m:.0} m of the route, and the first one, {first}, lies at {at_m:.0} m"
            ),
            Self::AllMissed { passed, best_p } => {
                write!(f, "no feature was found, and the vehicle passed {passed}: ")?;
                match best_p {
                    Some(p) => {
                        write!(f, "the best match had a P(F) of {p:.2}; `why` of the frames before says what it lacked")
                    }
                    None => f.write_str("none came into the view's reach; does the drive begin where it is said to?"),
                }
            }
            Self::PlaceUnknown => f.write_str(
                "no feature was found: nothing says how far along the route the drive went; --start-m or --gps says where it begins",
            ),
            Self::PlaceLost { known_m } => write!(
                f,
                "no feature was found: how far along the route the drive went is not known; the last place of it that is known lies at \
                 {known_m:.0} m"
            ),
            Self::NoLane => f.write_str(
                "no lane was found: no line beside the vehicle was sure enough to be an edge of one, by its paint and over the distance driven",
            ),
        }
    }
}
