//! Which blocks of the camera picture are looked at, and where they lie in the picture that is asked for.

use fingerpost_geometry::{Camera, GroundGrid, GroundPixel, Pixel};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::line_gradient::LineDirection;
use fingerpost_vision::log_colour::Block;
use fingerpost_vision::picture::{Rect, RgbImage};
use fingerpost_vision::warp::WarpTable;
use nalgebra::Point2;

use crate::ground_view::GroundView;
use crate::road_surface::{Perspective, RoadInput};

use super::OnlineConfig;

/// How far ahead the horizon is measured, metres: farther the road's row changes by less than a hundredth of a pixel.
const FAR_AWAY_M: f64 = 1e5;
/// Share of the rows above the horizon, next to it, that show what is certainly not road: walls, trees, sky; farther up it is
/// mostly sky, which is easy to tell.
const OTHER_SHARE: f64 = 0.4;
/// Most rows of blocks of it.
const MAX_OTHER_ROWS: usize = 24;

/// The blocks of a picture: a grid that starts at some row and reaches to the bottom.
#[derive(Debug)]
pub(super) struct Layout {
    asked: Asked,
    pub(super) block: Block,
    /// The first row of blocks of the picture that belongs to the grid.
    pub(super) first_row: usize,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Rows of the grid, from its top, that show no road.
    pub(super) other_rows: usize,
    /// Where the road's straight lines meet, and what slopes along them count.
    pub(super) lines: LineDirection,
    /// For each row of the grid, the width of the widest marking, blocks.
    pub(super) marking_widths: Vec<usize>,
    /// The blocks of the sample: column and row.
    pub(super) sample: Vec<(usize, usize)>,
    /// Those of them that the way starts from: the middle half of the width, the lower half of the height. A sample that
    /// reaches onto a kerb or a vehicle ahead teaches a few wrong colours; a way that started there would be lost.
    pub(super) starts: Vec<(usize, usize)>,
    /// From the grid to the picture that is asked for.
    pub(super) table: WarpTable,
}

/// What a layout was made for.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    size: (usize, usize),
    sample: Rect,
    place: Place,
}

#[derive(Debug, Clone, PartialEq)]
enum Place {
    Camera { horizon_row: f64 },
    Ground { camera: Box<Camera>, grid: GroundGrid },
}

impl Layout {
    /// The picture to look at: the camera's.
    pub(super) fn source<'a>(input: &RoadInput<'a>) -> &'a RgbImage {
        match input.perspective {
            Perspective::Camera { .. } => &input.picture.colour,
            Perspective::Ground { frame, .. } => frame,
        }
    }

    /// Whether the layout serves `input`.
    pub(super) fn serves(&self, input: &RoadInput<'_>) -> bool {
        let place_is_same = match (&self.asked.place, input.perspective) {
            (Place::Camera { horizon_row: known }, Perspective::Camera { horizon_row }) => {
                known.to_bits() == horizon_row.to_bits()
            }
            (Place::Ground { camera, grid }, Perspective::Ground { view, .. }) => {
                camera.as_ref() == view.camera() && grid == view.grid()
            }
            _ => false,
        };
        place_is_same && self.asked.sample == input.sample && self.asked.size == Self::source(input).size()
    }

    /// A layout for `input`.
    ///
    /// # Errors
    /// [`PictureError`] when the frame does not have the camera's size, or has no pixels.
    pub(super) fn new(config: &OnlineConfig, input: &RoadInput<'_>) -> Result<Self, PictureError> {
        let (width, height) = Self::source(input).size();
        if width == 0 || height == 0 {
            return Err(PictureError::Empty { what: "camera picture", width, height });
        }
        if let Perspective::Ground { view, .. } = input.perspective {
            let (expected_width, expected_height) = (view.camera().width(), view.camera().height());
            if (expected_width, expected_height) != (width, height) {
                return Err(PictureError::SizeMismatch {
                    what: "camera picture",
                    expected_width,
                    expected_height,
                    found_width: width,
                    found_height: height,
                });
            }
        }
        let block = Block::for_at_most(config.columns, config.rows, width, height);
        let (columns, block_rows) = block.grid(width, height);
        let (place, vanishing) = match input.perspective {
            Perspective::Camera { horizon_row } => {
                (Place::Camera { horizon_row }, Pixel::new(0.5 * (width as f64 - 1.0), horizon_row))
            }
            Perspective::Ground { view, .. } => (
                Place::Ground { camera: Box::new(view.camera().clone()), grid: *view.grid() },
                vanishing_point(view).unwrap_or(Pixel::new(0.5 * (width as f64 - 1.0), 0.0)),
            ),
        };
        let horizon = row_of(block, vanishing.v);
        let first_road_row = horizon.ceil().clamp(0.0, block_rows as f64) as usize;
        let other_rows = ((OTHER_SHARE * first_road_row as f64).ceil() as usize).min(MAX_OTHER_ROWS);
        let first_row = first_road_row - other_rows;
        let rows = block_rows - first_row;
        let lines = LineDirection {
            column: column_of(block, vanishing.u) as f32,
            row: (horizon - first_row as f64) as f32,
            along: config.edges_along as f32,
        };
        let block_shape = block.height as f64 / block.width as f64;
        let marking_widths = (first_row..block_rows)
            .map(|row| config.marking_width_heights * (row as f64 - horizon) * block_shape)
            .map(|width| width.round().clamp(0.0, columns as f64) as usize)
            .collect();
        let mut layout = Self {
            asked: Asked { size: (width, height), sample: input.sample, place },
            block,
            first_row,
            columns,
            rows,
            other_rows,
            lines,
            marking_widths,
            sample: Vec::new(),
            starts: Vec::new(),
            table: layout_table(input, block, first_row, (columns, rows))?,
        };
        layout.find_sample(input);
        Ok(layout)
    }

    /// Notes the road's blocks whose centres lie in the sample; of a smaller sample, the one at its centre.
    fn find_sample(&mut self, input: &RoadInput<'_>) {
        let Rect { x, y, width, height } = input.sample;
        let (half_width, half_height) = (0.5 * width as f64, 0.5 * height as f64);
        let middle = [x as f64 - 0.5 + half_width, y as f64 - 0.5 + half_height];
        for row in self.other_rows..self.rows {
            for column in 0..self.columns {
                let Some([u, v]) = asked_from_camera(input, self.centre(column, row)) else { continue };
                let (right, down) = (u - middle[0], v - middle[1]);
                if right.abs() < half_width && down.abs() < half_height {
                    self.sample.push((column, row));
                    if right.abs() < 0.5 * half_width && down > 0.0 {
                        self.starts.push((column, row));
                    }
                }
            }
        }
        if self.sample.is_empty() && width > 0 && height > 0 {
            self.sample.extend(camera_from_asked(input, middle).and_then(|p| self.cell(p)));
        }
        if self.starts.is_empty() {
            self.starts.clone_from(&self.sample);
        }
    }

    /// The centre of a block, pixels of the camera picture.
    fn centre(&self, column: usize, row: usize) -> Pixel {
        let u = (column as f64 + 0.5) * self.block.width as f64 - 0.5;
        let v = ((self.first_row + row) as f64 + 0.5) * self.block.height as f64 - 0.5;
        Pixel::new(u, v)
    }

    /// Row of the horizon, pixels of the camera picture.
    pub(super) fn horizon_row_px(&self) -> f64 {
        (f64::from(self.lines.row) + self.first_row as f64 + 0.5) * self.block.height as f64 - 0.5
    }

    /// The block of the road that holds a place of the camera picture.
    fn cell(&self, p: Pixel) -> Option<(usize, usize)> {
        let column = column_of(self.block, p.u).round();
        let row = row_of(self.block, p.v).round() - self.first_row as f64;
        let is_road = column >= 0.0
            && column < self.columns as f64
            && row >= self.other_rows as f64
            && row < self.rows as f64;
        is_road.then_some((column as usize, row as usize))
    }
}

/// Where straight roads ahead meet the horizon.
fn vanishing_point(view: &GroundView) -> Option<Pixel> {
    let foot = view.camera_foot();
    view.camera().pixel_of_ground(Point2::new(foot.x + FAR_AWAY_M, foot.y))
}

fn column_of(block: Block, u: f64) -> f64 {
    (u + 0.5) / block.width as f64 - 0.5
}

fn row_of(block: Block, v: f64) -> f64 {
    (v + 0.5) / block.height as f64 - 0.5
}

/// The place in the picture that is asked for which a place of the camera picture shows.
fn asked_from_camera(input: &RoadInput<'_>, p: Pixel) -> Option<[f64; 2]> {
    match input.perspective {
        Perspective::Camera { .. } => Some([p.u, p.v]),
        Perspective::Ground { view, .. } => {
            let GroundPixel { column, row } =
                view.grid().ground_from_vehicle(view.camera().ground_of_pixel(p)?);
            Some([column, row])
        }
    }
}

/// The place of the camera picture that a place of the picture that is asked for shows, where the camera sees it.
fn camera_from_asked(input: &RoadInput<'_>, [column, row]: [f64; 2]) -> Option<Pixel> {
    match input.perspective {
        Perspective::Camera { .. } => Some(Pixel::new(column, row)),
        Perspective::Ground { view, .. } => {
            let p_in_vehicle = view.grid().vehicle_from_ground(GroundPixel { column, row });
            view.camera().pixel_of_ground(p_in_vehicle).filter(|&p| view.camera().contains(p))
        }
    }
}

fn layout_table(
    input: &RoadInput<'_>,
    block: Block,
    first_row: usize,
    (columns, rows): (usize, usize),
) -> Result<WarpTable, PictureError> {
    let (width, height) = input.validity.size();
    WarpTable::new(width, height, columns, rows.max(1), |column, row| {
        let p = camera_from_asked(input, [column as f64, row as f64])?;
        // Half a block at the picture's edges lies beyond the centres of the outermost blocks.
        let last = |count: usize| count.saturating_sub(1) as f64;
        let u = column_of(block, p.u).clamp(0.0, last(columns));
        let v = (row_of(block, p.v) - first_row as f64).clamp(0.0, last(rows));
        Some([u, v])
    })
}
