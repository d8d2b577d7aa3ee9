//! The part of the page about paper 3's accuracy of lanes.

use fingerpost_eval::{LANE_ROI_ROWS, LANE_THRESHOLDS_PX2};
use fingerpost_report::{SurfacePlot, surface_svg};

use super::{Page, capital, number, of_difference};
use crate::claims::lane_claims::{LaneClaim, SAMPLES, lane_claims, table};
use crate::claims::measurements::Measurements;
use crate::claims::verdict::{Compared, Outcome, verdict};

const LANES_HEAD: &str = "\
## Accuracy of lanes by region of interest and threshold

> The performance indexes were calculated for each combination of ROI length (100, 120, 140 and 150) and deviation threshold (10, 15 and
> 20). [...] The results concentrate in the range of 87~98% of accuracy.
> (paper 3, IV-B and figure 21)

The paper's measure (equations 1 and 2) on simulated clips of a country road, 640 x 480 pixels at 30 frames a second, five seconds
each, six days in place of its six samples. The lane finder is this program's with its default settings, which goes beyond the paper's.
The threshold is compared with the mean squared deviation, in squared pixels.
";

impl Page {
    /// Table, plot and claims.
    pub(super) fn lanes(&mut self, measurements: &Measurements) {
        self.line(LANES_HEAD);
        let samples = SAMPLES.map(|(name, _)| name);
        let percent = table(measurements, &samples);
        let svg = surface_svg(&SurfacePlot {
            title: "mean accuracy over the six samples".to_owned(),
            x_label: "deviation threshold, squared pixels".to_owned(),
            xs: LANE_THRESHOLDS_PX2.to_vec(),
            y_label: "rows of the region".to_owned(),
            ys: LANE_ROI_ROWS.map(f64::from).to_vec(),
            z_label: "accuracy, %".to_owned(),
            percent: percent.clone(),
        });
        self.plot("lanes", "Mean accuracy by region of interest and threshold", svg);
        self.line("| rows of the region | threshold 10 | 15 | 20 |\n|---|---|---|---|");
        for (rows, accuracies) in LANE_ROI_ROWS.iter().zip(&percent) {
            let cells: Vec<String> = accuracies.iter().map(|value| number(*value)).collect();
            self.line(&format!("| {rows} | {} |", cells.join(" | ")));
        }
        self.line("\n| sample | mean accuracy, % |\n|---|---|");
        for (name, words) in SAMPLES {
            let accuracies = table(measurements, &[name]);
            let count = accuracies.iter().flatten().count() as f64;
            self.line(&format!("| {words} | {} |", number(accuracies.iter().flatten().sum::<f64>() / count)));
        }
        self.line("");
        for claim in lane_claims(measurements) {
            self.line(&lane_claim(&claim));
        }
    }
}

fn lane_claim(claim: &LaneClaim) -> String {
    let LaneClaim { title, words, compared: [one, other], expectation, result } = claim;
    let outcome = result.as_ref().map_or(Outcome::Open, |result| result.outcome);
    let figures = result.as_ref().map_or_else(String::new, |Compared { means, difference, .. }| {
        format!(
            " {} {} with {}, {} with {} ({}, {} seeds).",
            capital(&format!("{one} {} {other}:", expectation.words())),
            number(means[0]),
            one,
            number(means[1]),
            other,
            of_difference(difference),
            difference.count
        )
    });
    format!("### {title}\n\n> {words}\n\n{}{figures}\n", verdict(outcome, &[]))
}
