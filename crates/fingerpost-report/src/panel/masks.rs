//! The feature's sub-masks on the road surface, each with its P(F_sub) in its own colour.

use fingerpost::feature_masks::{PlacedMasks, SubMask};
use fingerpost::matching::{Match, Participation, SubMatch};
use fingerpost_vision::picture::{Plane, Rect};

use super::ground_plot::GroundPlot;
use crate::draw::{Canvas, Paint, TextSize};
use crate::palette;
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "The feature's masks on the road surface (grey, light is road), with the mean probability \
    of road under each; P(F) is the smallest of those that take part. Dim: takes no part. Hatched: not known.";

/// Opacity of masks that take part, and of those that do not.
const OPACITIES: [f64; 2] = [0.62, 0.22];

/// Draws the masks.
pub(crate) fn draw(canvas: &mut Canvas, plot: &GroundPlot<'_>, scene: &Scene<'_>) {
    let surface = &scene.evidence.surface.probability;
    let known = scene.evidence.surface.known();
    let validity = if known.size() == surface.size() { known.plane() } else { scene.evidence.validity };
    let coloured = scene.matched().zip(scene.evidence.masks.as_ref()).map(|(matched, placed)| {
        let mut overlay = Plane::new(plot.grid.columns(), plot.grid.rows(), 0);
        for (index, sub) in placed.masks.subs.iter().enumerate() {
            paint(&mut overlay, sub, placed, index);
        }
        (overlay, matched, placed)
    });
    let paints: Vec<Paint> =
        coloured.iter().flat_map(|(_, matched, placed)| paints(matched, placed)).collect();
    plot.raster(canvas, validity, |column, row| {
        let ground = palette::shade(surface.get(column, row).unwrap_or(0));
        let Some(bits) = coloured.as_ref().and_then(|(overlay, ..)| overlay.get(column, row)) else {
            return ground;
        };
        if bits == 0 {
            return ground;
        }
        let laid = paints.iter().enumerate().filter(|&(index, _)| bits & bit(index) != 0);
        laid.fold(ground, |under, (_, paint)| palette::mix(under, paint.colour, paint.opacity))
    });
    plot.metre_lines(canvas);
    canvas.clipped(plot.area, |canvas| match &coloured {
        Some((overlay, matched, placed)) => labels(canvas, plot, validity, overlay, matched, placed),
        None => {
            let corner = [plot.area.x as f64 + 8.0, plot.area.y as f64 + 6.0];
            canvas.label(corner, TextSize::Small, palette::TEXT_DIM, "no feature is followed or in reach");
        }
    });
}

/// Which sub-masks lie on each pixel, one bit each.
type Overlay = Plane<u32>;

/// Bit of a sub-mask in the overlay; those beyond the last bit, of which no real junction has any, are not shown.
fn bit(index: usize) -> u32 {
    u32::try_from(index).ok().and_then(|index| 1_u32.checked_shl(index)).unwrap_or(0)
}

/// Marks the pixels of a sub-mask.
fn paint(overlay: &mut Overlay, sub: &SubMask, placed: &PlacedMasks<'_>, index: usize) {
    let (width, height) = overlay.size();
    let inside = Rect { x: 0, y: 0, width, height };
    let spans = sub.spans.translated(placed.column, placed.row).intersect_rect(inside);
    for span in spans.spans() {
        let (row, columns) = (span.row as usize, span.start as usize..span.end as usize);
        overlay.row_mut(row)[columns].iter_mut().for_each(|bits| *bits |= bit(index));
    }
}

/// How each sub-mask is laid on.
fn paints(matched: &Match, placed: &PlacedMasks<'_>) -> Vec<Paint> {
    let subs = placed.masks.subs.iter();
    subs.map(|sub| {
        let takes_part =
            part(matched, &sub.label).is_some_and(|sub| sub.participation == Participation::TakesPart);
        Paint::glaze(palette::sub_mask(&sub.label), if takes_part { OPACITIES[0] } else { OPACITIES[1] })
    })
    .collect()
}

fn part<'m>(matched: &'m Match, label: &str) -> Option<&'m SubMatch> {
    matched.subs.iter().find(|sub| &*sub.label == label)
}

/// P(F_sub) of every sub-mask beside the middle of what is seen of it.
fn labels(
    canvas: &mut Canvas,
    plot: &GroundPlot<'_>,
    validity: &Plane<u8>,
    overlay: &Overlay,
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

/// A seen pixel in the middle of a sub-mask, of the part that is its own where there is one.
fn middle(overlay: &Overlay, validity: &Plane<u8>, index: usize) -> Option<[f64; 2]> {
    middle_of(overlay, validity, |bits| bits == bit(index))
        .or_else(|| middle_of(overlay, validity, |bits| bits & bit(index) != 0))
}

/// The seen pixel nearest to the mean of all that `belongs` picks: on the mask even where it bends.
fn middle_of(
    overlay: &Overlay,
    validity: &Plane<u8>,
    belongs: impl Fn(u32) -> bool + Copy,
) -> Option<[f64; 2]> {
    let pixels = || {
        (0..overlay.height()).flat_map(move |row| {
            let cells = overlay.row(row).iter().zip(validity.row(row)).enumerate();
            cells
                .filter(move |&(_, (&bits, &seen))| seen != 0 && bits != 0 && belongs(bits))
                .map(move |(column, _)| [column as f64, row as f64])
        })
    };
    let (count, sum) =
        pixels().fold((0.0, [0.0, 0.0]), |(n, [x, y]), [column, row]| (n + 1.0, [x + column, y + row]));
    let mean = sum.map(|s| s / count);
    pixels().min_by(|a, b| distance(*a, mean).total_cmp(&distance(*b, mean)))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
