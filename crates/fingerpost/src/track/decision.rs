//! What decided a frame, and the numbers that it was decided by.

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
    /// The next feature was searched for, and the ground looks like it nowhere.
    NotFound {
        /// Index of the feature.
        index: usize,
        /// Places that the last search tried.
        places: usize,
    },
    /// The feature is there, and its place is sure enough: it is tracked from now on.
    Detected,
    /// It still is, and still sure enough.
    Confirmed,
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

/// What a feature lacks to be tracked: the first of the tests that it does not pass.
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
