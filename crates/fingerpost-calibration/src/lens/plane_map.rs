//! The plane-to-plane map between a board and its picture.
//!
//! Direct linear transform with normalised coordinates: R. Hartley and A. Zisserman, "Multiple View Geometry", 2nd edition,
//! algorithm 4.2 (page 109).

use nalgebra::{Matrix3, Point2, SMatrix, SVector};

/// The map that takes the first of each pair of points to the second, up to its scale, as they fit best; none for fewer than
/// four pairs, points in one line and numbers that are none.
pub(super) fn plane_map(pairs: &[[Point2<f64>; 2]]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let normal_from_source = normalisation(pairs.iter().map(|pair| pair[0]))?;
    let normal_from_target = normalisation(pairs.iter().map(|pair| pair[1]))?;
    let mut information = SMatrix::<f64, 9, 9>::zeros();
    for [source, target] in pairs {
        let p = normal_from_source.transform_point(source);
        let q = normal_from_target.transform_point(target);
        let (x, y) = (p.x, p.y);
        for row in [
            SVector::<f64, 9>::from([x, y, 1.0, 0.0, 0.0, 0.0, -q.x * x, -q.x * y, -q.x]),
            SVector::<f64, 9>::from([0.0, 0.0, 0.0, x, y, 1.0, -q.y * x, -q.y * y, -q.y]),
        ] {
            information += row * row.transpose();
        }
    }
    let parts = information.symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|&a, &b| parts.eigenvalues[a].total_cmp(&parts.eigenvalues[b]));
    // A second map that fits as well means points in one line.
    if parts.eigenvalues[order[1]] < 1e-9 * parts.eigenvalues[order[8]] {
        return None;
    }
    let h = parts.eigenvectors.column(order[0]);
    let normal_map = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8]);
    let map = normal_from_target.try_inverse()? * normal_map * normal_from_source;
    (map.iter().all(|value| value.is_finite()) && map.determinant().abs() > 0.0).then_some(map)
}

/// The map that moves points to the origin and to a mean distance of the square root of two from it.
fn normalisation(points: impl Iterator<Item = Point2<f64>> + Clone) -> Option<Matrix3<f64>> {
    let count = points.clone().count() as f64;
    let middle = points.clone().fold(Point2::origin(), |sum, point| sum + point.coords) / count;
    let distance = points.map(|point| (point - middle).norm()).sum::<f64>() / count;
    let scale = std::f64::consts::SQRT_2 / distance;
    (scale.is_finite() && scale > 0.0)
        .then(|| Matrix3::new(scale, 0.0, -scale * middle.x, 0.0, scale, -scale * middle.y, 0.0, 0.0, 1.0))
}
