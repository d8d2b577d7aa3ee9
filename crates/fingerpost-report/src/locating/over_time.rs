//! Status, protection level and probabilities over time.

use maud::{Markup, html};

use super::LocatingInput;
use crate::html::{Chart, Curve, bands};
use crate::palette;

/// The charts.
pub(super) fn over_time(input: &LocatingInput<'_>) -> Markup {
    let drive = input.drive;
    let seconds = drive.seconds();
    let band = |&status: &_| {
        let (name, rgb) = palette::fix_status(status);
        Some((name.to_owned(), palette::css(rgb)))
    };
    let probabilities = Chart {
        bands: bands(&seconds, &drive.fixes.statuses, band),
        curves: vec![
            Curve { label: "the likeliest place", class: "one", values: &drive.place_p },
            Curve { label: "on no road of the map", class: "two", values: &drive.off_map_p },
        ],
        ..Chart::over(seconds.clone(), "Probability", "probability", 0.0..=1.0)
    };
    html! {
        (drive.fixes.legend())
        (drive.fixes.level_chart(&seconds).figure())
        (probabilities.figure())
    }
}
