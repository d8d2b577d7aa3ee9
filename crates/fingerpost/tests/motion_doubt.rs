//! A motion that cannot be true by what else the picture shows is named, and nothing is advised by it; a clean drive has none.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod simulated;

use std::ops::Range;

use fingerpost::advice::Stop;
use fingerpost::attitude::AttitudeObservation;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::{
    DirectMotion, DirectMotionConfig, MotionDoubt, MotionError, MotionEstimator, MotionEvidence, MotionOutput,
};
use fingerpost::pipeline::Parts;
use fingerpost::vehicle_signals::VehicleSamples;
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_sim::SimConfig;
use simulated::{camera, simulator};

const FRAMES: usize = 24;
const DOUBTED: Range<usize> = 10..16;
const FPS: f64 = 10.0;
const SPEED_MPS: f64 = 8.0;

/// The motion as it is, in which some frames are doubted.
struct Doubted {
    direct: DirectMotion,
    doubt: Option<MotionDoubt>,
    frames: usize,
}

impl MotionEstimator for Doubted {
    fn estimate(
        &mut self,
        view: &GroundView,
        picture: &GroundPicture,
        attitude: &AttitudeObservation,
    ) -> Result<Option<(MotionOutput, &MotionEvidence)>, MotionError> {
        let doubt = self.doubt.filter(|_| DOUBTED.contains(&self.frames));
        self.frames += 1;
        let found = self.direct.estimate(view, picture, attitude)?;
        // What the estimator doubts itself stays doubted.
        Ok(found
            .map(|(output, evidence)| (MotionOutput { doubt: output.doubt.or(doubt), ..output }, evidence)))
    }

    fn reset(&mut self) {
        self.direct.reset();
    }
}

/// The outputs of a drive some frames of which are doubted, with the bus's speed or without.
fn drive(doubt: Option<MotionDoubt>, bus_mps: Option<f64>) -> Vec<FrameOutput> {
    let config = SimConfig { start_m: 30.0, fps: FPS, cruise_speed_mps: SPEED_MPS, ..SimConfig::default() };
    let simulator = simulator(&config);
    let motion = Doubted { direct: DirectMotion::new(&DirectMotionConfig::default()), doubt, frames: 0 };
    let parts = Parts { motion_estimator: Some(Box::new(motion)), ..Parts::default() };
    let mut pipeline = Pipeline::with_parts(&Config::default(), &camera(), None, None, parts).unwrap();
    let mut outputs = Vec::new();
    for frame in 0..FRAMES {
        let signals = VehicleSamples::of_now(bus_mps, None);
        let sensors = Sensors { signals, dt_s: (frame > 0).then_some(1.0 / FPS), ..Sensors::default() };
        let picture = simulator.frame(frame).picture;
        outputs.push(pipeline.step(&picture, sensors, &mut |_| {}).unwrap().0.clone());
    }
    outputs
}

#[test]
fn a_doubted_motion_is_named_and_nothing_is_advised_by_it() {
    for doubt in [MotionDoubt::ViewStandsStill, MotionDoubt::NothingToGoBy] {
        for bus_mps in [None, Some(SPEED_MPS)] {
            for (frame, output) in drive(Some(doubt), bus_mps).iter().enumerate() {
                let (advice, is_doubted) = (&output.advice, DOUBTED.contains(&frame));
                assert_eq!(output.motion_doubt.is_some(), is_doubted, "frame {frame}");
                assert_eq!(output.why.contains("the motion is not believed"), is_doubted, "{}", output.why);
                // Where the bus says how fast the vehicle drives, that is enough.
                let is_lost = is_doubted && bus_mps.is_none();
                assert_eq!(
                    advice.stop == Some(Stop::MotionNotBelieved),
                    is_lost,
                    "frame {frame}: {advice:?}"
                );
                assert!(!is_lost || (advice.line.is_none() && advice.speed_mps == 0.0), "{advice:?}");
                assert!(!is_lost || output.vehicle.speed_mps.is_none(), "no speed comes of it");
            }
        }
    }
}

#[test]
fn a_clean_drive_has_no_doubt() {
    let outputs = drive(None, None);
    assert!(outputs.iter().all(|output| output.motion_doubt.is_none() && !output.why.contains("believed")));
    assert!(outputs[2..].iter().all(|output| output.advice.stop.is_none()));
}
