//! Motion estimates: how long a frame takes, and how far they are from a simulated drive's truth.

use anyhow::{Context, Result};
use fingerpost::Config;
use fingerpost::attitude::AttitudeObservation;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::{
    DirectMotion, DirectMotionConfig, FarnebackMotionConfig, FlowModel, MotionEstimator,
};
use fingerpost_geometry::wrap_angle;
use fingerpost_papers::FarnebackMotion;
use fingerpost_sim::{SimConfig, Simulator};
use nalgebra::{Isometry2, Vector2};
use serde_json::json;

use crate::footage::{dashcam, town};
use crate::measure::{Contestant, Effort, side_by_side};
use crate::peer::{Array, OpenCv};
use crate::results::{Figure, Row, Section};

/// How many times as fast as the mean of Farneback's flow the direct estimate is promised to be.
const PROMISED: f64 = 4.0;
/// Frames of the simulated drive: along a street and round the first corner.
const FRAMES: usize = 160;
/// Size of the simulated pictures, pixels: the demo's.
const SIZE_PX: (usize, usize) = (640, 480);
/// Side of the region that OpenCV measures flow in, pixels.
const FLOW_SIDE_PX: usize = 128;

/// A simulated drive as its ground views and true steps.
struct Drive {
    view: GroundView,
    pictures: Vec<GroundPicture>,
    /// The vehicle's true pose in the frame before it, for every frame but the first.
    steps: Vec<Isometry2<f64>>,
}

/// The papers' estimator by what is taken from the flow; by no flow, the method's own.
fn estimator(flow: Option<FlowModel>) -> Result<Box<dyn MotionEstimator>> {
    Ok(match flow {
        None => Box::new(DirectMotion::new(&DirectMotionConfig::default())),
        Some(model) => {
            let config = FarnebackMotionConfig { model, ..FarnebackMotionConfig::default() };
            Box::new(FarnebackMotion::new(&config)?)
        }
    })
}

/// Times and compares the estimators.
pub fn motion(opencv: &mut OpenCv, effort: Effort) -> Result<Section> {
    let drive = Drive::simulate()?;
    let estimators = [
        ("direct alignment", None),
        ("mean of Farneback's flow", Some(FlowModel::Mean)),
        ("rigid motion of Farneback's flow", Some(FlowModel::Rigid)),
    ];
    let mut section = Section::new(
        "Motion",
        "one thread; a frame of a simulated drive; OpenCV: its flow alone on 128 x 128; errors are root mean squares a frame",
    );
    for (name, flow) in estimators {
        section.figures.extend(drive.errors(name, estimator(flow)?)?);
    }
    let patch = |picture: &GroundPicture| -> Result<Array> {
        let (width, height) = picture.grey.size();
        let (left, top) = ((width - FLOW_SIDE_PX) / 2, height - FLOW_SIDE_PX);
        let rows = (top..height).flat_map(|y| &picture.grey.row(y)[left..left + FLOW_SIDE_PX]);
        let bytes: Vec<u8> = rows.copied().collect();
        Ok(Array::of_u8(&[FLOW_SIDE_PX, FLOW_SIDE_PX], &bytes))
    };
    opencv.prepare("farneback", &json!({}), &[patch(&drive.pictures[0])?, patch(&drive.pictures[1])?])?;
    let mut contestants = Vec::new();
    for (name, flow) in estimators {
        contestants.push(drive.contestant(name, estimator(flow)?));
    }
    contestants.push(opencv.contestant());
    let measured = side_by_side(effort, &mut contestants)?;
    section.rows.push(Row::new("direct, against the mean of the flow", "a frame", measured, Some(PROMISED)));
    Ok(section)
}

impl Drive {
    fn simulate() -> Result<Self> {
        let (graph, route) = town()?;
        let camera = dashcam(SIZE_PX.0, SIZE_PX.1)?;
        let simulator = Simulator::new(&graph, &route, &camera, &SimConfig::default())?;
        let config = Config::default();
        let view = GroundView::new(&config.ground_view, config.road_surface.backprojection.bins(), &camera)?;
        let mut pictures = Vec::new();
        let mut poses: Vec<Isometry2<f64>> = Vec::new();
        for index in 0..FRAMES.min(simulator.frames()) {
            let frame = simulator.frame(index);
            let mut picture = view.black_picture();
            view.render(&frame.picture, &mut picture)?;
            pictures.push(picture);
            poses.push(Isometry2::new(
                Vector2::new(frame.truth.x_m, frame.truth.y_m),
                frame.truth.heading_rad,
            ));
        }
        let steps = poses.windows(2).map(|pair| pair[0].inverse() * pair[1]).collect();
        Ok(Self { view, pictures, steps })
    }

    /// The estimator on frame after frame; at the drive's end it begins anew.
    fn contestant<'a>(&'a self, name: &str, mut estimator: Box<dyn MotionEstimator>) -> Contestant<'a> {
        let mut next = 0;
        Contestant::here(name, move || {
            if next == self.pictures.len() {
                estimator.reset();
                next = 0;
            }
            // The pictures all fit the view.
            let _ = estimator.estimate(&self.view, &self.pictures[next], &AttitudeObservation::default());
            next += 1;
        })
    }

    fn errors(&self, name: &str, mut estimator: Box<dyn MotionEstimator>) -> Result<Vec<Figure>> {
        let mut squares = [0.0; 3];
        let mut driven = [0.0; 2];
        estimator.estimate(&self.view, &self.pictures[0], &AttitudeObservation::default())?;
        for (picture, step) in self.pictures[1..].iter().zip(&self.steps) {
            let (output, _) = estimator
                .estimate(&self.view, picture, &AttitudeObservation::default())?
                .context("a motion of every frame")?;
            let found = output.motion.previous_from_current;
            let apart = found.translation.vector - step.translation.vector;
            let yaw = wrap_angle(found.rotation.angle() - step.rotation.angle());
            squares.iter_mut().zip([apart.x, apart.y, yaw]).for_each(|(sum, error)| *sum += error * error);
            driven[0] += found.translation.vector.norm();
            driven[1] += step.translation.vector.norm();
        }
        let root = |sum: f64| (sum / self.steps.len() as f64).sqrt();
        let figure = |what: &str, value, unit| Figure {
            what: format!("{name}: {what}"),
            value,
            unit,
            promised_most: None,
        };
        Ok(vec![
            figure("error forward", 100.0 * root(squares[0]), "cm"),
            figure("error to the left", 100.0 * root(squares[1]), "cm"),
            figure("error of the turn", root(squares[2]).to_degrees(), "degrees"),
            figure("length of the drive off by", 100.0 * (driven[0] / driven[1] - 1.0), "%"),
        ])
    }
}
