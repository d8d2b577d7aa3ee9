//! What decided a frame, and the numbers that it was decided by.

/// What a candidate lacks to be detected: the first of the tests that it does not pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Missing {
    /// Frames in a row.
    Frames {
        /// How many are needed.
        needed: usize,
    },
    /// Contrast with the verge, summed over the frames beyond half of the one that is needed.
    Contrast {
        /// The sum.
        sum: f64,
        /// The sum that is needed.
        needed: f64,
    },
    /// A sure distance.
    Distance {
        /// Its standard deviation, metres.
        sigma_m: f64,
        /// The largest with which a feature is taken, metres.
        most_m: f64,
    },
}

/// What decided a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Decision {
    /// There is no route.
    #[default]
    NoRoute,
    /// The camera showed nothing, or nothing new, and nothing was looked for.
    NothingShown,
    /// The next feature is not in reach of the view yet.
    NotInReach {
        /// Index of the feature.
        index: usize,
        /// Believed distance to it, metres.
        ahead_m: f64,
    },
    /// The next feature was searched for and nothing matched well enough.
    NotFound {
        /// Index of the feature.
        index: usize,
    },
    /// The next feature matched, but something is still missing.
    Candidate {
        /// Index of the feature.
        index: usize,
        /// Frames in a row so far.
        frames: usize,
        /// P(F).
        p: f64,
        /// What is missing.
        missing: Missing,
    },
    /// It matched for many frames without ever being sure enough, and is looked for anew.
    Dropped {
        /// Index of the feature.
        index: usize,
        /// Frames in a row.
        frames: usize,
        /// Frames after which a candidate is given up.
        most_frames: usize,
    },
    /// It matched, but no verge is in view, and without one it does not match well enough.
    NoVergeInView {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
        /// P(F) that is needed without a verge.
        needed_p: f64,
    },
    /// It matched without a verge in view, but where it is not expected.
    NotExpected {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
        /// Loss in rank for the place, 0 where it is expected.
        surprise: f64,
        /// The loss from which on it is not taken.
        most: f64,
    },
    /// It matched where the vehicle would not be on the feature's approach.
    OffApproach {
        /// Index of the feature.
        index: usize,
        /// P(F) at the best place.
        p: f64,
        /// How far beside the approach's axis the vehicle would be, metres.
        beside_m: f64,
        /// How far it may be, metres.
        most_m: f64,
    },
    /// It matched, but none of the arms that tell it showed an edge of its road or a verge.
    Unbounded {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
    },
    /// It matched, but what lies beside the arms that tell it is road as well, or not verge enough so far from where the
    /// feature is expected.
    NoVerge {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
        /// How much more the arms are road than what lies beside them.
        contrast: f64,
        /// What more is needed because the feature is not expected there.
        surprise: f64,
    },
    /// It matched, but not where the edges of its arms say that it would have to be.
    EdgesDisagree {
        /// Index of the feature.
        index: usize,
        /// P(F) at the best place.
        p: f64,
        /// P(F) at the place that the edges say.
        aligned_p: f64,
        /// P(F) that is needed there.
        needed_p: f64,
    },
    /// It matched, but more edges of the arms that tell it lie too far from there than near it.
    EdgesElsewhere {
        /// Index of the feature.
        index: usize,
        /// P(F) at the best place.
        p: f64,
        /// How many edges lie too far off.
        gated: usize,
    },
    /// The feature matched in enough frames: it is tracked from now on.
    Detected,
    /// The masks at the predicted place confirmed it.
    Confirmed,
    /// They did not, but bracketing found it nearby.
    FoundByBracketing,
    /// Neither did; its place is dead reckoning.
    NotConfirmed {
        /// Frames in a row so far.
        frames: usize,
    },
    /// It was not confirmed for too long.
    Lost {
        /// Index of the feature.
        index: usize,
    },
    /// The start of the papers' curve reached the bottom of the view.
    Arrived,
    /// The vehicle is on its way through.
    Passing,
    /// The next feature lies behind by all that is known; the one after it is searched for.
    Skipped {
        /// Index of the feature.
        index: usize,
    },
    /// The next feature may be in view, but something is still missing.
    NotSure {
        /// Index of the feature.
        index: usize,
        /// What is missing.
        lack: Lack,
    },
    /// A tracked feature is not there, or its place is no longer sure.
    NoLongerSure {
        /// Index of the feature.
        index: usize,
        /// What is missing.
        lack: Lack,
    },
    /// Where the vehicle is on the route is not sure enough to say which of its features is next.
    NextUnknown {
        /// Index of the likeliest one to have come first, and its probability.
        likeliest: (usize, f64),
        /// The same of the one after it.
        rival: (usize, f64),
    },
    /// Every feature has been passed.
    RouteDone,
}

impl Decision {
    /// The feature that was given up unseen, where that decided the frame.
    pub(super) const fn skipped(&self) -> Option<usize> {
        match self {
            Self::Skipped { index } => Some(*index),
            _ => None,
        }
    }
}

/// What a feature lacks to be tracked by the belief: the first of the tests that it does not pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lack {
    /// Evidence that it is there.
    Presence {
        /// Probability that it is.
        present: f64,
        /// The probability that is needed.
        needed: f64,
    },
    /// A sure place.
    Place {
        /// Probability that it is there.
        present: f64,
        /// Standard deviation of its place, metres.
        sigma_m: f64,
        /// The largest with which a feature is tracked, metres.
        most_m: f64,
    },
}
