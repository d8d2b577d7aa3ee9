//! The board in a lattice, and its corners in their order.

use crate::picture::PlaneView;

use super::lattice::Lattice;
use super::subpixel::refined;
use super::{BoardSize, ChessboardError};

/// Fewest crossings that are a part of a board and not of something else.
const LEAST_PART: usize = 6;
/// A corner this many squares from the picture's edge, or nearer, has neighbours beyond it.
const BESIDE_EDGE: f64 = 1.2;
/// How far about a corner its pixels count, as a share of the distance to its nearest neighbour: no other corner is reached.
const REACH_SHARE: f64 = 0.35;
/// Least and most of that reach, pixels; on a large square more pixels add what is not flat.
const REACHES_PX: (f64, f64) = (2.0, 11.0);

/// The board's corners in their order.
pub(super) fn corners_of(
    lattice: &Lattice,
    size: BoardSize,
    picture: (usize, usize),
) -> Result<Vec<[f64; 2]>, ChessboardError> {
    let Some([left, right, top, bottom]) = lattice.bounds().filter(|_| lattice.len() >= LEAST_PART) else {
        return Err(ChessboardError::NotFound);
    };
    let (across, down) = ((right - left + 1) as usize, (bottom - top + 1) as usize);
    let ways: &[Way] = if size.columns == size.rows { &[Way::Across] } else { &[Way::Across, Way::Down] };
    let mut boards = Vec::new();
    for &way in ways {
        for first_row in top..=bottom {
            for first_column in left..=right {
                boards.extend(window(lattice, size, way, (first_column, first_row)));
            }
        }
    }
    match boards.len() {
        0 => Err(incomplete(lattice, size, (across.max(down), across.min(down)), picture)),
        1 => Ok(turned(boards.swap_remove(0), size)),
        _ => Err(ChessboardError::Larger { columns: across.max(down), rows: across.min(down) }),
    }
}

/// Which way the board's rows run in the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Across,
    Down,
}

/// The corners of a board that begins in a column and row of the lattice; none where one is missing.
fn window(lattice: &Lattice, size: BoardSize, way: Way, (column, row): (i32, i32)) -> Option<Vec<[f64; 2]>> {
    let (columns, rows) = (size.columns as i32, size.rows as i32);
    let places = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r)));
    places
        .map(|(c, r)| match way {
            Way::Across => lattice.at((column + c, row + r)),
            // Rows of the board run down the lattice: the next one lies to the left, still clockwise from it.
            Way::Down => lattice.at((column + rows - 1 - r, row + c)),
        })
        .collect()
}

/// The corners with rows that run to the right.
fn turned(corners: Vec<[f64; 2]>, size: BoardSize) -> Vec<[f64; 2]> {
    let last = size.count() - 1;
    let reversed: Vec<_> = corners.iter().rev().copied().collect();
    let to_right = |corners: &[[f64; 2]]| corners[size.columns - 1][0] - corners[0][0];
    let mut ways = vec![corners, reversed];
    if size.columns == size.rows {
        let side = size.columns;
        let quarter: Vec<_> = (0..=last).map(|i| ways[0][(side - 1 - i % side) * side + i / side]).collect();
        let back = quarter.iter().rev().copied().collect();
        ways.extend([quarter, back]);
    }
    ways.into_iter().max_by(|a, b| to_right(a).total_cmp(&to_right(b))).unwrap_or_default()
}

fn incomplete(
    lattice: &Lattice,
    size: BoardSize,
    (columns, rows): (usize, usize),
    (width, height): (usize, usize),
) -> ChessboardError {
    if columns > size.columns.max(size.rows) || rows > size.columns.min(size.rows) {
        return ChessboardError::Larger { columns, rows };
    }
    let (found, expected) = (lattice.len(), size.count());
    let (w, h) = (width as f64 - 1.0, height as f64 - 1.0);
    let to_edge = |[u, v]: [f64; 2]| u.min(v).min(w - u).min(h - v);
    let spacing = spacing(&lattice.points().collect::<Vec<_>>());
    let beside = lattice.points().zip(spacing).any(|(point, spacing)| to_edge(point) < BESIDE_EDGE * spacing);
    if beside {
        ChessboardError::CutOff { found, expected, columns, rows }
    } else {
        ChessboardError::Incomplete { found, expected, columns, rows }
    }
}

/// The corners that were found in a picture `scale` times smaller, placed in the picture itself.
pub(super) fn placed(grey: PlaneView<'_, u8>, corners: Vec<[f64; 2]>, scale: f64) -> Vec<[f64; 2]> {
    let corners: Vec<_> = corners.into_iter().map(|corner| corner.map(|value| scale * value)).collect();
    let spacing = spacing(&corners);
    let places = corners.iter().zip(spacing).map(|(&corner, spacing)| {
        let reach = (REACH_SHARE * spacing).clamp(REACHES_PX.0, REACHES_PX.1) as usize;
        // Beside the picture's edge fewer pixels have to do.
        (2..=reach).rev().find_map(|reach| refined(grey, corner, reach)).unwrap_or(corner)
    });
    places.collect()
}

/// Distance of each point to the nearest other one, pixels.
fn spacing(points: &[[f64; 2]]) -> Vec<f64> {
    let distance = |a: &[f64; 2], b: &[f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]);
    let nearest = |i: usize| {
        let others = points.iter().enumerate().filter(move |&(j, _)| j != i);
        others.map(|(_, other)| distance(&points[i], other)).fold(f64::INFINITY, f64::min)
    };
    (0..points.len()).map(nearest).collect()
}
