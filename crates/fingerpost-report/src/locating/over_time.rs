//! Status, protection level and probabilities over time.

use fingerpost_locate::ALERT_LIMIT_M;
use maud::{Markup, html};

use super::LocatingInput;
use crate::html::{Chart, Curve, Scale, bands, legend};
use crate::palette;

/// Least protection level and error that the chart shows, metres: what the lines of good maps are off.
const LEAST_M: f64 = 0.1;

/// The charts.
pub(super) fn over_time(input: &LocatingInput<'_>) -> Markup {
    let drive = input.drive;
    let seconds = drive.seconds();
    let statuses = drive.rows.keys().map(|&status| palette::fix_status(status));
    let band = |&status: &_| {
        let (name, rgb) = palette::fix_status(status);
        Some((name.to_owned(), palette::css(rgb)))
    };
    let mut metres = vec![Curve { label: "protection level", class: "one", values: &drive.level_m }];
    let mut title = "Protection level";
    if !drive.error_m.is_empty() {
        title = "Protection level, and distance of the fix from the true place";
        metres.push(Curve { label: "error", class: "three", values: &drive.error_m });
    }
    let metres = Chart {
        scale: Scale::Logarithmic,
        bands: bands(&seconds, &drive.statuses, band),
        lines: vec![(ALERT_LIMIT_M, format!("converged only to {ALERT_LIMIT_M:.0} m"))],
        curves: metres,
        ..Chart::over(seconds.clone(), title, "metres", LEAST_M..=100.0)
    };
    let probabilities = Chart {
        bands: bands(&seconds, &drive.statuses, band),
        curves: vec![
            Curve { label: "the likeliest place", class: "one", values: &drive.place_p },
            Curve { label: "on no road of the map", class: "two", values: &drive.off_map_p },
        ],
        ..Chart::over(seconds.clone(), "Probability", "probability", 0.0..=1.0)
    };
    html! {
        (legend("status", statuses.map(|(name, rgb)| (name.to_owned(), rgb))))
        (metres.figure())
        (probabilities.figure())
    }
}
