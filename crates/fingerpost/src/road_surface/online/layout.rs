//! Which blocks of the camera picture are looked at, and where they lie in the picture that is asked for.

use std::ops::Range;

use fingerpost_geometry::Pixel;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::line_gradient::LineDirection;
use fingerpost_vision::log_colour::Block;
use fingerpost_vision::picture::{Plane, Rect};
use fingerpost_vision::warp::WarpTable;

use crate::road_surface::perspective::KnownPerspective;
use crate::road_surface::{Perspective, RoadInput};

use super::OnlineConfig;

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
    /// The blocks of the sample.
    pub(super) sample: Vec<BlockRun>,
    /// Those of them that the way starts from, column and row: the middle half of the width, the lower half of the height. A sample that
    /// reaches onto a kerb or a vehicle ahead teaches a few wrong colours; a way that started there would be lost.
    pub(super) starts: Vec<(usize, usize)>,
    /// From the grid to the picture that is asked for.
    pub(super) table: WarpTable,
}

/// Neighbouring blocks of a row.
#[derive(Debug, Clone)]
pub(super) struct BlockRun {
    row: usize,
    columns: Range<usize>,
}

/// What a layout was made for.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    size: (usize, usize),
    sample: Rect,
    perspective: KnownPerspective,
}

impl Layout {
    /// Whether the layout serves `input`.
    pub(super) fn serves(&self, input: &RoadInput<'_>) -> bool {
        self.asked.perspective.is(input.perspective)
            && self.asked.sample == input.sample
            && self.asked.size == input.camera_picture().size()
    }

    /// A layout for `input`.
    ///
    /// # Errors
    /// [`PictureError`] when the frame does not have the camera's size, or has no pixels.
    pub(super) fn new(config: &OnlineConfig, input: &RoadInput<'_>) -> Result<Self, PictureError> {
        let (width, height) = input.camera_picture().size();
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
        let vanishing = input.vanishing_point();
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
        let reduced_from_camera = |p: Pixel| [column_of(block, p.u), row_of(block, p.v) - first_row as f64];
        let perspective = KnownPerspective::of(input.perspective);
        let mut layout = Self {
            asked: Asked { size: (width, height), sample: input.sample, perspective },
            block,
            first_row,
            columns,
            rows,
            other_rows,
            lines,
            marking_widths,
            sample: Vec::new(),
            starts: Vec::new(),
            table: input.table_from_reduced((columns, rows), reduced_from_camera)?,
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
                let Some([u, v]) = input.asked_from_camera(self.centre(column, row)) else { continue };
                let (right, down) = (u - middle[0], v - middle[1]);
                if right.abs() < half_width && down.abs() < half_height {
                    self.add_to_sample(column, row);
                    if right.abs() < 0.5 * half_width && down > 0.0 {
                        self.starts.push((column, row));
                    }
                }
            }
        }
        if self.sample.is_empty()
            && width > 0
            && height > 0
            && let Some((column, row)) = input.camera_from_asked(middle).and_then(|p| self.cell(p))
        {
            self.add_to_sample(column, row);
        }
        if self.starts.is_empty() {
            for BlockRun { row, columns } in &self.sample {
                self.starts.extend(columns.clone().map(|column| (column, *row)));
            }
        }
    }

    fn add_to_sample(&mut self, column: usize, row: usize) {
        match self.sample.last_mut() {
            Some(run) if run.row == row && run.columns.end == column => run.columns.end += 1,
            _ => self.sample.push(BlockRun { row, columns: column..column + 1 }),
        }
    }

    /// Number of blocks of the sample.
    pub(super) fn sample_blocks(&self) -> usize {
        self.sample.iter().map(|run| run.columns.len()).sum()
    }

    /// Fills `taken` with the sample's values in `plane`, a value a block.
    pub(super) fn take_sample(&self, plane: &Plane<f32>, taken: &mut Vec<f32>) {
        taken.clear();
        for run in &self.sample {
            taken.extend_from_slice(&plane.row(run.row)[run.columns.clone()]);
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

fn column_of(block: Block, u: f64) -> f64 {
    (u + 0.5) / block.width as f64 - 0.5
}

fn row_of(block: Block, v: f64) -> f64 {
    (v + 0.5) / block.height as f64 - 0.5
}
