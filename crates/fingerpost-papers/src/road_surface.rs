//! Road as in the papers: what looks like a known surface (paper 2, 7.4), and the detector before the ground view (paper 1,
//! figure 4).

mod bank;
mod in_camera;

use fingerpost::road_surface::{
    Backprojection, RememberedMethod, RoadDetector, RoadError, RoadPicture, RoadSurfaceConfig,
};

pub use bank::Bank;
use in_camera::InCamera;

/// The detector of these settings, the papers' or the method's; it has learned nothing yet.
///
/// # Errors
/// [`RoadError`] when its settings are out of range, or it needs a network.
pub fn road_detector(config: &RoadSurfaceConfig) -> Result<Box<dyn RoadDetector>, RoadError> {
    config.detector_with(seeing(config)?)
}

/// What sees as only the papers do; none where these settings ask for nothing of theirs.
pub(crate) fn seeing(config: &RoadSurfaceConfig) -> Result<Option<Box<dyn RoadDetector>>, RoadError> {
    let by_colour: Box<dyn RoadDetector> = match (config.seen_by(), config.picture) {
        (RememberedMethod::Bank, _) => Box::new(Bank::new(&config.bank)?),
        (RememberedMethod::Backprojection, RoadPicture::Camera) => {
            Box::new(Backprojection::new(&config.backprojection)?)
        }
        _ => return Ok(None),
    };
    Ok(Some(match config.picture {
        RoadPicture::GroundView => by_colour,
        RoadPicture::Camera => Box::new(InCamera::new(by_colour, config.backprojection.bins())?),
    }))
}
