//! What a picture is made of: the constant setting of a run, and one frame with all that was seen in it.

use fingerpost::feature_model::FeatureModel;
use fingerpost::matching::Match;
use fingerpost::track::Followed;
use fingerpost::{FrameEvidence, FrameOutput, Pipeline};
use fingerpost_geometry::{Camera, GroundGrid};
use fingerpost_vision::picture::RgbImage;

/// What stays the same over a run; taken from the pipeline once, because evidence borrows it frame by frame.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The camera.
    pub camera: Camera,
    /// Raster of the ground view.
    pub grid: GroundGrid,
    /// The features of the route, in its order.
    pub features: Vec<FeatureModel>,
    /// Width of the vehicle, metres.
    pub vehicle_width_m: f64,
}

impl Setting {
    /// The setting of a run of `pipeline` on pictures of `camera`.
    pub fn new(camera: &Camera, pipeline: &Pipeline) -> Self {
        let config = pipeline.config();
        Self {
            camera: camera.clone(),
            grid: *pipeline.view().grid(),
            features: pipeline.tracker().stops().iter().map(|stop| stop.model.clone()).collect(),
            vehicle_width_m: config.vehicle.width_m,
        }
    }
}

/// One frame and what the method made of it.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// What stays the same over the run.
    pub setting: &'a Setting,
    /// Index of the frame in the input, from zero.
    pub frame: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
    /// The camera's picture.
    pub picture: &'a RgbImage,
    /// What the method says.
    pub output: &'a FrameOutput,
    /// What it saw and why it decided.
    pub evidence: &'a FrameEvidence<'a>,
}

impl<'a> Scene<'a> {
    /// The match of the followed feature, or else the best one of the feature searched for.
    pub(crate) fn matched(&self) -> Option<&'a Match> {
        let followed = self.output.track.followed.as_ref().map(|followed| &followed.matched);
        followed.or(self.evidence.track.sought.as_ref().map(|sought| &sought.matched))
    }

    /// The followed feature and its model.
    pub fn followed(&self) -> Option<(&'a Followed, &'a FeatureModel)> {
        let followed = self.output.track.followed.as_ref()?;
        Some((followed, self.setting.features.get(followed.index)?))
    }
}
