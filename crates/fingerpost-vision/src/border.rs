//! How a picture is continued beyond its edges.

use crate::filter::mirror;

/// What stands for pixels outside the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Border {
    /// A mirror through the centre of the edge pixel (dcb|abcd), OpenCV's `BORDER_REFLECT_101`.
    Mirror,
    /// The edge pixel again (aaa|abcd), OpenCV's `BORDER_REPLICATE`.
    Replicate,
}

impl Border {
    /// The index inside `0..length` that stands for `index`; 0 where there is none.
    pub(crate) fn inside(self, index: isize, length: usize) -> usize {
        match self {
            Self::Mirror => mirror(index, length),
            Self::Replicate => index.clamp(0, (length as isize - 1).max(0)) as usize,
        }
    }

    /// Fills the first and the last `reach` values of `row` from the pixels between them, of which there is at least one.
    pub(crate) fn pad<T: Copy>(self, row: &mut [T], reach: usize) {
        let width = row.len() - 2 * reach;
        for beyond in 1..=reach {
            row[reach - beyond] = row[reach + self.inside(-(beyond as isize), width)];
            row[reach + width - 1 + beyond] = row[reach + self.inside((width - 1 + beyond) as isize, width)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_continued_by_a_mirror_or_by_their_edge_pixel() {
        let mut row = [0, 0, 0, 1, 2, 3, 0, 0, 0];
        Border::Mirror.pad(&mut row, 3);
        assert_eq!(row, [2, 3, 2, 1, 2, 3, 2, 1, 2]);
        Border::Replicate.pad(&mut row, 3);
        assert_eq!(row, [1, 1, 1, 1, 2, 3, 3, 3, 3]);
        for border in [Border::Mirror, Border::Replicate] {
            let mut single = [0, 0, 7, 0, 0];
            border.pad(&mut single, 2);
            assert_eq!(single, [7; 5]);
        }
    }
}
