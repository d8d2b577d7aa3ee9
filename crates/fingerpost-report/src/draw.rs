//! Drawing on a picture in memory: antialiased lines, polygons, discs, pictures and text, clipped to an area.
//!
//! Every shape first leaves its coverage in a scratch plane, the largest of its parts winning, and is then blended at
//! once: a transparent line does not darken where its pieces meet. Pixel centres have whole coordinates. Points that
//! are not finite are left out; points far outside the picture cost nothing.

mod shape;
mod text;

use std::ops::Range;

use fingerpost_vision::picture::{Rect, RgbImage};

use crate::palette::Rgb;

pub(crate) use text::{TextSize, text_width_px, wrapped};

/// A colour and how much of it is laid on, 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint {
    pub(crate) colour: Rgb,
    pub(crate) opacity: f64,
}

impl Paint {
    pub(crate) const fn solid(colour: Rgb) -> Self {
        Self { colour, opacity: 1.0 }
    }

    pub(crate) const fn glaze(colour: Rgb, opacity: f64) -> Self {
        Self { colour, opacity }
    }
}

/// A picture to draw on.
#[derive(Debug)]
pub(crate) struct Canvas {
    image: RgbImage,
    clip: Rect,
    /// Coverage of the shape at hand, 255 = whole; zero everywhere between shapes.
    coverage: Vec<u8>,
    /// Columns and rows that hold all of it; none between shapes.
    covered: Option<[Range<usize>; 2]>,
}

impl Canvas {
    pub(crate) fn new(width: usize, height: usize, background: Rgb) -> Self {
        let clip = Rect { x: 0, y: 0, width, height };
        let mut canvas = Self {
            image: RgbImage::new(width, height),
            clip,
            coverage: vec![0; width * height],
            covered: None,
        };
        canvas.fill(clip, Paint::solid(background));
        canvas
    }

    pub(crate) fn into_image(self) -> RgbImage {
        self.image
    }

    /// Draws with everything outside `clip` left as it is.
    pub(crate) fn clipped(&mut self, clip: Rect, draw: impl FnOnce(&mut Self)) {
        let before = self.clip;
        let (x, y) = (clip.x.max(before.x), clip.y.max(before.y));
        let right = (clip.x + clip.width).min(before.x + before.width).max(x);
        let bottom = (clip.y + clip.height).min(before.y + before.height).max(y);
        self.clip = Rect { x, y, width: right - x, height: bottom - y };
        draw(self);
        self.clip = before;
    }

    /// Fills a rectangle.
    pub(crate) fn fill(&mut self, rect: Rect, paint: Paint) {
        self.clipped(rect, |canvas| {
            let clip = canvas.clip;
            for y in clip.y..clip.y + clip.height {
                for x in clip.x..clip.x + clip.width {
                    canvas.blend(x, y, paint.colour, paint.opacity);
                }
            }
        });
    }

    /// Fills `area` with the colours of a source of `source_px` pixels, given by column and row: the mean of four
    /// places in each pixel, which makes reductions smooth.
    pub(crate) fn picture(
        &mut self,
        area: Rect,
        source_px: (usize, usize),
        colour_at: impl Fn(usize, usize) -> Rgb,
    ) {
        let (columns, rows) = source_px;
        if columns == 0 || rows == 0 {
            return;
        }
        // The two places in a pixel of the area, `length` pixels long, that are looked at along one axis.
        let places = |at: usize, length: usize, source: usize| {
            [0.25, 0.75].map(|quarter| {
                let share = (at as f64 + quarter) / length as f64;
                ((share * source as f64) as usize).min(source - 1)
            })
        };
        let columns: Vec<[usize; 2]> = (0..area.width).map(|at| places(at, area.width, columns)).collect();
        self.clipped(area, |canvas| {
            let clip = canvas.clip;
            for y in clip.y..clip.y + clip.height {
                let rows = places(y - area.y, area.height, rows);
                let (pixels, _) = canvas.image.row_mut(y).as_chunks_mut::<3>();
                let pixels = pixels.iter_mut().skip(clip.x).take(clip.width);
                for (pixel, columns) in pixels.zip(columns.iter().skip(clip.x - area.x)) {
                    // Where nothing is reduced the four places are one.
                    if rows[0] == rows[1] && columns[0] == columns[1] {
                        *pixel = colour_at(columns[0], rows[0]);
                        continue;
                    }
                    let mut sum = [2_u16; 3];
                    for row in rows {
                        for &column in columns {
                            let colour = colour_at(column, row);
                            sum.iter_mut().zip(colour).for_each(|(sum, c)| *sum += u16::from(c));
                        }
                    }
                    *pixel = sum.map(|sum| (sum / 4) as u8);
                }
            }
        });
    }

    fn blend(&mut self, x: usize, y: usize, colour: Rgb, opacity: f64) {
        let (pixels, _) = self.image.row_mut(y).as_chunks_mut::<3>();
        if let Some(pixel) = pixels.get_mut(x) {
            *pixel = if opacity < 1.0 { crate::palette::mix(*pixel, colour, opacity) } else { colour };
        }
    }

    /// Notes that the shape at hand covers a pixel inside the clip by `share`.
    fn cover(&mut self, x: usize, y: usize, share: f64) {
        let width = self.image.width();
        if let Some(coverage) = self.coverage.get_mut(y * width + x) {
            *coverage = (*coverage).max((255.0 * share.clamp(0.0, 1.0)).round() as u8);
            let covered = self.covered.get_or_insert([x..x + 1, y..y + 1]);
            for (range, at) in covered.iter_mut().zip([x, y]) {
                *range = range.start.min(at)..range.end.max(at + 1);
            }
        }
    }

    /// Blends what is covered and clears the coverage.
    fn lay(&mut self, paint: Paint) {
        let width = self.image.width();
        let Some([columns, rows]) = self.covered.take() else { return };
        for y in rows {
            for x in columns.clone() {
                let coverage = std::mem::take(&mut self.coverage[y * width + x]);
                if coverage > 0 {
                    self.blend(x, y, paint.colour, paint.opacity * f64::from(coverage) / 255.0);
                }
            }
        }
    }

    /// The columns of the clip from `from` to `to`, both included.
    fn columns(&self, from: f64, to: f64) -> Range<usize> {
        whole_range(from, to, self.clip.x, self.clip.width)
    }

    /// The rows of the clip from `from` to `to`, both included.
    fn rows(&self, from: f64, to: f64) -> Range<usize> {
        whole_range(from, to, self.clip.y, self.clip.height)
    }
}

/// The whole numbers from `from` to `to` that lie in the `length` numbers from `start` on.
fn whole_range(from: f64, to: f64, start: usize, length: usize) -> Range<usize> {
    let (low, high) = (start as f64, (start + length) as f64);
    let first = from.ceil().clamp(low, high) as usize;
    let end = (to.floor() + 1.0).clamp(low, high) as usize;
    first..end.max(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Paint = Paint::solid([255; 3]);

    fn canvas() -> Canvas {
        Canvas::new(20, 10, [0; 3])
    }

    fn lit(canvas: Canvas) -> Vec<(usize, usize)> {
        let image = canvas.into_image();
        let all = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
        all.filter(|&(x, y)| image.get(x, y).unwrap()[0] > 127).collect()
    }

    #[test]
    fn a_line_covers_the_pixels_on_it() {
        let mut canvas = canvas();
        canvas.polyline(&[[2.0, 3.0], [6.0, 3.0]], 1.0, WHITE);
        // The caps are round: an end pixel is covered, the one beyond it only by half.
        let row: Vec<_> = lit(canvas).into_iter().filter(|&(x, _)| (2..=6).contains(&x)).collect();
        assert_eq!(row, [(2, 3), (3, 3), (4, 3), (5, 3), (6, 3)]);
    }

    #[test]
    fn a_polygon_covers_its_inside_exactly() {
        let mut canvas = canvas();
        canvas.polygon(&[[1.5, 1.5], [4.5, 1.5], [4.5, 3.5], [1.5, 3.5]], WHITE);
        assert_eq!(lit(canvas), [(2, 2), (3, 2), (4, 2), (2, 3), (3, 3), (4, 3)]);
    }

    #[test]
    fn a_transparent_line_is_even_where_it_turns() {
        let mut canvas = canvas();
        canvas.polyline(&[[2.0, 5.0], [10.0, 5.0], [2.0, 5.0]], 3.0, Paint::glaze([200; 3], 0.5));
        let image = canvas.into_image();
        assert_eq!(image.get(6, 5), Some([100; 3]), "laid on once, though passed twice");
    }

    #[test]
    fn nothing_is_drawn_outside_the_clip_or_from_bad_numbers() {
        let mut canvas = canvas();
        canvas.clipped(Rect { x: 5, y: 5, width: 3, height: 2 }, |canvas| {
            canvas.polyline(&[[-1e12, 5.0], [1e12, 5.0]], 1.0, WHITE);
            canvas.polygon(&[[f64::NAN, 0.0], [f64::INFINITY, 1.0], [3.0, 3.0]], WHITE);
            canvas.disc([f64::NAN, 5.0], 3.0, WHITE);
        });
        assert_eq!(lit(canvas), [(5, 5), (6, 5), (7, 5)]);
    }

    #[test]
    fn a_picture_keeps_left_and_top() {
        let mut canvas = canvas();
        let area = Rect { x: 0, y: 0, width: 8, height: 8 };
        canvas.picture(area, (2, 2), |column, row| if (column, row) == (1, 0) { [255; 3] } else { [0; 3] });
        assert!(lit(canvas).iter().all(|&(x, y)| (4..8).contains(&x) && y < 4));
    }

    #[test]
    fn text_is_drawn_where_it_is_put_and_as_wide_as_stated() {
        let mut canvas = Canvas::new(200, 40, [0; 3]);
        canvas.text([10.0, 10.0], TextSize::Small, [255; 3], "12.3 m ü");
        let lit = lit(canvas);
        let width = text_width_px(TextSize::Small, "12.3 m ü");
        assert!(lit.len() > 40);
        assert!(lit.iter().all(|&(x, y)| (10..10 + width).contains(&x) && (10..27).contains(&y)));
    }

    #[test]
    fn long_sentences_are_broken_between_words_and_cut_at_the_last_line() {
        assert_eq!(wrapped("one two three", 7, 3), ["one two", "three"]);
        assert_eq!(wrapped("one two three four", 8, 2), ["one two", "three..."]);
        assert_eq!(wrapped("abcdefghijk", 4, 2), ["abcd", "e..."]);
    }
}
