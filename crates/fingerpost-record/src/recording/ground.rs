//! Planes of the ground view as grids on the road.

use fingerpost::feature_masks::PlacedMasks;
use fingerpost::road_surface::RoadSurface;
use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::picture::{Plane, Rect};
use foxglove::Decode;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{Grid, PackedElementField, Pose, Timestamp, Vector2, Vector3};
use nalgebra::UnitQuaternion;
use thiserror::Error;

use super::transforms::{VEHICLE, quaternion};

/// The field `known` where the frame shows the road; 1 where it is remembered, 0 where nothing is known.
const SEEN: u8 = 2;

/// Bytes of a grid from the nearest row to the farthest, each from left to right.
struct Cells {
    columns: usize,
    rows: usize,
    fields: Vec<PackedElementField>,
    bytes: Vec<u8>,
    cell_bytes: usize,
}

/// The probability of road and what it is known from.
pub(crate) fn road_surface(
    timestamp: Timestamp,
    grid: &GroundGrid,
    surface: &RoadSurface,
    seen: &Plane<u8>,
) -> Grid {
    let (columns, rows) = surface.probability.size();
    // A surface that was never summed up is known where it is seen.
    let summed = surface.known();
    let known = if summed.size() == seen.size() { summed.plane() } else { seen };
    let mut bytes = vec![0; 2 * columns * rows];
    let nearest_first = (0..rows.min(seen.height())).rev();
    for (row, cells) in nearest_first.zip(bytes.chunks_exact_mut((2 * columns).max(1))) {
        let shown = surface.probability.row(row).iter().zip(seen.row(row)).zip(known.row(row));
        for (cell, ((&road, &seen), &known)) in cells.as_chunks_mut::<2>().0.iter_mut().zip(shown) {
            let seen = if seen != 0 { SEEN } else { 0 };
            *cell = [road, seen.max(u8::from(known != 0))];
        }
    }
    let fields = vec![field("road", 0, NumericType::Uint8), field("known", 1, NumericType::Uint8)];
    message(timestamp, grid, Cells { columns, rows, fields, bytes, cell_bytes: 2 })
}

/// A road surface as it was recorded, its farthest row first, as in the ground view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedSurface {
    /// Probability of road; 255 stands for 1.
    pub probability: Plane<u8>,
    /// 0 where nothing is known, 1 where it is remembered, 2 where it is seen.
    pub known: Plane<u8>,
}

/// A message that is no road surface.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SurfaceError {
    /// It is no grid.
    #[error("the recorded road surface cannot be read ({0}); record the run again")]
    Damaged(String),
    /// It is another grid.
    #[error(
        "the recorded grid has not the two bytes a cell of a road surface; record the run again with this program"
    )]
    OtherGrid,
}

impl RecordedSurface {
    /// Reads a message of [`Channel::RoadSurface`](super::Channel::RoadSurface).
    ///
    /// # Errors
    /// [`SurfaceError`] when it holds none.
    pub fn from_message(bytes: &[u8]) -> Result<Self, SurfaceError> {
        let grid = Grid::decode(bytes).map_err(|cause| SurfaceError::Damaged(cause.to_string()))?;
        let columns = grid.column_count as usize;
        let is_surface = grid.cell_stride == 2 && columns > 0 && grid.row_stride as usize == 2 * columns;
        if !is_surface || grid.data.len() % (2 * columns) != 0 {
            return Err(SurfaceError::OtherGrid);
        }
        let rows = grid.data.len() / (2 * columns);
        let mut surface =
            Self { probability: Plane::new(columns, rows, 0), known: Plane::new(columns, rows, 0) };
        for (row, cells) in (0..rows).rev().zip(grid.data.chunks_exact(2 * columns)) {
            let written = surface.probability.row_mut(row).iter_mut().zip(surface.known.row_mut(row));
            for ((probability, known), cell) in written.zip(cells.as_chunks::<2>().0) {
                [*probability, *known] = *cell;
            }
        }
        Ok(surface)
    }
}

/// The sub-masks by their numbers from 1; where they lie on each other, the last.
pub(crate) fn masks(timestamp: Timestamp, grid: &GroundGrid, placed: &PlacedMasks<'_>) -> Grid {
    let (columns, rows) = (grid.columns(), grid.rows());
    let mut bytes = vec![0; columns * rows];
    let inside = Rect { x: 0, y: 0, width: columns, height: rows };
    for (sub, number) in placed.masks.subs.iter().zip(1..=u8::MAX) {
        let spans = sub.spans.translated(placed.column, placed.row).intersect_rect(inside);
        for span in spans.spans() {
            let first = (rows - 1 - span.row as usize) * columns;
            bytes[first + span.start as usize..first + span.end as usize].fill(number);
        }
    }
    let fields = vec![field("mask", 0, NumericType::Uint8)];
    message(timestamp, grid, Cells { columns, rows, fields, bytes, cell_bytes: 1 })
}

fn field(name: &str, offset: u32, of: NumericType) -> PackedElementField {
    PackedElementField { name: name.to_owned(), offset, r#type: of as i32 }
}

/// Cells of the ground view where they lie: columns to the right, rows ahead.
fn message(timestamp: Timestamp, grid: &GroundGrid, cells: Cells) -> Grid {
    // The outer corner of the nearest row's left cell.
    let below = cells.rows as f64 - 0.5;
    let corner = grid.vehicle_from_ground(GroundPixel { column: -0.5, row: below });
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, -std::f64::consts::FRAC_PI_2);
    let side_m = grid.metres_per_pixel();
    Grid {
        timestamp: Some(timestamp),
        frame_id: VEHICLE.to_owned(),
        pose: Some(Pose {
            position: Some(Vector3 { x: corner.x, y: corner.y, z: 0.0 }),
            orientation: Some(quaternion(&turn)),
        }),
        column_count: cells.columns as u32,
        cell_size: Some(Vector2 { x: side_m, y: side_m }),
        row_stride: (cells.columns * cells.cell_bytes) as u32,
        cell_stride: cells.cell_bytes as u32,
        fields: cells.fields,
        data: cells.bytes.into(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point2, Quaternion, Vector3 as Offset};

    use super::super::frame_recorder::encoded;
    use super::*;

    /// Where a viewer puts the middle of a cell: by the pose, columns along its x axis and rows along its y axis.
    fn cell_in_vehicle(grid: &Grid, column: u32, row: u32) -> Point2<f64> {
        let pose = grid.pose.as_ref().unwrap();
        let (at, q, cell) = (
            pose.position.as_ref().unwrap(),
            pose.orientation.as_ref().unwrap(),
            grid.cell_size.as_ref().unwrap(),
        );
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z));
        let offset =
            turn * Offset::new((f64::from(column) + 0.5) * cell.x, (f64::from(row) + 0.5) * cell.y, 0.0);
        Point2::new(at.x + offset.x, at.y + offset.y)
    }

    #[test]
    fn a_cell_lies_where_the_ground_view_has_it() {
        let ground = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        let probability = Plane::new(ground.columns(), ground.rows(), 0);
        let mut surface = RoadSurface { probability, ..RoadSurface::default() };
        let place = ground.ground_from_vehicle(Point2::new(10.0, 2.0));
        let (column, row) = (place.column.round() as usize, place.row.round() as usize);
        surface.probability.row_mut(row)[column] = 255;
        let seen = Plane::new(ground.columns(), ground.rows(), 255);
        let grid = road_surface(Timestamp::MIN, &ground, &surface, &seen);
        let at = grid.data.chunks_exact(2).position(|cell| cell[0] == 255).unwrap();
        let (column, row) = (at as u32 % grid.column_count, at as u32 / grid.column_count);
        let shown = cell_in_vehicle(&grid, column, row);
        assert!((shown - Point2::new(10.0, 2.0)).norm() < 0.04, "{shown}");
        assert!(grid.data.chunks_exact(2).all(|cell| cell[1] == 2), "all of it is seen");

        let read = RecordedSurface::from_message(&encoded(&grid).unwrap()).unwrap();
        assert_eq!(
            read,
            RecordedSurface { probability: surface.probability, known: Plane::new(400, 320, 2) }
        );
    }

    #[test]
    fn what_is_no_road_surface_is_refused() {
        let ground = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        let cells = Cells { columns: 4, rows: 3, fields: Vec::new(), bytes: vec![0; 12], cell_bytes: 1 };
        let masks = encoded(&message(Timestamp::MIN, &ground, cells)).unwrap();
        assert_eq!(RecordedSurface::from_message(&masks), Err(SurfaceError::OtherGrid));
        assert_eq!(RecordedSurface::from_message(&[]), Err(SurfaceError::OtherGrid));
        assert!(matches!(RecordedSurface::from_message(&[7; 9]), Err(SurfaceError::Damaged(_))));
    }
}
