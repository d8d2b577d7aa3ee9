//! The papers' sparse alternative to dense flow: Lucas and Kanade's tracking of corners, and the mean of how they moved.
//!
//! Paper 1, VI: "The Lucas Kanade approach was considered initially as a sparse option due to efficiency". Everything but the
//! flow is as in the dense one: the grey ground view, the region in front of the vehicle, the mean, and a start from the
//! motion of the frame before.

use fingerpost::attitude::AttitudeObservation;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::{Motion, MotionError, MotionEstimator, MotionEvidence, MotionOutput};
use fingerpost::road_surface::RoadSurfaceConfig;
use fingerpost_vision::corners::{Corner, CornerFinder};
use fingerpost_vision::lucas_kanade::LucasKanade;
use fingerpost_vision::picture::Rect;
use fingerpost_vision::pyramid::GreyPyramid;
use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};

/// Reductions of the ground view: with Bouguet's three a window follows a hundred pixels, 5 m a frame.
const REDUCTIONS: usize = 3;
/// Least side of a level, pixels: two windows.
const SMALLEST_PX: usize = 26;
/// Side of the cells that give a corner each, pixels: some forty of them in the region.
const CELL_PX: usize = 8;
/// Least texture of a corner, square grey levels a square pixel: above the noise of a camera by day.
const LEAST_STRENGTH: f32 = 2.0;
/// What a frame's motion is off by beside the scatter of the corners, metres and radians, as of the dense flow.
const FLOOR_M: f64 = 0.01;
const FLOOR_RAD: f64 = 0.02;

/// The estimator with what it keeps of the frame before.
pub struct SparseFlow {
    region: RoadSurfaceConfig,
    tracker: LucasKanade,
    previous: GreyPyramid,
    current: GreyPyramid,
    finder: CornerFinder,
    corners: Vec<Corner>,
    /// Mean displacement of the frame before, pixels right and down.
    last_px: [f32; 2],
    seen: bool,
    evidence: MotionEvidence,
}

impl SparseFlow {
    /// An estimator that has seen no frame; the region is that of the histogram's sample (paper 1, VI).
    pub fn new(region: &RoadSurfaceConfig) -> Self {
        Self {
            region: region.clone(),
            tracker: LucasKanade { least_strength: LEAST_STRENGTH, ..LucasKanade::default() },
            previous: GreyPyramid::default(),
            current: GreyPyramid::default(),
            finder: CornerFinder::default(),
            corners: Vec::new(),
            last_px: [0.0; 2],
            seen: false,
            evidence: MotionEvidence::default(),
        }
    }

    /// How the corners of the region moved, pixels right and down, each.
    fn displacements(&self, Rect { x, y, width, height }: Rect) -> Vec<Vector2<f64>> {
        let inside =
            |corner: &&Corner| (x..x + width).contains(&corner.x) && (y..y + height).contains(&corner.y);
        let tracked = self.corners.iter().filter(inside).filter_map(|corner| {
            let from = [corner.x as f32, corner.y as f32];
            let to = self.tracker.track(&self.previous, &self.current, 0, from, self.last_px)?.to;
            Some(Vector2::new(f64::from(to[0] - from[0]), f64::from(to[1] - from[1])))
        });
        tracked.collect()
    }
}

impl MotionEstimator for SparseFlow {
    fn estimate(
        &mut self,
        view: &GroundView,
        picture: &GroundPicture,
        _attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        std::mem::swap(&mut self.previous, &mut self.current);
        let size = picture.grey.size();
        self.current.fill(size, REDUCTIONS, SMALLEST_PX, |base| {
            base.as_mut_slice().copy_from_slice(picture.grey.as_slice());
            Ok::<(), MotionError>(())
        })?;
        let region = self.region.sample_region(view);
        let moved =
            if std::mem::replace(&mut self.seen, true) { self.displacements(region) } else { Vec::new() };
        self.corners.clear();
        self.finder.find(picture.grey.view(), CELL_PX, LEAST_STRENGTH, &mut self.corners);
        if moved.is_empty() {
            return Ok(None);
        }
        let count = moved.len() as f64;
        let mean = moved.iter().sum::<Vector2<f64>>() / count;
        let scatter = moved.iter().map(|one| (one - mean).norm_squared()).sum::<f64>() / count;
        self.last_px = [mean.x as f32, mean.y as f32];
        self.evidence.mean_flow_px = [mean.x, mean.y];
        self.evidence.region = region;
        // What is ahead comes nearer by as much as the vehicle goes on: down is forward, right is left.
        let scale = view.grid().metres_per_pixel();
        let previous_from_current = Isometry2::new(Vector2::new(mean.y, mean.x) * scale, 0.0);
        let variance = (scatter * scale * scale / count).max(FLOOR_M * FLOOR_M);
        let covariance = Matrix3::from_diagonal(&Vector3::new(variance, variance, FLOOR_RAD * FLOOR_RAD));
        let motion = Motion { previous_from_current, covariance, quality: 1.0 };
        Ok(Some((motion.into(), &self.evidence)))
    }

    fn reset(&mut self) {
        self.seen = false;
        self.last_px = [0.0; 2];
    }
}
