//! Structuring elements.

/// Largest width and height of an element, pixels: far beyond what closes the gaps of a lane marking, and few enough rows
/// to be held on the stack.
pub const MAX_SIZE_PX: usize = 63;

/// A shape that a picture is dilated by: symmetric about its middle pixel, and the wider the nearer to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StructuringElement {
    /// The shape as a union of rectangles about its middle, the lowest first.
    pub(super) rectangles: Vec<Rectangle>,
}

/// A rectangle about a middle pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rectangle {
    /// Pixels that it reaches to the left and to the right.
    pub(super) reach_x: usize,
    /// Pixels that it reaches up and down.
    pub(super) reach_y: usize,
}

/// An element that cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ElementError {
    /// It has no middle pixel or is too large.
    #[error(
        "a structuring element of {width_px} x {height_px} pixels does not work; give odd numbers from 1 to {MAX_SIZE_PX}"
    )]
    Size {
        /// Width asked for, pixels.
        width_px: usize,
        /// Height asked for, pixels.
        height_px: usize,
    },
}

impl StructuringElement {
    /// All pixels of a rectangle.
    ///
    /// # Errors
    /// [`ElementError::Size`] when a side is even or longer than [`MAX_SIZE_PX`].
    pub fn rectangle(width_px: usize, height_px: usize) -> Result<Self, ElementError> {
        let [reach_x, reach_y] = reaches(width_px, height_px)?;
        Ok(Self { rectangles: vec![Rectangle { reach_x, reach_y }] })
    }

    /// The middle row and the middle column of a rectangle.
    ///
    /// # Errors
    /// [`ElementError::Size`] when a side is even or longer than [`MAX_SIZE_PX`].
    pub fn cross(width_px: usize, height_px: usize) -> Result<Self, ElementError> {
        let [reach_x, reach_y] = reaches(width_px, height_px)?;
        Ok(Self { rectangles: vec![Rectangle { reach_x, reach_y: 0 }, Rectangle { reach_x: 0, reach_y }] })
    }

    /// The ellipse inside a rectangle; each row is as wide as the ellipse at the row's middle, to the nearest pixel.
    ///
    /// # Errors
    /// [`ElementError::Size`] when a side is even or longer than [`MAX_SIZE_PX`].
    pub fn ellipse(width_px: usize, height_px: usize) -> Result<Self, ElementError> {
        let [reach_x, reach_y] = reaches(width_px, height_px)?;
        let mut rectangles: Vec<Rectangle> = Vec::new();
        for row in 0..=reach_y {
            let height = row as f64 / reach_y.max(1) as f64;
            let row_reach_x = (reach_x as f64 * (1.0 - height * height).sqrt()).round_ties_even() as usize;
            match rectangles.last_mut() {
                Some(last) if last.reach_x == row_reach_x => last.reach_y = row,
                _ => rectangles.push(Rectangle { reach_x: row_reach_x, reach_y: row }),
            }
        }
        Ok(Self { rectangles })
    }

    /// Whether the element covers the pixel `dx` to the right of its middle and `dy` below it.
    #[must_use]
    pub fn covers(&self, dx: isize, dy: isize) -> bool {
        let inside = |rectangle: &Rectangle| {
            dx.unsigned_abs() <= rectangle.reach_x && dy.unsigned_abs() <= rectangle.reach_y
        };
        self.rectangles.iter().any(inside)
    }
}

fn reaches(width_px: usize, height_px: usize) -> Result<[usize; 2], ElementError> {
    let fits = |size: usize| !size.is_multiple_of(2) && size <= MAX_SIZE_PX;
    if fits(width_px) && fits(height_px) {
        Ok([width_px / 2, height_px / 2])
    } else {
        Err(ElementError::Size { width_px, height_px })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Width of each row of an element, top to bottom.
    fn row_widths(element: &StructuringElement, reach: isize) -> Vec<usize> {
        let width = |dy| (-40..=40).filter(|&dx| element.covers(dx, dy)).count();
        (-reach..=reach).map(width).collect()
    }

    #[test]
    fn elements_have_the_shapes_of_opencv() {
        let ellipse = |width, height| StructuringElement::ellipse(width, height).unwrap();
        assert_eq!(row_widths(&ellipse(5, 5), 2), [1, 5, 5, 5, 1]);
        assert_eq!(row_widths(&ellipse(7, 7), 3), [1, 5, 7, 7, 7, 5, 1]);
        assert_eq!(row_widths(&ellipse(15, 9), 4), [1, 11, 13, 15, 15, 15, 13, 11, 1]);
        assert_eq!(row_widths(&ellipse(3, 7), 3), [1, 3, 3, 3, 3, 3, 1]);
        assert_eq!(row_widths(&ellipse(1, 1), 1), [0, 1, 0]);
        assert_eq!(row_widths(&StructuringElement::cross(5, 3).unwrap(), 2), [0, 1, 5, 1, 0]);
        assert_eq!(row_widths(&StructuringElement::rectangle(3, 5).unwrap(), 3), [0, 3, 3, 3, 3, 3, 0]);
    }

    #[test]
    fn sides_that_are_even_or_too_long_are_errors() {
        for (width_px, height_px) in [(0, 3), (3, 4), (65, 3), (3, 65)] {
            let expected = ElementError::Size { width_px, height_px };
            assert_eq!(StructuringElement::rectangle(width_px, height_px).unwrap_err(), expected);
            assert_eq!(StructuringElement::cross(width_px, height_px).unwrap_err(), expected);
            assert_eq!(StructuringElement::ellipse(width_px, height_px).unwrap_err(), expected);
        }
    }
}
