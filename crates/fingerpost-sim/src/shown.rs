//! What a pixel of a picture shows.

/// What a pixel shows, as [`SimFrame::classes`](crate::SimFrame::classes) has it.
///
/// ```
/// use fingerpost_sim::PixelClass;
/// assert_eq!(PixelClass::Sky as u8, 7);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum PixelClass {
    /// Nothing: the lens sees nothing there.
    Nothing = 0,
    /// The road, or ground beside it that is paved and as high: a parking bay.
    Road = 1,
    /// Paint on the road.
    Paint = 2,
    /// Raised ground: kerb, pavement, island.
    Raised = 3,
    /// Unmade ground beside the road.
    Verge = 4,
    /// A vehicle, a post, a rail: what stands on the ground and hides it.
    Thing = 5,
    /// A house, a wall, a hedge, a tree.
    Structure = 6,
    /// Sky.
    Sky = 7,
}

/// What a pixel shows, and whether that is the road of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shown {
    pub(crate) class: PixelClass,
    /// A parking bay is of the road's class and beside the road.
    pub(crate) is_road: bool,
}

impl Shown {
    /// What is no road.
    pub(crate) const fn beside(class: PixelClass) -> Self {
        Self { class, is_road: false }
    }

    /// The road, of whose pixel paint covers this share.
    pub(crate) fn road(paint: f32) -> Self {
        Self { class: if paint >= 0.5 { PixelClass::Paint } else { PixelClass::Road }, is_road: true }
    }

    /// The pixel in the mask of the road.
    pub(crate) const fn mask(self) -> u8 {
        if self.is_road { 255 } else { 0 }
    }
}
