//! Where the refinement starts: intrinsics and poses in closed form, without distortion.
//!
//! Zhang 2000, section 3.1. The columns of a board's map `H = K [r1 r2 t]` are images of orthogonal axes of one length, which
//! is two linear equations (8) in the entries of `B = K^-T K^-1` (the image of the absolute conic); all boards' equations
//! together give it, and it gives `K` (appendix B of the paper's long form, MSR-TR-98-71). Pixels are not skewed, so that
//! `B12` is zero.

use fingerpost_geometry::Intrinsics;
use nalgebra::{
    DMatrix, Isometry3, Matrix3, Point2, Rotation3, SVector, Translation3, UnitQuaternion, Vector3,
};

use super::plane_map::plane_map;
use super::{BoardPoint, LensCalibrationError};

/// A lens without distortion and the boards' poses.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub(super) intrinsics: Intrinsics,
    pub(super) camera_from_board: Vec<Isometry3<f64>>,
}

/// Focal lengths that a camera may have, as shares of the picture's width.
const FOCAL_LENGTHS: std::ops::RangeInclusive<f64> = 0.1..=50.0;

/// Entries of `B` that are looked for.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    /// With the principal point: `B11 B22 B33 B13 B23`.
    All,
    /// With the principal point in the picture's middle: `B11 B22 B33`. What is left where noise and distortion make nonsense
    /// of the other.
    FocalLengths,
}

/// Intrinsics and poses from the boards' maps.
pub(super) fn start(
    views: &[&[BoardPoint]],
    width: usize,
    height: usize,
) -> Result<Start, LensCalibrationError> {
    // Pixels from the picture's middle in widths keep the equations' numbers alike.
    let (w, h) = (width as f64, height as f64);
    let middle = Point2::new(0.5 * (w - 1.0), 0.5 * (h - 1.0));
    let mut maps = Vec::with_capacity(views.len());
    for (board, view) in views.iter().enumerate() {
        let pairs: Vec<_> = view
            .iter()
            .map(|point| {
                let pixel = Point2::new(point.pixel.u, point.pixel.v);
                [point.p_in_board, Point2::from((pixel - middle) / w)]
            })
            .collect();
        maps.push(plane_map(&pairs).ok_or(LensCalibrationError::NoPlane { board })?);
    }
    let normal = intrinsics(&maps, Unknown::All)
        .filter(|k| k.cx.abs() < 0.5 && k.cy.abs() < 0.5 * h / w)
        .or_else(|| intrinsics(&maps, Unknown::FocalLengths))
        .ok_or(LensCalibrationError::Undetermined)?;
    let camera_from_board = maps.iter().map(|map| pose(&normal, map)).collect::<Option<Vec<_>>>();
    Ok(Start {
        intrinsics: Intrinsics {
            fx: normal.fx * w,
            fy: normal.fy * w,
            cx: normal.cx * w + middle.x,
            cy: normal.cy * w + middle.y,
        },
        camera_from_board: camera_from_board.ok_or(LensCalibrationError::Undetermined)?,
    })
}

/// The intrinsics, in widths of the picture from its middle; none where no camera explains the maps.
fn intrinsics(maps: &[Matrix3<f64>], unknown: Unknown) -> Option<Intrinsics> {
    let count = match unknown {
        Unknown::All => 5,
        Unknown::FocalLengths => 3,
    };
    let mut information = DMatrix::<f64>::zeros(count, count);
    for map in maps {
        // A map has any scale; each is to count alike, whatever the unit and the place of its board, which the third column has.
        let map = map / map.fixed_columns::<2>(0).norm();
        for equation in [constraint(&map, 0, 1), constraint(&map, 0, 0) - constraint(&map, 1, 1)] {
            let row = equation.rows(0, count);
            information += row * row.transpose();
        }
    }
    let parts = information.symmetric_eigen();
    let b = parts.eigenvectors.column(parts.eigenvalues.imin());
    let (b11, b22, b33) = (b[0], b[1], b[2]);
    let (b13, b23) = match unknown {
        Unknown::All => (b[3], b[4]),
        Unknown::FocalLengths => (0.0, 0.0),
    };
    // MSR-TR-98-71, appendix B, with B12 = 0.
    let scale = b33 - b13 * b13 / b11 - b23 * b23 / b22;
    let (fx, fy) = ((scale / b11).sqrt(), (scale / b22).sqrt());
    let is_camera = FOCAL_LENGTHS.contains(&fx) && FOCAL_LENGTHS.contains(&fy);
    is_camera.then(|| Intrinsics { fx, fy, cx: -b13 / b11, cy: -b23 / b22 })
}

/// Coefficients of `B11 B22 B33 B13 B23` in `h_i^T B h_j` (Zhang 2000, equation 7).
fn constraint(map: &Matrix3<f64>, i: usize, j: usize) -> SVector<f64, 5> {
    let (a, b) = (map.column(i), map.column(j));
    SVector::from([
        a[0] * b[0],
        a[1] * b[1],
        a[2] * b[2],
        a[2] * b[0] + a[0] * b[2],
        a[2] * b[1] + a[1] * b[2],
    ])
}

/// The board's pose (Zhang 2000, end of section 3.1; MSR-TR-98-71, appendix C, for the nearest rotation).
fn pose(k: &Intrinsics, map: &Matrix3<f64>) -> Option<Isometry3<f64>> {
    let rays = Matrix3::new(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0).try_inverse()? * map;
    let [right, down, place] = [0, 1, 2].map(|column| rays.column(column).into_owned());
    // The board is in front of the camera.
    let scale = 0.5 * (right.norm() + down.norm()) * if place.z < 0.0 { -1.0 } else { 1.0 };
    let (right, down, place): (Vector3<f64>, Vector3<f64>, Vector3<f64>) =
        (right / scale, down / scale, place / scale);
    let parts = Matrix3::from_columns(&[right, down, right.cross(&down)]).svd(true, true);
    let rotation = Rotation3::from_matrix_unchecked(parts.u? * parts.v_t?);
    let finite = place.iter().chain(rotation.matrix().iter()).all(|value| value.is_finite());
    finite.then(|| {
        Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_rotation_matrix(&rotation))
    })
}
