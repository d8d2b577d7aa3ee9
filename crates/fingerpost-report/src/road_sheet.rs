//! A contact sheet of road surfaces: every row a picture, and beside it what each detector made of it.

use fingerpost_vision::picture::{Plane, Rect, RgbImage};

use crate::draw::{Canvas, Paint, TextSize};
use crate::palette::{self, Rgb};
use crate::panel::fitted;

/// Width of a picture on the sheet, pixels: five of them fit beside one another on a screen.
const CELL_WIDTH_PX: usize = 360;
/// Height of the room for a picture, pixels.
const CELL_HEIGHT_PX: usize = 270;
/// Height of the line above a picture, pixels.
const CAPTION_PX: usize = 18;
const GAP_PX: usize = 6;
/// Share of the probability's colour over the picture: both can be made out.
const OVERLAY: f64 = 0.5;

/// A picture and its road surfaces.
#[derive(Debug)]
pub struct RoadSheetRow<'a> {
    /// What the picture is called.
    pub caption: String,
    /// The picture.
    pub picture: &'a RgbImage,
    /// 1 where the picture's labels say road, 0 elsewhere, in the picture's size; none without labels.
    pub labelled: Option<&'a Plane<u8>>,
    /// What was made of it.
    pub surfaces: Vec<RoadSheetCell<'a>>,
}

/// A road surface on the sheet.
#[derive(Debug)]
pub struct RoadSheetCell<'a> {
    /// What found it.
    pub caption: String,
    /// Probability of road, 255 = 1.
    pub probability: &'a Plane<u8>,
    /// Probability from which a pixel counts as road.
    pub threshold: u8,
}

/// Draws the sheet: pictures at the left, over which labelled road is outlined; then each surface's probability from dark
/// (0) to yellow (1) over the picture, with an outline at its threshold.
pub fn road_sheet(rows: &[RoadSheetRow<'_>]) -> RgbImage {
    let columns = 1 + rows.iter().map(|row| row.surfaces.len()).max().unwrap_or(0);
    let row_px = CAPTION_PX + CELL_HEIGHT_PX + GAP_PX;
    let (width, height) = (columns * (CELL_WIDTH_PX + GAP_PX) + GAP_PX, rows.len() * row_px + GAP_PX);
    let mut canvas = Canvas::new(width, height, palette::BACKGROUND);
    for (index, row) in rows.iter().enumerate() {
        let y = GAP_PX + index * row_px;
        let original = |column, line| row.picture.get(column, line).unwrap_or(palette::UNSEEN);
        cell(&mut canvas, [0, y], &row.caption, row.picture.size(), original, |column, line| {
            row.labelled.and_then(|labelled| labelled.get(column, line)).is_some_and(|label| label != 0)
        });
        for (column, surface) in row.surfaces.iter().enumerate() {
            let p = |column, line| surface.probability.get(column, line).unwrap_or(0);
            let colour =
                |column, line| palette::mix(original(column, line), palette::heat(p(column, line)), OVERLAY);
            let inside = |column, line| p(column, line) >= surface.threshold.max(1);
            let place = [1 + column, y];
            cell(&mut canvas, place, &surface.caption, surface.probability.size(), colour, inside);
        }
    }
    canvas.into_image()
}

/// A picture with its caption in a column of the sheet, and the outline of what is `inside`.
fn cell(
    canvas: &mut Canvas,
    [column, y]: [usize; 2],
    caption: &str,
    source_px: (usize, usize),
    colour_at: impl Fn(usize, usize) -> Rgb,
    inside: impl Fn(usize, usize) -> bool,
) {
    let x = GAP_PX + column * (CELL_WIDTH_PX + GAP_PX);
    let whole = Rect { x, y, width: CELL_WIDTH_PX, height: CAPTION_PX + CELL_HEIGHT_PX };
    canvas.clipped(whole, |canvas| {
        canvas.text([x as f64, y as f64], TextSize::Small, palette::TEXT_DIM, caption);
    });
    let room = Rect { y: y + CAPTION_PX, height: CELL_HEIGHT_PX, ..whole };
    let area = fitted(source_px, room);
    canvas.picture(area, source_px, colour_at);
    let source =
        |at: usize, length: usize, source: usize| (at * source / length.max(1)).min(source.saturating_sub(1));
    let shown = |dx: usize, dy: usize| {
        inside(source(dx, area.width, source_px.0), source(dy, area.height, source_px.1))
    };
    for dy in 1..area.height {
        for dx in 1..area.width {
            let here = shown(dx, dy);
            if here != shown(dx - 1, dy) || here != shown(dx, dy - 1) {
                let pixel = Rect { x: area.x + dx, y: area.y + dy, width: 1, height: 1 };
                canvas.fill(pixel, Paint::solid(palette::TEXT));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_shows_its_picture_and_its_surfaces_side_by_side() {
        let mut picture = RgbImage::new(36, 27);
        picture.as_mut_slice().fill(200);
        let mut probability = Plane::new(36, 27, 0);
        (14..27).for_each(|row| probability.row_mut(row).fill(255));
        let surface = || RoadSheetCell { caption: "a".to_owned(), probability: &probability, threshold: 128 };
        let row = || RoadSheetRow {
            caption: "0.png".to_owned(),
            picture: &picture,
            labelled: None,
            surfaces: vec![surface(), surface()],
        };
        let sheet = road_sheet(&[row(), row()]);
        assert_eq!(sheet.size(), (3 * 366 + 6, 2 * 294 + 6));
        for y in [6 + 18, 6 + 294 + 18] {
            assert_eq!(sheet.get(100, y + 100), Some([200; 3]), "the picture");
            for x in [366, 732] {
                let at = |row: usize| sheet.get(x + 100, y + row).unwrap();
                assert_eq!(at(200), palette::mix([200; 3], palette::heat(255), OVERLAY), "road");
                assert_eq!(at(50), palette::mix([200; 3], palette::heat(0), OVERLAY), "no road");
                assert!((138..142).any(|row| at(row) == palette::TEXT), "the outline between them");
            }
        }
        assert_eq!(road_sheet(&[]).size(), (372, 6));
    }
}
