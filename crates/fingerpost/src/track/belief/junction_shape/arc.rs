//! The arc that joins two edges of a road.

/// Signed distance of a place from two edges that are joined by an arc, and how it changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub(super) distance_m: f64,
    /// By how far the place lies beyond each edge.
    pub(super) by_beyond: [f64; 2],
    pub(super) by_radius: f64,
}

impl Arc {
    /// Of a place so far beyond each of two edges with this product of their normals, between which the ground is road where the place
    /// is on the road's side of either; none where it lies beside an edge and not beside the arc.
    pub(super) fn between([u_m, v_m]: [f64; 2], radius_m: f64, product: f64) -> Option<Self> {
        let (du, dv, rest) = (u_m - radius_m, v_m - radius_m, 1.0 - product * product);
        let (a, b) = ((du - product * dv) / rest, (dv - product * du) / rest);
        (a <= 0.0 && b <= 0.0).then(|| {
            let from_centre_m = (du * a + dv * b).max(1e-18).sqrt();
            Self {
                distance_m: radius_m - from_centre_m,
                by_beyond: [-a / from_centre_m, -b / from_centre_m],
                by_radius: 1.0 + (a + b) / from_centre_m,
            }
        })
    }

    /// Of a place beside the first edge, or the second.
    pub(super) const fn of_edge([u_m, v_m]: [f64; 2], is_first: bool) -> Self {
        let (distance_m, by_beyond) = if is_first { (u_m, [1.0, 0.0]) } else { (v_m, [0.0, 1.0]) };
        Self { distance_m, by_beyond, by_radius: 0.0 }
    }
}
