//! Corners of the camera's picture, followed from frame to frame as pairs of rays.
//!
//! Corners are looked for anew in every frame, so that nothing needs to be kept of lost ones.

use fingerpost_geometry::{Camera, Pixel};
use fingerpost_vision::colour::grey;
use fingerpost_vision::corners::{Corner, CornerFinder};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::lucas_kanade::LucasKanade;
use fingerpost_vision::picture::RgbImage;
use fingerpost_vision::pyramid::GreyPyramid;
use nalgebra::Vector3;

/// How densely and how carefully corners are followed.
#[derive(Debug, Clone, Copy)]
pub struct SparseSetting {
    /// Level of the pyramid at which corners are looked for: 0 is the picture itself.
    pub find_level: usize,
    /// Side of the cells that hold a corner each, pixels of that level.
    pub cell_px: usize,
    /// Level down to which they are followed.
    pub follow_level: usize,
    /// Most steps of following at each level.
    pub iterations: usize,
    /// Which corners are also followed back, and dropped if they do not come back to where they began.
    pub check: BackCheck,
}

/// Whether corners are followed back as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackCheck {
    /// All of them: twice the time, hardly an outlier.
    All,
    /// None.
    Off,
}

/// The same thing seen from two frames: unit directions in the camera frame.
#[derive(Debug, Clone, Copy)]
pub struct RayPair {
    /// In the older frame.
    pub previous: Vector3<f64>,
    /// In the newer one.
    pub current: Vector3<f64>,
}

/// Most reductions of the picture, to an eighth: places may move by some 50 pixels. In smaller pictures a window holds near
/// and far things at once, and the mean of their motions leads astray.
const REDUCTIONS: usize = 3;
/// Least side of a level, pixels: a few windows.
const SMALLEST_PX: usize = 40;
/// Least texture of a corner, square grey levels a square pixel: above the noise of a camera by day.
const LEAST_STRENGTH: f32 = 2.0;
/// A window that differs by more than this is another thing, grey levels.
const MOST_RESIDUAL: f32 = 15.0;
/// How far from its beginning a corner may come back, pixels.
const MOST_RETURN_PX: f32 = 0.5;

/// Follows corners from one frame to the next.
#[derive(Debug)]
pub(super) struct SparseTracks {
    setting: SparseSetting,
    size: (usize, usize),
    previous: GreyPyramid,
    current: GreyPyramid,
    finder: CornerFinder,
    corners: Vec<Corner>,
    pairs: Vec<RayPair>,
    seen: bool,
}

impl SparseTracks {
    pub(super) fn new(setting: SparseSetting) -> Self {
        Self {
            setting,
            size: (0, 0),
            previous: GreyPyramid::default(),
            current: GreyPyramid::default(),
            finder: CornerFinder::default(),
            corners: Vec::new(),
            pairs: Vec::new(),
            seen: false,
        }
    }

    /// Takes in a frame: the rays of what was followed from the one before, none for the first.
    ///
    /// # Errors
    /// [`PictureError`] when the frame has not the camera's size.
    pub(super) fn look_at(
        &mut self,
        camera: &Camera,
        frame: &RgbImage,
    ) -> Result<Option<&[RayPair]>, PictureError> {
        std::mem::swap(&mut self.previous, &mut self.current);
        let size = (camera.width(), camera.height());
        if self.size != size {
            self.size = size;
            self.seen = false;
            let most = self.most_pairs(camera);
            self.corners.reserve(most);
            self.pairs.reserve(most);
        }
        self.current.fill(size, REDUCTIONS, SMALLEST_PX, |base| grey(frame, base))?;
        self.pairs.clear();
        let had_one = std::mem::replace(&mut self.seen, true);
        if had_one {
            self.follow(camera);
        }
        self.find_corners();
        Ok(had_one.then_some(&self.pairs))
    }

    /// Most pairs of a frame: one a cell.
    pub(super) fn most_pairs(&self, camera: &Camera) -> usize {
        let cells = |side: usize| (side >> self.setting.find_level).div_ceil(self.setting.cell_px) + 1;
        cells(camera.width()) * cells(camera.height())
    }

    fn follow(&mut self, camera: &Camera) {
        let Self { setting, previous, current, corners, pairs, .. } = self;
        let tracker = LucasKanade { iterations: setting.iterations, least_strength: LEAST_STRENGTH };
        let scale = (1_u32 << setting.find_level) as f32;
        let ray = |place: [f32; 2]| {
            camera
                .ray_in_camera(Pixel::new(f64::from(place[0]), f64::from(place[1])))
                .map(|ray| ray.into_inner())
        };
        for corner in corners.iter() {
            let from = [corner.x as f32 * scale, corner.y as f32 * scale];
            let Some(track) = tracker.track(previous, current, setting.follow_level, from, [0.0, 0.0]) else {
                continue;
            };
            if track.residual > MOST_RESIDUAL {
                continue;
            }
            if setting.check == BackCheck::All {
                let back = [from[0] - track.to[0], from[1] - track.to[1]];
                let Some(back) = tracker.track(current, previous, setting.follow_level, track.to, back)
                else {
                    continue;
                };
                if libm::hypotf(back.to[0] - from[0], back.to[1] - from[1]) > MOST_RETURN_PX {
                    continue;
                }
            }
            if let (Some(previous), Some(current)) = (ray(from), ray(track.to)) {
                pairs.push(RayPair { previous, current });
            }
        }
    }

    fn find_corners(&mut self) {
        self.corners.clear();
        if let Some(level) = self.current.levels().get(self.setting.find_level) {
            self.finder.find(level.view(), self.setting.cell_px, LEAST_STRENGTH, &mut self.corners);
        }
    }
}
