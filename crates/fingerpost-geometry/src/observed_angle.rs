//! An angle with its uncertainty.

/// An angle as it was seen in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedAngle {
    /// The angle, radians.
    pub angle_rad: f64,
    /// Its variance, square radians; never zero.
    pub variance_rad2: f64,
}

impl ObservedAngle {
    /// This observation and an independent one of the same angle as one.
    #[must_use]
    pub fn joined_with(self, other: Self) -> Self {
        let share = other.variance_rad2 / (self.variance_rad2 + other.variance_rad2);
        Self {
            angle_rad: share * self.angle_rad + (1.0 - share) * other.angle_rad,
            variance_rad2: share * self.variance_rad2,
        }
    }
}
