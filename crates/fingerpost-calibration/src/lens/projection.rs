//! Where a lens shows a point, and how that changes with every number of lens and pose.

use fingerpost_geometry::Intrinsics;
use nalgebra::{Isometry3, Matrix2, Matrix2x3, Point2, Point3, SMatrix, SVector, Vector2};

/// Numbers of a lens: `fx fy cx cy k1 k2 p1 p2 k3`.
pub(super) const LENS: usize = 9;

/// A lens, or the standard deviations of its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lens(pub(super) SVector<f64, LENS>);

/// A pixel with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    /// The pixel, `[u, v]`.
    pub(super) pixel: Vector2<f64>,
    /// By the lens's numbers.
    pub(super) by_lens: SMatrix<f64, 2, LENS>,
    /// By a turn (radians about the camera's axes, of the board about its own origin) and a shift in the camera frame.
    pub(super) by_pose: SMatrix<f64, 2, 6>,
}

impl Lens {
    /// A lens without distortion.
    pub(super) fn pinhole(k: &Intrinsics) -> Self {
        Self(SVector::from([k.fx, k.fy, k.cx, k.cy, 0.0, 0.0, 0.0, 0.0, 0.0]))
    }

    pub(super) fn intrinsics(&self) -> Intrinsics {
        Intrinsics { fx: self.0[0], fy: self.0[1], cx: self.0[2], cy: self.0[3] }
    }

    pub(super) fn coefficients(&self) -> [f64; 5] {
        std::array::from_fn(|i| self.0[4 + i])
    }

    /// Where a point of a board appears; none behind the camera. Distortion as in [`fingerpost_geometry::Distortion`].
    pub(super) fn project(
        &self,
        camera_from_board: &Isometry3<f64>,
        p_in_board: Point2<f64>,
    ) -> Option<Projection> {
        let turned = camera_from_board.rotation * Point3::new(p_in_board.x, p_in_board.y, 0.0).coords;
        let p = turned + camera_from_board.translation.vector;
        if p.z <= 1e-6 * p.norm() {
            return None;
        }
        let (x, y) = (p.x / p.z, p.y / p.z);
        let ([fx, fy, cx, cy], [k1, k2, p1, p2, k3]) =
            ([self.0[0], self.0[1], self.0[2], self.0[3]], self.coefficients());
        let (r2, xy) = (x * x + y * y, x * y);
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let radial_by_r2 = k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3);
        let (x2, y2) = (r2 + 2.0 * x * x, r2 + 2.0 * y * y);
        let bent = Vector2::new(x * radial + 2.0 * p1 * xy + p2 * x2, y * radial + p1 * y2 + 2.0 * p2 * xy);
        let cross = 2.0 * (xy * radial_by_r2 + p1 * x + p2 * y);
        let bent_by_xy = Matrix2::new(
            radial + 2.0 * x * x * radial_by_r2 + 2.0 * p1 * y + 6.0 * p2 * x,
            cross,
            cross,
            radial + 2.0 * y * y * radial_by_r2 + 6.0 * p1 * y + 2.0 * p2 * x,
        );
        let focal = Matrix2::new(fx, 0.0, 0.0, fy);
        let xy_by_p = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / p.z;
        let by_p = focal * bent_by_xy * xy_by_p;
        // A turn by w moves a point by w x p.
        let by_turn = -by_p * turned.cross_matrix();
        let mut by_pose = SMatrix::<f64, 2, 6>::zeros();
        by_pose.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_turn);
        by_pose.fixed_view_mut::<2, 3>(0, 3).copy_from(&by_p);
        let (r4, r6) = (r2 * r2, r2 * r2 * r2);
        #[rustfmt::skip]
        let by_lens = SMatrix::<f64, 2, LENS>::from_row_slice(&[
            bent.x, 0.0, 1.0, 0.0, fx * x * r2, fx * x * r4, 2.0 * fx * xy, fx * x2, fx * x * r6,
            0.0, bent.y, 0.0, 1.0, fy * y * r2, fy * y * r4, fy * y2, 2.0 * fy * xy, fy * y * r6,
        ]);
        let pixel = Vector2::new(fx * bent.x + cx, fy * bent.y + cy);
        Some(Projection { pixel, by_lens, by_pose })
    }
}

/// A pose after a turn and a shift as in [`Projection::by_pose`].
pub(super) fn moved(pose: &Isometry3<f64>, by: &SVector<f64, 6>) -> Isometry3<f64> {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(by.fixed_rows::<3>(0).into_owned());
    let mut rotation = turn * pose.rotation;
    rotation.renormalize();
    Isometry3::from_parts((pose.translation.vector + by.fixed_rows::<3>(3)).into(), rotation)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use fingerpost_geometry::Distortion;

    const COEFFICIENTS: [f64; 5] = [-0.264, 0.075, -0.003, 0.004, -0.146];

    fn lens() -> Lens {
        let mut lens = Lens::pinhole(&Intrinsics { fx: 1157.0, fy: 1151.0, cx: 670.0, cy: 388.0 });
        lens.0.fixed_rows_mut::<5>(4).copy_from_slice(&COEFFICIENTS);
        lens
    }

    fn pose() -> Isometry3<f64> {
        Isometry3::new(Vector3::new(-0.12, 0.04, 0.6), Vector3::new(0.4, -0.3, 0.2))
    }

    #[test]
    fn a_point_appears_where_the_camera_shows_it() {
        let point = Point2::new(0.15, -0.1);
        let direction = pose() * Point3::new(point.x, point.y, 0.0);
        let distortion = Distortion::brown_conrady(&COEFFICIENTS).unwrap();
        let bent = distortion.distort(direction.coords).unwrap();
        let expected = Vector2::new(1157.0 * bent.x + 670.0, 1151.0 * bent.y + 388.0);
        let seen = lens().project(&pose(), point).unwrap();
        assert!((seen.pixel - expected).norm() < 1e-9, "{} {expected}", seen.pixel);
        let behind = Isometry3::translation(0.0, 0.0, -1.0);
        assert!(lens().project(&behind, point).is_none());
    }

    #[test]
    fn derivatives_agree_with_differences() {
        const STEP: f64 = 1e-6;
        let point = Point2::new(0.15, -0.1);
        let here = lens().project(&pose(), point).unwrap();
        let slope = |at: &dyn Fn(f64) -> Projection| (at(STEP).pixel - at(-STEP).pixel) / (2.0 * STEP);
        for i in 0..LENS {
            let numeric = slope(&|step| {
                let mut lens = lens();
                lens.0[i] += step;
                lens.project(&pose(), point).unwrap()
            });
            assert!((here.by_lens.column(i) - numeric).norm() < 1e-4, "lens {i}: {numeric}");
        }
        for i in 0..6 {
            let numeric = slope(&|step| {
                let mut by = SVector::<f64, 6>::zeros();
                by[i] = step;
                lens().project(&moved(&pose(), &by), point).unwrap()
            });
            assert!((here.by_pose.column(i) - numeric).norm() < 1e-4, "pose {i}: {numeric}");
        }
    }
}
