//! Where the road surface of a frame ends against where the simulated road does.

use fingerpost_eval::{EdgeScene, RoadEdgeScores};
use fingerpost_geometry::Camera;
use fingerpost_papers::claims::map_from_vehicle;
use fingerpost_report::Scene;
use fingerpost_sim::{SimFrame, Simulator};
use fingerpost_vision::picture::Plane;
use nalgebra::Point2;

use crate::surface_place::probability_at;

/// The truth of a frame, against which its road surface is held.
pub(super) struct TrueEdges<'a> {
    simulator: &'a Simulator,
    frame: &'a SimFrame,
    /// The camera as it is in the frame, not as the method knows it; none where the body's motion takes it out of all limits.
    camera: Option<Camera>,
}

impl<'a> TrueEdges<'a> {
    /// Of the frame of that number.
    pub(super) fn new(simulator: &'a Simulator, index: usize, frame: &'a SimFrame) -> Self {
        Self { simulator, frame, camera: simulator.camera_at(index).ok() }
    }

    /// Adds what the method makes of the frame. Both are laid on the plane on which the vehicle stands.
    pub(super) fn measure(&self, scene: &Scene<'_>, scores: &mut RoadEdgeScores) {
        let Some(camera) = &self.camera else { return };
        let map_from_vehicle = map_from_vehicle(&self.frame.truth);
        let (probability, validity) = (&scene.evidence.surface.probability, scene.evidence.validity);
        scores.add(&EdgeScene {
            is_road: |[x, y]: [f64; 2]| self.simulator.is_on_road(map_from_vehicle * Point2::new(x, y)),
            is_shown: |[x, y]: [f64; 2]| shows_road(camera, &self.frame.road, Point2::new(x, y)),
            probability: |place| probability_at(&scene.setting.grid, probability, validity, place),
        });
    }
}

/// Whether the picture's mask of the road has a place of the vehicle frame, metres.
fn shows_road(camera: &Camera, road: &Plane<u8>, p_in_vehicle: Point2<f64>) -> bool {
    let pixel = camera.pixel_of_ground(p_in_vehicle).filter(|&pixel| camera.contains(pixel));
    let seen = pixel.and_then(|pixel| road.get(pixel.u.round() as usize, pixel.v.round() as usize));
    seen.is_some_and(|road| road != 0)
}
