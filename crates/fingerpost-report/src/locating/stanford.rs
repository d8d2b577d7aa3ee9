//! The Stanford diagram: errors against the protection levels that promised to be greater.

use std::collections::BTreeMap;

use fingerpost_locate::{ALERT_LIMIT_M, Status};
use maud::{Markup, html};

use super::drive::LocatedDrive;
use crate::html::{Scale, number, px};
use crate::palette;

/// The axes, metres.
const AXIS_M: [f64; 2] = [0.1, 1000.0];
/// Squares in which rows are counted, along an axis.
const SQUARES: usize = 80;
const SIDE: f64 = 440.0;
const LEFT: f64 = 56.0;
const TOP: f64 = 14.0;
const RIGHT: f64 = 250.0;
const BOTTOM: f64 = 46.0;

/// Rows with truth, counted.
#[derive(Debug, Clone, Default)]
pub(super) struct Stanford {
    /// Converged rows by the square of error and level.
    converged: BTreeMap<[usize; 2], usize>,
    /// The same of all others that have a level.
    others: BTreeMap<[usize; 2], usize>,
    pub(super) regions: Regions,
}

/// How many rows lie where.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Regions {
    /// Converged, and the error is within the level.
    pub(super) inside: usize,
    /// Converged, and it is not.
    pub(super) outside: usize,
    /// Not called converged, with a level beyond the alert limit or none.
    pub(super) beyond: usize,
    /// Not called converged though the level is within the limit: after a contradiction.
    pub(super) in_doubt: usize,
}

impl Stanford {
    pub(super) fn add(&mut self, status: Status, error_m: f64, level_m: Option<f64>) {
        let regions = &mut self.regions;
        let region = match (status, level_m) {
            (Status::Converged, Some(level_m)) if error_m <= level_m => &mut regions.inside,
            (Status::Converged, _) => &mut regions.outside,
            (_, Some(level_m)) if level_m <= ALERT_LIMIT_M => &mut regions.in_doubt,
            _ => &mut regions.beyond,
        };
        *region += 1;
        if let Some(level_m) = level_m {
            let squares = if status == Status::Converged { &mut self.converged } else { &mut self.others };
            *squares.entry([square(error_m), square(level_m)]).or_default() += 1;
        }
    }
}

/// The square in which a length lies; what is beyond the axis counts to its last one.
fn square(metres: f64) -> usize {
    let share = Scale::Logarithmic.share(metres, AXIS_M).clamp(0.0, 1.0);
    ((share * SQUARES as f64) as usize).min(SQUARES - 1)
}

/// The diagram with its counts.
pub(super) fn diagram(drive: &LocatedDrive) -> Markup {
    let Stanford { converged, others, regions } = &drive.stanford;
    let x = |metres: f64| LEFT + Scale::Logarithmic.share(metres, AXIS_M) * SIDE;
    let y = |metres: f64| TOP + (1.0 - Scale::Logarithmic.share(metres, AXIS_M)) * SIDE;
    let (right, floor) = (LEFT + SIDE, TOP + SIDE);
    let step = SIDE / SQUARES as f64;
    let rect = |[error, level]: [usize; 2], fill: &str, rows: usize| {
        html! {
            rect x=(px(LEFT + step * error as f64)) y=(px(floor - step * (level + 1) as f64)) width=(px(step))
                height=(px(step)) fill=(fill) { title { (rows) " rows" } }
        }
    };
    let most = converged.values().copied().max().unwrap_or(1);
    // From the middle of the colours on, which stands out from dark pages too.
    let heat = |rows: usize| {
        let share = libm::log(rows as f64) / libm::log(most.max(2) as f64);
        palette::css(palette::heat((90.0 + 150.0 * share).round() as u8))
    };
    let counted = [
        (regions.inside, "converged, error within the level"),
        (regions.outside, "converged, error beyond the level"),
        (regions.beyond, "level beyond the limit, or none"),
        (regions.in_doubt, "level within it, but in doubt"),
    ];
    html! {
        figure class="chart" {
            figcaption {
                "Stanford diagram: rows by error and protection level. Coloured: converged ones, the lighter the more; grey: \
                 others that have a level. Below the diagonal a level is broken; above the dotted line none is converged."
            }
            svg class="stanford" viewBox={ "0 0 " (px(right + RIGHT)) " " (px(floor + BOTTOM)) } role="img"
                aria-label="Stanford diagram" {
                polygon class="broken" points={ (px(LEFT)) "," (px(floor)) " " (px(right)) "," (px(TOP)) " " (px(right)) "," (px(floor)) } {}
                @for v in Scale::Logarithmic.ticks(AXIS_M, 0) {
                    line class="grid" x1=(px(LEFT)) x2=(px(right)) y1=(px(y(v))) y2=(px(y(v))) {}
                    line class="grid" x1=(px(x(v))) x2=(px(x(v))) y1=(px(TOP)) y2=(px(floor)) {}
                    text x=(px(LEFT - 6.0)) y=(px(y(v) + 4.0)) text-anchor="end" { (number(v)) }
                    text x=(px(x(v))) y=(px(floor + 17.0)) text-anchor="middle" { (number(v)) }
                }
                g fill-opacity="0.5" { @for (at, rows) in others { (rect(*at, "var(--dim)", *rows)) } }
                @for (at, rows) in converged { (rect(*at, &heat(*rows), *rows)) }
                line class="threshold" x1=(px(LEFT)) x2=(px(right)) y1=(px(y(ALERT_LIMIT_M))) y2=(px(y(ALERT_LIMIT_M))) {}
                text x=(px(LEFT + 6.0)) y=(px(y(ALERT_LIMIT_M) - 5.0)) { "alert limit " (number(ALERT_LIMIT_M)) " m" }
                text class="dim" x=(px(right)) y=(px(floor + 36.0)) text-anchor="end" { "error, metres" }
                text class="dim" x=(px(LEFT + 6.0)) y=(px(TOP + 16.0)) { "protection level, metres" }
                @for (i, (rows, words)) in counted.iter().enumerate() {
                    @let at = TOP + 24.0 + 44.0 * i as f64;
                    text class="count" x=(px(right + 24.0)) y=(px(at)) { (rows) " rows" }
                    text class="dim" x=(px(right + 24.0)) y=(px(at + 16.0)) { (words) }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_in_one_region() {
        let mut stanford = Stanford::default();
        for (status, error_m, level_m) in [
            (Status::Converged, 2.0, Some(6.0)),
            (Status::Converged, 6.0, Some(6.0)),
            (Status::Converged, 6.1, Some(6.0)),
            (Status::Coasting, 3.0, Some(6.0)),
            (Status::Coasting, 30.0, Some(40.0)),
            (Status::Ambiguous, 800.0, None),
            (Status::Ambiguous, 800.0, Some(2500.0)),
        ] {
            stanford.add(status, error_m, level_m);
        }
        assert_eq!(stanford.regions, Regions { inside: 2, outside: 1, beyond: 3, in_doubt: 1 });
        assert_eq!(stanford.converged.values().sum::<usize>(), 3);
        assert_eq!(stanford.others.values().sum::<usize>(), 3, "a row without a level has no place");
    }

    #[test]
    fn lengths_beyond_the_axes_stay_on_them() {
        assert_eq!([square(0.0), square(0.1), square(1e9)], [0, 0, SQUARES - 1]);
        // A decade is a quarter of the axis.
        assert_eq!(square(10.001), SQUARES / 2);
    }
}
