//! Lens and poses refined together: Levenberg and Marquardt's method (Zhang 2000, sections 3.2 and 3.3, with five
//! coefficients of distortion in place of two).
//!
//! A board's pose is in its own points' equations alone, so poses are eliminated board by board (Schur complement; B. Triggs
//! et al., "Bundle adjustment - a modern synthesis", 2000, section 6.1), and what is left are nine equations for the lens.

use nalgebra::{Isometry3, SMatrix, SVector};

use super::closed_form::Start;
use super::projection::{LENS, Lens, moved};
use super::{BoardPoint, LEAST_NOISE_PX};

/// A lens and poses that fit best.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) lens: Lens,
    /// Standard deviations of the lens's numbers.
    pub(super) sigma: Lens,
    pub(super) camera_from_board: Vec<Isometry3<f64>>,
    /// Root mean square distance of each board's points, pixels.
    pub(super) rms_px: Vec<f64>,
    /// That of all points.
    pub(super) total_rms_px: f64,
}

type LensVector = SVector<f64, LENS>;
type LensMatrix = SMatrix<f64, LENS, LENS>;
type PoseVector = SVector<f64, 6>;
type PoseMatrix = SMatrix<f64, 6, 6>;

const ITERATIONS: usize = 200;
/// Share of the squared error by which a step must lessen it for another to be worth while.
const LEAST_GAIN: f64 = 1e-12;
/// Damping at the start, its factor after a step that failed or helped, and where no step is possible any more.
const FIRST_DAMPING: f64 = 1e-3;
const DAMPING_FACTOR: f64 = 10.0;
const MOST_DAMPING: f64 = 1e12;

/// The normal equations of one board.
struct BoardEquations {
    pose: PoseMatrix,
    coupling: SMatrix<f64, LENS, 6>,
    gradient: PoseVector,
}

/// The normal equations of all, and the squared error.
struct Equations {
    lens: LensMatrix,
    gradient: LensVector,
    boards: Vec<BoardEquations>,
    /// Sums of squared distances, one a board, square pixels.
    squares: Vec<f64>,
}

/// The lens and poses that fit best, from a start near them; none where the points do not determine them.
pub(super) fn refine(views: &[&[BoardPoint]], start: Start) -> Option<Fit> {
    let mut lens = Lens::pinhole(&start.intrinsics);
    let mut poses = start.camera_from_board;
    let mut equations = Equations::at(&lens, &poses, views)?;
    let mut damping = FIRST_DAMPING;
    for _ in 0..ITERATIONS {
        let next = equations.step(damping).and_then(|(by_lens, by_poses)| {
            let next_lens = Lens(lens.0 + by_lens);
            let next_poses: Vec<_> = poses.iter().zip(&by_poses).map(|(pose, by)| moved(pose, by)).collect();
            let next = Equations::at(&next_lens, &next_poses, views)?;
            Some((next_lens, next_poses, next))
        });
        let before = equations.error();
        match next {
            Some((next_lens, next_poses, next)) if next.error() < before => {
                let gain = (before - next.error()) / before;
                (lens, poses, equations) = (next_lens, next_poses, next);
                damping /= DAMPING_FACTOR;
                if gain < LEAST_GAIN {
                    break;
                }
            }
            _ => damping *= DAMPING_FACTOR,
        }
        if damping > MOST_DAMPING {
            break;
        }
    }
    fit(lens, poses, &equations, views)
}

fn fit(
    lens: Lens,
    poses: Vec<Isometry3<f64>>,
    equations: &Equations,
    views: &[&[BoardPoint]],
) -> Option<Fit> {
    let points: usize = views.iter().map(|view| view.len()).sum();
    let unknown = LENS + 6 * views.len();
    let free = (2 * points).checked_sub(unknown).filter(|&free| free > 0)?;
    let noise_px = (equations.error() / free as f64).sqrt().max(LEAST_NOISE_PX);
    let (reduced, _) = equations.reduced(0.0)?;
    let covariance = reduced.cholesky()?.inverse();
    let rms = |squares: f64, points: usize| (squares / points as f64).sqrt();
    Some(Fit {
        lens,
        sigma: Lens(covariance.diagonal().map(|variance| noise_px * variance.sqrt())),
        camera_from_board: poses,
        rms_px: equations
            .squares
            .iter()
            .zip(views)
            .map(|(&squares, view)| rms(squares, view.len()))
            .collect(),
        total_rms_px: rms(equations.error(), points),
    })
}

impl Equations {
    /// The equations at a lens and poses; none where a point lies behind the camera.
    fn at(lens: &Lens, poses: &[Isometry3<f64>], views: &[&[BoardPoint]]) -> Option<Self> {
        let mut all = Self {
            lens: LensMatrix::zeros(),
            gradient: LensVector::zeros(),
            boards: Vec::with_capacity(views.len()),
            squares: Vec::with_capacity(views.len()),
        };
        for (pose, view) in poses.iter().zip(views) {
            let mut board = BoardEquations {
                pose: PoseMatrix::zeros(),
                coupling: SMatrix::zeros(),
                gradient: PoseVector::zeros(),
            };
            let mut squares = 0.0;
            for point in *view {
                let seen = lens.project(pose, point.p_in_board)?;
                let error = nalgebra::Vector2::new(point.pixel.u, point.pixel.v) - seen.pixel;
                squares += error.norm_squared();
                all.lens += seen.by_lens.transpose() * seen.by_lens;
                all.gradient += seen.by_lens.transpose() * error;
                board.coupling += seen.by_lens.transpose() * seen.by_pose;
                board.pose += seen.by_pose.transpose() * seen.by_pose;
                board.gradient += seen.by_pose.transpose() * error;
            }
            all.boards.push(board);
            all.squares.push(squares);
        }
        all.error().is_finite().then_some(all)
    }

    /// Sum of squared distances, square pixels.
    fn error(&self) -> f64 {
        self.squares.iter().sum()
    }

    /// The equations of the lens alone, after the poses were eliminated.
    fn reduced(&self, damping: f64) -> Option<(LensMatrix, LensVector)> {
        let mut matrix = damped(&self.lens, damping);
        let mut gradient = self.gradient;
        for board in &self.boards {
            let pose = damped(&board.pose, damping).cholesky()?;
            matrix -= board.coupling * pose.solve(&board.coupling.transpose());
            gradient -= board.coupling * pose.solve(&board.gradient);
        }
        Some((matrix, gradient))
    }

    /// The damped step of the lens and of every pose.
    fn step(&self, damping: f64) -> Option<(LensVector, Vec<PoseVector>)> {
        let (matrix, gradient) = self.reduced(damping)?;
        let by_lens = matrix.cholesky()?.solve(&gradient);
        let by_pose = |board: &BoardEquations| {
            let rest = board.gradient - board.coupling.transpose() * by_lens;
            Some(damped(&board.pose, damping).cholesky()?.solve(&rest))
        };
        Some((by_lens, self.boards.iter().map(by_pose).collect::<Option<Vec<_>>>()?))
    }
}

/// A matrix whose diagonal is larger by a share of itself (D. Marquardt, 1963).
fn damped<const N: usize>(matrix: &SMatrix<f64, N, N>, damping: f64) -> SMatrix<f64, N, N> {
    matrix + SMatrix::from_diagonal(&(matrix.diagonal() * damping))
}
