//! A motion that cannot be true by what else the picture shows is named, and nothing is advised by it; a clean drive has none.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use std::ops::Range;

use crate::simulated::{camera, simulator};
use fingerpost::advice::Stop;
use fingerpost::attitude::AttitudeObservation;
use fingerpost::fix::NearPlace;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::{
    DirectMotion, DirectMotionConfig, Motion, MotionDoubt, MotionError, MotionEstimator, MotionEvidence,
    MotionOutput,
};
use fingerpost::pipeline::Parts;
use fingerpost::vehicle_signals::VehicleSamples;
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_map::{LatLon, OsmData, RoadGraph, read_route};
use fingerpost_sim::SimConfig;

const FRAMES: usize = 26;
const DOUBTED: Range<usize> = 10..22;
const FPS: f64 = 10.0;
const SPEED_MPS: f64 = 8.0;
/// Between the first junction and where the second is found: one found meanwhile would tell where the vehicle is.
const START_M: f64 = 75.0;

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

/// The outputs of a drive some frames of which are doubted, with the bus's speed or without, on a route and its map.
fn drive(doubt: Option<MotionDoubt>, bus_mps: Option<f64>) -> Vec<FrameOutput> {
    let town = include_bytes!("../../../fingerpost-sim/assets/town.osm");
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(town).unwrap()).unwrap();
    let route = read_route(include_str!("../../../fingerpost-sim/assets/town_route.geojson")).unwrap();
    let config =
        SimConfig { start_m: START_M, fps: FPS, cruise_speed_mps: SPEED_MPS, ..SimConfig::default() };
    let simulator = simulator(&config);
    let motion = Doubted { direct: DirectMotion::new(&DirectMotionConfig::default()), doubt, frames: 0 };
    let parts = Parts { motion_estimator: Some(Box::new(motion)), ..Parts::default() };
    let mut pipeline =
        Pipeline::with_parts(&Config::default(), &camera(), Some(&route), Some(START_M), parts).unwrap();
    let truth = simulator.truth(0);
    let start = LatLon { lat_deg: truth.lat, lon_deg: truth.lon };
    pipeline.locate_on(&graph, Some(NearPlace { at: start, sigma_m: 1.0 }));
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
fn nothing_is_built_on_a_doubted_motion() {
    let (believed, doubted) = (drive(None, None), drive(Some(MotionDoubt::ViewStandsStill), None));
    let before = DOUBTED.start - 1;
    assert_eq!(believed[before], doubted[before]);
    // Metres that the place on the map became less sure by, and standard deviation of the way along the route since: it adds to what was
    // not known before as errors do that have nothing to do with each other.
    let less_sure_m = |outputs: &[FrameOutput]| {
        let sigmas_m =
            |output: &FrameOutput| [output.fix.unwrap().sigma_m, output.track.route_sigma_m.unwrap()];
        let (from, to) = (sigmas_m(&outputs[before]), sigmas_m(&outputs[DOUBTED.end - 1]));
        [to[0] - from[0], (to[1].powi(2) - from[1].powi(2)).max(0.0).sqrt()]
    };
    let (known_m, unknown_m) = (less_sure_m(&believed), less_sure_m(&doubted));
    // In 1.2 s a driver brakes or starts by 1.1 m, and a vehicle comes 3.8 to 12.5 m, which is 2.5 m about the mean.
    assert!(unknown_m[0] > known_m[0] + 0.1, "fix {unknown_m:?} {known_m:?}");
    assert!(unknown_m[1] > known_m[1] + 1.5, "progress {unknown_m:?} {known_m:?}");
    for frame in DOUBTED {
        let output = &doubted[frame];
        assert_eq!(output.mount, doubted[before].mount, "frame {frame}");
        assert_ne!(output.mount, believed[frame].mount, "the mount is watched where the motion is known");
        assert_eq!(output.motion, Some(Motion::unknown()), "frame {frame}");
        assert!(output.track.followed.as_ref().is_none_or(|followed| followed.covariance[(0, 0)] > 1.0));
    }
}

#[test]
fn a_clean_drive_has_no_doubt() {
    let outputs = drive(None, None);
    assert!(
        outputs.iter().all(|output| output.motion_doubt.is_none() && !output.why.contains("not believed"))
    );
    assert!(outputs[2..].iter().all(|output| output.advice.stop.is_none()));
}
