//! How far a number belongs to a term.

/// A membership function: it rises from the first corner to the second, is one up to the third and falls to the fourth. With the
/// second and third on the same place it is a triangle; a side that rises at once is a shoulder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Membership {
    corners: [f64; 4],
}

impl Membership {
    /// A trapezoid with these corners; none where they are not finite and in order.
    pub fn trapezoid(corners: [f64; 4]) -> Option<Self> {
        let in_order = corners.windows(2).all(|pair| pair[0] <= pair[1]);
        (in_order && corners.iter().all(|corner| corner.is_finite())).then_some(Self { corners })
    }

    /// A triangle with these corners; none where they are not finite and in order.
    pub fn triangle([left, top, right]: [f64; 3]) -> Option<Self> {
        Self::trapezoid([left, top, top, right])
    }

    /// The corners, from left to right.
    pub const fn corners(&self) -> [f64; 4] {
        self.corners
    }

    /// How far a number belongs to it, 0 to 1.
    pub fn of(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.corners;
        if x < b {
            if x <= a { 0.0 } else { (x - a) / (b - a) }
        } else if x <= c {
            1.0
        } else if x >= d {
            0.0
        } else {
            (d - x) / (d - c)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_where_they_are_said_to_be() {
        let trapezoid = Membership::trapezoid([0.0, 1.0, 3.0, 5.0]).unwrap();
        for (x, share) in [(-1.0, 0.0), (0.25, 0.25), (1.0, 1.0), (3.0, 1.0), (4.5, 0.25), (9.0, 0.0)] {
            assert!((trapezoid.of(x) - share).abs() < 1e-12, "{x}");
        }
        let shoulder = Membership::trapezoid([0.0, 0.0, 1.0, 2.0]).unwrap();
        assert!((shoulder.of(0.0) - 1.0).abs() < 1e-12 && shoulder.of(-1e-9) < 1e-12);
        let peak = Membership::triangle([1.0, 1.0, 1.0]).unwrap();
        assert!((peak.of(1.0) - 1.0).abs() < 1e-12 && peak.of(1.1) < 1e-12);
    }

    #[test]
    fn corners_out_of_order_make_none() {
        assert_eq!(Membership::triangle([0.0, 2.0, 1.0]), None);
        assert_eq!(Membership::trapezoid([0.0, f64::NAN, 1.0, 2.0]), None);
    }
}
