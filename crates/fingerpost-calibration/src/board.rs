//! Pictures of a board as a calibration needs them: of one size, and each corner with its place on the board.

use fingerpost_geometry::Pixel;
use fingerpost_vision::chessboard::BoardSize;
use nalgebra::Point2;
use thiserror::Error;

use crate::lens::BoardPoint;

/// Most pixels by which a side may differ from that of the other pictures. Some cameras and programs save a row or column more
/// or less. Where it is cut off is not known, so such a picture's corners are all shifted by up to a pixel, which turns its
/// board's pose by as much and leaves the lens: in 2 of 17 pictures a shift of one pixel moved no number of the lens by more
/// than a hundredth of its standard deviation.
const MOST_OTHER_PX: usize = 1;

/// Pictures that are not of one camera at one setting.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SizesError {
    /// There is no picture.
    #[error("no picture can be read; give pictures of the board")]
    NoPicture,
    /// One has another size than most.
    #[error(
        "the pictures are of different sizes: {name} has {} x {} pixels, most have {} x {}; give pictures by one camera at one \
         setting, none of them cropped or made smaller",
        found.0, found.1, common.0, common.1
    )]
    Different {
        /// Its name.
        name: String,
        /// Its width and height, pixels.
        found: (usize, usize),
        /// Those of most pictures, pixels.
        common: (usize, usize),
    },
}

/// The width and height that most pictures have, pixels, of names with widths and heights, from which none may differ by
/// more than a pixel; of sizes that are as frequent the first one counts.
///
/// # Errors
/// [`SizesError`] names the first picture that is not of that size.
pub fn common_size(pictures: &[(&str, (usize, usize))]) -> Result<(usize, usize), SizesError> {
    let sizes = || pictures.iter().map(|&(_, size)| size);
    let count = |size| sizes().filter(|&other| other == size).count();
    let common = sizes().rev().max_by_key(|&size| count(size)).ok_or(SizesError::NoPicture)?;
    let is_other = |&&(_, (width, height)): &&(&str, (usize, usize))| {
        width.abs_diff(common.0) > MOST_OTHER_PX || height.abs_diff(common.1) > MOST_OTHER_PX
    };
    match pictures.iter().find(is_other) {
        None => Ok(common),
        Some(&(name, found)) => Err(SizesError::Different { name: name.to_owned(), found, common }),
    }
}

/// A board's corners as a picture shows them, row by row (`[column, row]` pixels), with their places on a board whose squares'
/// sides are `square` long, in any unit.
pub fn board_points(size: BoardSize, square: f64, corners: &[[f64; 2]]) -> Vec<BoardPoint> {
    let columns = size.columns();
    let point = |(i, &[u, v]): (usize, &[f64; 2])| BoardPoint {
        p_in_board: Point2::new((i % columns) as f64, (i / columns) as f64) * square,
        pixel: Pixel::new(u, v),
    };
    corners.iter().enumerate().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commonest_size_counts_and_a_pixel_more_or_less_does_no_harm() {
        let (whole, cut, wider) = (("whole", (640, 480)), ("cut", (640, 479)), ("wider", (641, 480)));
        assert_eq!(common_size(&[cut, whole, wider, whole]), Ok((640, 480)));
        assert_eq!(common_size(&[whole, wider]), Ok((640, 480)));
        assert_eq!(common_size(&[]), Err(SizesError::NoPicture));
        let error = common_size(&[whole, ("small", (320, 240)), whole]).unwrap_err();
        let name = "small".to_owned();
        assert_eq!(error, SizesError::Different { name, found: (320, 240), common: (640, 480) });
    }

    #[test]
    fn corners_lie_on_the_board_row_by_row() {
        let size = BoardSize::new(4, 3).unwrap();
        let corners: Vec<[f64; 2]> = (0..12).map(|i| [f64::from(i), 100.0]).collect();
        let points = board_points(size, 0.025, &corners);
        assert_eq!(points.len(), 12);
        let fifth = points[5];
        assert!((fifth.p_in_board - Point2::new(0.025, 0.025)).norm() < 1e-12, "{fifth:?}");
        assert_eq!(fifth.pixel, Pixel::new(5.0, 100.0));
    }
}
