//! What papers 1 and 2 claim, as comparisons of figures.

use super::axes::{self, Axis};
use super::verdict::{Better, Expectation};

/// Something that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Metric {
    /// Name in the file of measurements.
    pub(super) name: &'static str,
    /// What it is called on the page, with its unit.
    pub(super) label: &'static str,
    pub(super) better: Better,
}

pub(super) const ROAD: Metric =
    Metric { name: "road", label: "road surface, MaxF %", better: Better::Higher };
pub(super) const FOLLOWED: Metric =
    Metric { name: "followed", label: "frames with the feature followed, %", better: Better::Higher };
pub(super) const WAY: Metric =
    Metric { name: "way_error", label: "way measured wrongly, %", better: Better::Lower };
pub(super) const TOLD: Metric =
    Metric { name: "told", label: "places told apart, %", better: Better::Higher };
pub(super) const FALSELY: Metric =
    Metric { name: "falsely", label: "places passing falsely, %", better: Better::Lower };
pub(super) const FOUND: Metric = Metric { name: "found", label: "features found, %", better: Better::Higher };
pub(super) const TIME: Metric = Metric { name: "ms", label: "time a frame, ms", better: Better::Lower };

/// One setting against another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Test {
    pub(super) metric: Metric,
    pub(super) of: f64,
    pub(super) expectation: Expectation,
    pub(super) against: f64,
}

/// A claim with what bears it out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim {
    /// Name of its pictures.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    /// Where it stands.
    pub(super) source: &'static str,
    /// The paper's words.
    pub(super) words: &'static str,
    /// How it is measured here.
    pub(super) measured: &'static str,
    pub(super) axis: Axis,
    /// Plotted and listed; those of the tests first.
    pub(super) metrics: &'static [Metric],
    /// All of them must hold.
    pub(super) tests: &'static [Test],
}

/// Loss of followed frames that would be noticed, percentage points (ours: the papers say "no noticeable degradation").
const NOTICED_PCT: f64 = 5.0;
/// Share of the way by which dead reckoning would get noticeably worse, percentage points (ours).
const NOTICED_WAY_PCT: f64 = 2.0;

const fn test(metric: Metric, of: f64, expectation: Expectation, against: f64) -> Test {
    Test { metric, of, expectation, against }
}

use Expectation::{BetterThan, NoWorseBy, WorseThan};

/// All claims about features, surface and motion.
pub(super) const CLAIMS: [Claim; 11] = [
    Claim {
        name: "order",
        title: "The ground view before the road detector",
        source: "paper 1, IV-B and figure 4",
        words: "a better road surface detection was obtained when the IPM transformation occurred as the initial step",
        measured: "Back-projection in the ground view, against back-projection in the camera picture with its probabilities warped \
                   (`road_surface.picture`), each learning from the same bit of road. The features follow from the surface.",
        axis: axes::ORDER,
        metrics: &[ROAD, FOLLOWED],
        tests: &[test(ROAD, 0.0, BetterThan, 1.0)],
    },
    Claim {
        name: "masks",
        title: "Sub-masks instead of one whole mask",
        source: "paper 1, V-C",
        words: "using a single full feature mask as per equation 1 in lieu of sub features however this approach is significantly \
                less robust",
        measured: "The same arms over the same surface, at the true place of the next feature and at places of the route without \
                   one: the smallest P(F_sub), against P of the union of the arms. Told apart: how often the true place reads \
                   higher. Passing falsely: places without the feature above the threshold that 95 % of the true places pass.",
        axis: axes::MASKS,
        metrics: &[TOLD, FALSELY],
        tests: &[test(TOLD, 0.0, BetterThan, 1.0)],
    },
    Claim {
        name: "flow",
        title: "Farneback instead of Lucas-Kanade",
        source: "paper 1, VI",
        words: "The Lucas Kanade approach [...] did not perform well. [...] The two frame estimation proposed by Farneback [...] was \
                identified to perform better",
        measured: "The mean flow of the same region of the grey ground view, dense by Farneback against Lucas-Kanade on Shi-Tomasi \
                   corners; both start from the motion of the frame before. Beside them the program's own estimator, which aligns \
                   the road as a plane and is neither.",
        axis: axes::FLOW,
        metrics: &[WAY, FOLLOWED],
        tests: &[test(WAY, 0.0, BetterThan, 1.0)],
    },
    Claim {
        name: "width",
        title: "Small pictures without losses",
        source: "paper 2, 2, 1.2",
        words: "the system can trade some resolution for computational time savings without significant losses. Frame resolutions used \
                in testing varied from 512px to 150px widths",
        measured: "Pictures 512 pixels wide made smaller by area averaging, with their calibration. No significant loss: at most 5 \
                   points fewer frames with the feature followed.",
        axis: axes::WIDTH,
        metrics: &[FOLLOWED, ROAD, FOUND],
        tests: &[
            test(FOLLOWED, 256.0, NoWorseBy(NOTICED_PCT), 512.0),
            test(FOLLOWED, 150.0, NoWorseBy(NOTICED_PCT), 512.0),
        ],
    },
    Claim {
        name: "width_time",
        title: "Small pictures save time",
        source: "paper 2, 2, 1.2",
        words: "trade some resolution for computational time savings",
        measured: "Median time that the method takes for a frame on the machine that wrote this page, in the same runs; making the \
                   pictures smaller is not counted, since a camera can do it. These figures alone are not the same on every machine.",
        axis: axes::WIDTH,
        metrics: &[TIME],
        tests: &[test(TIME, 150.0, BetterThan, 512.0)],
    },
    Claim {
        name: "rate",
        title: "Ten frames a second are enough",
        source: "paper 2, 2, 1.3",
        words: "Frame frequency for this test was as low as 10Hz with no noticeable degradation in feature detection or optical flow \
                tracking",
        measured: "Drives rendered at 30 Hz, of which every n-th frame is used. Not noticeable: at most 5 points fewer frames with \
                   the feature followed, and 2 points more of the way measured wrongly.",
        axis: axes::RATE,
        metrics: &[FOLLOWED, WAY],
        tests: &[
            test(FOLLOWED, 10.0, NoWorseBy(NOTICED_PCT), 30.0),
            test(WAY, 10.0, NoWorseBy(NOTICED_WAY_PCT), 30.0),
        ],
    },
    Claim {
        name: "slow",
        title: "Fewer frames, more tracking errors",
        source: "paper 2, 2, 1.3",
        words: "A lower frequency of frame processing results in a higher likelihood of route feature tracking errors",
        measured: "The same runs at 5 and at 10 Hz.",
        axis: axes::RATE,
        metrics: &[FOLLOWED, FOUND],
        tests: &[test(FOLLOWED, 5.0, WorseThan, 10.0)],
    },
    Claim {
        name: "reach",
        title: "A ground view of 15 to 20 m",
        source: "paper 2, 6",
        words: "Distances in the order of 15-20m were determined to be the most effective for road surface detection",
        measured: "The far limit of the ground view. Its picture keeps its number of rows beyond 20 m, as the papers' did, so that \
                   the road grows narrower in it; the surface is compared over all that the view shows.",
        axis: axes::REACH,
        metrics: &[ROAD, FOLLOWED],
        tests: &[
            test(ROAD, 20.0, BetterThan, 100.0),
            test(FOLLOWED, 20.0, BetterThan, 100.0),
            test(FOLLOWED, 20.0, BetterThan, 10.0),
        ],
    },
    Claim {
        name: "mask_width",
        title: "Wide masks fail",
        source: "paper 2, 2, 3.2",
        words: "If this width is too great there is a risk that the combined driving line and feature mask may be wider than the feature \
                itself, leading to a failure to detect the feature",
        measured: "Arms drawn at 10 to 100 % of the vehicle's width; the papers took 25 %. The driving line keeps the vehicle's width.",
        axis: axes::MASK_WIDTH,
        metrics: &[FOLLOWED, FOUND],
        tests: &[test(FOLLOWED, 100.0, WorseThan, 25.0)],
    },
    Claim {
        name: "histograms",
        title: "The mean of five histograms",
        source: "paper 1, IV-B and VII-B",
        words: "The histogram backprojection uses an average histogram over the previous 5 frames. This is effective for slowly changing \
                road surfaces",
        measured: "The rolling mean of one to ten histograms. Effective: a better surface with five than with one.",
        axis: axes::HISTOGRAMS,
        metrics: &[ROAD, FOLLOWED],
        tests: &[test(ROAD, 5.0, BetterThan, 1.0)],
    },
    Claim {
        name: "histograms_lag",
        title: "A mean of histograms loses the road where the surface changes",
        source: "paper 1, VII-B",
        words: "however can lead to brief road surface loss when moving from one surface to another",
        measured: "The same runs: a worse surface with ten histograms than with one.",
        axis: axes::HISTOGRAMS,
        metrics: &[ROAD],
        tests: &[test(ROAD, 10.0, WorseThan, 1.0)],
    },
];
