//! The hypotheses at a few moments: how many places become one.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::drive::Moment;
use super::{LocatingInput, words};
use crate::fix_track::roads;
use crate::html::{Fit, Sheet, px};
use crate::palette;

const SHEET: Sheet = Sheet { width: 320.0, max_height: 300.0, margin: 8.0 };
/// Radius of a dot with all the weight, picture units.
const RADIUS: f64 = 13.0;
/// Smallest radius that can be seen.
const LEAST_RADIUS: f64 = 0.8;
/// Hypotheses in a square so wide are one dot, picture units.
const CELL: f64 = 3.0;

/// One small map of all roads a moment.
pub(super) fn moments(input: &LocatingInput<'_>) -> Markup {
    let fit = Fit::new(SHEET, input.graph.nodes().iter().map(|node| node.p_in_map));
    html! {
        p {
            "All roads of the map, and a dot wherever the vehicle may be: its area is the probability (the smallest are drawn \
             larger, to be seen)."
            @if !input.drive.fixes.truth.is_empty() { " The cross is where it was." }
        }
        div class="stages" {
            @for (i, moment) in input.drive.moments.iter().enumerate() {
                figure class="chart" {
                    svg viewBox=(fit.view_box()) role="img" aria-label={ "Hypotheses " (moment.name) } {
                        // The roads are drawn once and shown in every map.
                        @if i == 0 { path id="roads" class="road" d=(roads(input.graph, &fit)) {} }
                        @else { use href="#roads" {} }
                        (dots(moment, &fit))
                        @if let Some([x, y]) = moment.true_m.map(|p| fit.at(p)) {
                            path class="true-place" d={ "M" (px(x - 5.0)) "," (px(y - 5.0)) "l10,10m0,-10l-10,10" } {}
                        }
                        (fit.scale_bar())
                    }
                    figcaption { b { (moment.name) } ": " (caption(moment)) }
                }
            }
        }
    }
}

fn caption(moment: &Moment) -> String {
    let (name, _) = palette::fix_status(moment.status);
    format!(
        "{name}; {} hypotheses, the likeliest place {}, off the map {}",
        moment.hypotheses,
        words::percent(moment.place_p),
        words::percent(moment.off_map_p)
    )
}

/// A dot a square of the picture, at the mean of the hypotheses in it; light ones above heavy ones.
fn dots(moment: &Moment, fit: &Fit) -> Markup {
    let mut squares: BTreeMap<[i64; 2], (f64, [f64; 2])> = BTreeMap::new();
    for place in &moment.places {
        let at = fit.at(place.place_m);
        let square = squares.entry(at.map(|side| (side / CELL).floor() as i64)).or_default();
        square.0 += place.weight;
        for (sum, side) in square.1.iter_mut().zip(at) {
            *sum += place.weight * side;
        }
    }
    let mut dots: Vec<(f64, [f64; 2])> = squares
        .into_values()
        .filter(|(weight, _)| *weight > 0.0)
        .map(|(weight, sum)| (weight, sum.map(|side| side / weight)))
        .collect();
    dots.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (_, rgb) = palette::fix_status(moment.status);
    html! {
        g fill=(palette::css(rgb)) fill-opacity="0.75" {
            @for (weight, [x, y]) in dots {
                circle cx=(px(x)) cy=(px(y)) r=(px((RADIUS * weight.sqrt()).max(LEAST_RADIUS))) {}
            }
        }
    }
}
