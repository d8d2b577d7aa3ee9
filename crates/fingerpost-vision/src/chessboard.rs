//! The inner corners of a chessboard in a picture, at fractions of a pixel.
//!
//! Saddles of brightness are found by the response of S. Bennett and J. Lasenby, "ChESS - quick and robust detection of
//! chess-board features", 2014 (`saddles.rs`). Where exactly two lines cross in one (`crossing.rs`), it is linked with the
//! nearest such saddles along those lines, light and dark exchanged and one edge all the way between them (`links.rs`); no
//! link is longer than a square, so that a bent board or a distorting lens does no harm. Links make lattices, whose gaps are
//! looked into (`lattice.rs`), and the lattice that holds the board's rows and columns is the board (`board.rs`). Its corners
//! are then placed as W. Förstner and E. Gülch do, "A fast operator for detection and precise location of distinct points,
//! corners and centres of circular features", 1987 (`subpixel.rs`).
//!
//! Limits: squares of about 10 pixels and more; all inner corners must be in the picture.

mod board;
mod crossing;
mod lattice;
mod links;
mod saddles;
mod subpixel;

use crate::error::PictureError;
use crate::picture::{Plane, PlaneView};
use crate::pyramid::reduce;
use crate::smoothing::{GaussianBlur, SmoothingError};

use self::lattice::Lattice;

/// Columns and rows of a chessboard's inner corners: one less than its squares either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardSize {
    columns: usize,
    rows: usize,
}

/// Fewest and most inner corners along a side.
const SIDES: std::ops::RangeInclusive<usize> = 3..=64;
/// Halvings of the picture that are tried: the edges of a large, soft picture are sharp in a smaller one.
const HALVINGS: usize = 2;
/// Side below which a picture is not made smaller, pixels.
const SMALLEST_SIDE_PX: usize = 120;
/// Window and standard deviation of the smoothing before saddles are looked for: against noise, far below a square.
const SMOOTHING_PX: (usize, f64) = (5, 1.0);

/// A board that is not in a picture, or not the one that was expected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChessboardError {
    /// There cannot be such a board.
    #[error("a board of {columns} x {rows} inner corners does not work; give 3 to 64 along either side")]
    Size {
        /// Corners along a row.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// Nothing hangs together as a board's corners do.
    #[error("no chessboard was found; show the whole board, flat, sharp and evenly lit")]
    NotFound,
    /// Corners are missing, and those found lie beside the picture's edge.
    #[error(
        "corners are cut off by the picture's edge: {found} of {expected} were found ({columns} x {rows}); keep the whole \
         board in the picture"
    )]
    CutOff {
        /// Corners found.
        found: usize,
        /// Corners of the whole board.
        expected: usize,
        /// Columns that the found ones span.
        columns: usize,
        /// Rows that the found ones span.
        rows: usize,
    },
    /// Corners are missing inside the picture.
    #[error(
        "{found} of {expected} corners were found ({columns} x {rows}); check the number of inner corners, and that none \
         is covered, blurred or mirrors a light"
    )]
    Incomplete {
        /// Corners found.
        found: usize,
        /// Corners of the whole board.
        expected: usize,
        /// Columns that the found ones span.
        columns: usize,
        /// Rows that the found ones span.
        rows: usize,
    },
    /// The board has more corners than expected, so that it is not known which of them are meant.
    #[error("the board has {columns} x {rows} inner corners, more than were expected; give all of them")]
    Larger {
        /// Columns found.
        columns: usize,
        /// Rows found.
        rows: usize,
    },
    /// The picture cannot be smoothed or made smaller.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The smoothing cannot be made.
    #[error(transparent)]
    Smoothing(#[from] SmoothingError),
}

impl ChessboardError {
    /// Inner corners along and across another board than the expected one that is seen as a whole; none where no such is seen.
    #[must_use]
    pub const fn other_board(&self) -> Option<(usize, usize)> {
        match *self {
            Self::CutOff { found, columns, rows, .. } | Self::Incomplete { found, columns, rows, .. }
                if found == columns * rows =>
            {
                Some((columns, rows))
            }
            Self::Larger { columns, rows } => Some((columns, rows)),
            _ => None,
        }
    }
}

impl BoardSize {
    /// A board of `columns` x `rows` inner corners.
    ///
    /// # Errors
    /// [`ChessboardError::Size`] for fewer than 3 or more than 64 along a side.
    pub fn new(columns: usize, rows: usize) -> Result<Self, ChessboardError> {
        if SIDES.contains(&columns) && SIDES.contains(&rows) {
            Ok(Self { columns, rows })
        } else {
            Err(ChessboardError::Size { columns, rows })
        }
    }

    /// Inner corners along a row.
    #[must_use]
    pub const fn columns(self) -> usize {
        self.columns
    }

    /// Rows of inner corners.
    #[must_use]
    pub const fn rows(self) -> usize {
        self.rows
    }

    /// All inner corners.
    #[must_use]
    pub const fn count(self) -> usize {
        self.columns * self.rows
    }
}

/// The board's inner corners in a grey picture, `[u, v]` in the image frame, pixels: row by row, each row to the right in
/// the picture (of a square board, as far as it can be), rows following one another clockwise from it.
///
/// # Errors
/// [`ChessboardError`] says what was found in place of the board.
///
/// ```
/// use fingerpost_vision::{chessboard::{BoardSize, find_chessboard}, picture::Plane};
/// let mut picture = Plane::new(160, 130, 230_u8);
/// for (y, x) in (15..115).flat_map(|y| (20..140).map(move |x| (y, x))) {
///     if ((x - 20) / 20 + (y - 15) / 20) % 2 == 0 {
///         picture.row_mut(y)[x] = 20;
///     }
/// }
/// let corners = find_chessboard(picture.view(), BoardSize::new(5, 4)?)?;
/// assert_eq!(corners.len(), 20);
/// // Where the squares meet lies between two pixels' centres.
/// assert!((corners[0][0] - 39.5).abs() < 0.1 && (corners[0][1] - 34.5).abs() < 0.1);
/// # Ok::<(), fingerpost_vision::chessboard::ChessboardError>(())
/// ```
pub fn find_chessboard(grey: PlaneView<'_, u8>, size: BoardSize) -> Result<Vec<[f64; 2]>, ChessboardError> {
    let mut fault = ChessboardError::NotFound;
    let mut most_found = 0;
    let mut smaller: Option<Plane<u8>> = None;
    for halvings in 0..=HALVINGS {
        let level = smaller.as_ref().map_or(grey, Plane::view);
        let lattice = largest_lattice(level)?;
        match board::corners_of(&lattice, size, level.size()) {
            Ok(corners) => {
                let scale = f64::from(1 << halvings);
                return Ok(board::placed(grey, corners, scale));
            }
            Err(cause) if lattice.len() > most_found => {
                (fault, most_found) = (cause, lattice.len());
            }
            Err(_) => {}
        }
        if level.width().min(level.height()) < 2 * SMALLEST_SIDE_PX {
            break;
        }
        let mut next = Plane::new(level.width().div_ceil(2), level.height().div_ceil(2), 0);
        reduce(level, &mut next)?;
        smaller = Some(next);
    }
    Err(fault)
}

/// The lattice of most saddles in a picture.
fn largest_lattice(grey: PlaneView<'_, u8>) -> Result<Lattice, ChessboardError> {
    let mut smooth = Plane::new(grey.width(), grey.height(), 0);
    let (window_px, sigma_px) = SMOOTHING_PX;
    GaussianBlur::new(window_px, sigma_px)?.apply(grey, &mut smooth)?;
    let smooth = smooth.view();
    let crossings: Vec<_> = saddles::saddles(smooth)
        .into_iter()
        .filter_map(|saddle| crossing::crossing_at(smooth, saddle))
        .collect();
    let links = links::links(smooth, &crossings);
    Ok(Lattice::largest(&crossings, &links).completed(smooth))
}

#[cfg(test)]
mod tests;
