//! A picture at full, half, quarter, ... size.

use super::reduce;
use crate::picture::Plane;

/// Grey pictures, each [reduced](super::reduce()) from the one before; pixel `(c, r)` of a level lies at `(2 c, 2 r)` of the one
/// before.
#[derive(Debug, Clone, Default)]
pub struct GreyPyramid {
    levels: Vec<Plane<u8>>,
}

impl GreyPyramid {
    /// Fills the pyramid: `paint` is given the largest picture, of `size` (width, height), in place of what it was, and up to
    /// `reductions` smaller ones are made from it, none with a side under `smallest` pixels. The memory is reused.
    ///
    /// # Errors
    /// What `paint` returns; the smaller pictures are then those of before.
    pub fn fill<E>(
        &mut self,
        size: (usize, usize),
        reductions: usize,
        smallest: usize,
        paint: impl FnOnce(&mut Plane<u8>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.resize(size, reductions, smallest);
        let Some((first, rest)) = self.levels.split_first_mut() else { return Ok(()) };
        paint(first)?;
        let mut larger = &*first;
        for level in rest {
            // The sizes fit: they were set from each other.
            let reduced = reduce(larger.view(), level);
            debug_assert!(reduced.is_ok());
            larger = level;
        }
        Ok(())
    }

    /// The pictures, the largest first.
    #[must_use]
    pub fn levels(&self) -> &[Plane<u8>] {
        &self.levels
    }

    fn resize(&mut self, (mut width, mut height): (usize, usize), reductions: usize, smallest: usize) {
        let mut count = 0;
        loop {
            match self.levels.get_mut(count) {
                Some(level) if level.size() == (width, height) => {}
                Some(level) => level.reset(width, height, 0),
                None => self.levels.push(Plane::new(width, height, 0)),
            }
            count += 1;
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            if count > reductions || width.min(height) < smallest.max(2) {
                break;
            }
        }
        self.levels.truncate(count);
    }
}
