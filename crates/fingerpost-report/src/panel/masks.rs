//! The feature's sub-masks on the road surface, each with its P(F_sub) in its own colour.

use fingerpost::feature_masks::{PlacedMasks, SubMask};
use fingerpost::matching::{Match, Participation, SubMatch};
use fingerpost_vision::picture::{Plane, Rect};

use super::ground_plot::GroundPlot;
use crate::draw::{Canvas, TextSize};
use crate::palette;
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "The feature's masks on the road surface (grey, light is road), with the mean probability \
    of road under each; P(F) is the smallest of those that take part. Dim: takes no part. Hatched: not seen.";

/// Opacity of masks that take part, and of those that do not.
const OPACITIES: [f64; 2] = [0.62, 0.22];

/// Draws the masks.
pub(crate) fn draw(canvas: &mut Canvas, plot: &GroundPlot<'_>, scene: &Scene<'_>) {
    let (surface, validity) = (&scene.evidence.surface.probability, scene.evidence.validity);
    let followed = scene.output.track.followed.as_ref();
    let coloured = followed.zip(scene.evidence.masks.as_ref()).map(|(followed, placed)| {
        let mut overlay = Plane::new(plot.grid.columns(), plot.grid.rows(), NO_MASK);
        for (index, sub) in placed.masks.subs.iter().enumerate() {
            paint(&mut overlay, sub, placed, index);
        }
        (overlay, &followed.matched, placed)
    });
    plot.raster(canvas, validity, |column, row| {
        let ground = palette::shade(surface.get(column, row).unwrap_or(0));
        let Some((overlay, matched, placed)) = &coloured else { return ground };
        let sub = overlay.get(column, row).and_then(|index| placed.masks.subs.get(usize::from(index)));
        sub.map_or(ground, |sub| {
            palette::mix(ground, palette::sub_mask(&sub.label), opacity(matched, &sub.label))
        })
    });
    plot.metre_lines(canvas);
    canvas.clipped(plot.area, |canvas| match &coloured {
        Some((overlay, matched, placed)) => labels(canvas, plot, validity, overlay, matched, placed),
        None => {
            let corner = [plot.area.x as f64 + 8.0, plot.area.y as f64 + 6.0];
            canvas.label(corner, TextSize::Small, palette::TEXT_DIM, "no feature is followed");
        }
    });
}

/// No sub-mask in the overlay of sub-masks' indices; a feature has fewer arms than this.
const NO_MASK: u8 = u8::MAX;

/// Writes a sub-mask's index under it; later ones (the driving line last) lie on top.
fn paint(overlay: &mut Plane<u8>, sub: &SubMask, placed: &PlacedMasks<'_>, index: usize) {
    let (width, height) = overlay.size();
    let inside = Rect { x: 0, y: 0, width, height };
    let spans = sub.spans.translated(placed.column, placed.row).intersect_rect(inside);
    for span in spans.spans() {
        let (row, columns) = (span.row as usize, span.start as usize..span.end as usize);
        overlay.row_mut(row)[columns].fill(u8::try_from(index).unwrap_or(NO_MASK));
    }
}

fn opacity(matched: &Match, label: &str) -> f64 {
    let takes_part = part(matched, label).is_some_and(|sub| sub.participation == Participation::TakesPart);
    if takes_part { OPACITIES[0] } else { OPACITIES[1] }
}

fn part<'m>(matched: &'m Match, label: &str) -> Option<&'m SubMatch> {
    matched.subs.iter().find(|sub| sub.label == label)
}

/// P(F_sub) of every sub-mask beside the middle of what is seen of it.
fn labels(
    canvas: &mut Canvas,
    plot: &GroundPlot<'_>,
    validity: &Plane<u8>,
    overlay: &Plane<u8>,
    matched: &Match,
    placed: &PlacedMasks<'_>,
) {
    let mut plates: Vec<Rect> = Vec::new();
    for (index, sub) in placed.masks.subs.iter().enumerate() {
        let Some(place) = middle(overlay, validity, index) else { continue };
        let Some(part) = part(matched, &sub.label) else { continue };
        let (size, text) = match (part.participation, part.p) {
            (Participation::TakesPart, Some(p)) => (TextSize::SmallBold, format!("{p:.2}")),
            (Participation::TooShort, _) => (TextSize::Small, "short".to_owned()),
            _ => (TextSize::Small, "cut".to_owned()),
        };
        let [x, mut y] = plot.at_pixel(place);
        let mut plate = canvas.plate([x - 18.0, y - 8.0], size, &text);
        while plates.iter().any(|other| overlap(other, &plate)) && y < canvas_bottom(plot) {
            y += 4.0;
            plate = canvas.plate([x - 18.0, y - 8.0], size, &text);
        }
        plates.push(canvas.label([x - 18.0, y - 8.0], size, palette::sub_mask(&sub.label), &text));
    }
}

fn canvas_bottom(plot: &GroundPlot<'_>) -> f64 {
    (plot.area.y + plot.area.height) as f64
}

const fn overlap(a: &Rect, b: &Rect) -> bool {
    a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height
}

/// The seen pixel of a sub-mask nearest to the mean of all of them: on the mask even where it bends.
fn middle(overlay: &Plane<u8>, validity: &Plane<u8>, index: usize) -> Option<[f64; 2]> {
    let (width, height) = overlay.size();
    let pixels = || {
        (0..height).flat_map(move |row| (0..width).map(move |column| (column, row))).filter(
            move |&(column, row)| {
                overlay.get(column, row).map(usize::from) == Some(index)
                    && validity.get(column, row) != Some(0)
            },
        )
    };
    let (mut count, mut sum) = (0.0, [0.0, 0.0]);
    for (column, row) in pixels() {
        count += 1.0;
        sum = [sum[0] + column as f64, sum[1] + row as f64];
    }
    let mean = sum.map(|s| s / count);
    pixels()
        .map(|(column, row)| [column as f64, row as f64])
        .min_by(|a, b| distance(*a, mean).total_cmp(&distance(*b, mean)))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
