//! Which parts of a picture show nothing of the scene.

/// Squares of a picture that show what is fixed to the camera in place of the scene: dirt on the lens, a bonnet.
///
/// The squares lie side by side from the top left corner on. The last of a row or column reaches to the picture's edge: what
/// is left over of a picture whose size is no multiple of theirs belongs to it.
///
/// ```
/// use fingerpost_vision::picture::HiddenParts;
/// let mut hidden = HiddenParts::new(4, 3, 16);
/// hidden.set(1, 0, true);
/// assert!(hidden.hides(16, 15) && !hidden.hides(15, 15) && !hidden.hides(16, 16) && !hidden.hides(64, 0));
/// assert_eq!(hidden.share(), 1.0 / 12.0);
/// hidden.set(3, 2, true);
/// assert!(hidden.hides(69, 55) && hidden.hides(48, 55) && !hidden.hides(47, 55) && !hidden.hides(69, 31));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct HiddenParts {
    across: usize,
    down: usize,
    side_px: usize,
    squares: Vec<bool>,
    count: usize,
}

impl HiddenParts {
    /// Of `across` x `down` squares with sides of `side_px` pixels none is hidden.
    #[must_use]
    pub fn new(across: usize, down: usize, side_px: usize) -> Self {
        Self { across, down, side_px, squares: vec![false; across * down], count: 0 }
    }

    /// Squares in a row, and rows.
    #[must_use]
    pub const fn size(&self) -> (usize, usize) {
        (self.across, self.down)
    }

    /// Hides the square in a column and row of squares, or shows it; outside there is none.
    pub fn set(&mut self, column: usize, row: usize, is_hidden: bool) {
        if column >= self.across {
            return;
        }
        if let Some(square) = self.squares.get_mut(row * self.across + column) {
            self.count += usize::from(is_hidden);
            self.count -= usize::from(*square);
            *square = is_hidden;
        }
    }

    /// Whether the square in a column and row of squares is hidden.
    #[must_use]
    pub fn is_hidden(&self, column: usize, row: usize) -> bool {
        column < self.across && self.squares.get(row * self.across + column).is_some_and(|&square| square)
    }

    /// Whether the pixel at column `u`, row `v` is hidden.
    #[must_use]
    pub fn hides(&self, u: usize, v: usize) -> bool {
        let square =
            |at_px: usize, squares: usize| (at_px / self.side_px.max(1)).min(squares.saturating_sub(1));
        self.count > 0 && self.is_hidden(square(u, self.across), square(v, self.down))
    }

    /// Whether nothing is hidden.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The hidden share of the squares, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        if self.squares.is_empty() { 0.0 } else { self.count as f64 / self.squares.len() as f64 }
    }
}
