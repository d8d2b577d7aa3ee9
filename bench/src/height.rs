//! The ground's height: how long a frame of a street with kerbs takes.

use std::time::Instant;

use anyhow::Result;
use fingerpost::Config;
use fingerpost::ground_view::{CameraTurn, GroundPicture, GroundView};
use fingerpost::height::{HeightConfig, HeightStage, HeightUse};
use fingerpost::motion::Motion;
use fingerpost_sim::{Conditions, CornerStyle, SimConfig, Simulator};
use nalgebra::{Isometry2, Matrix3, Vector2};

use crate::footage::{dashcam, town};
use crate::measure::{Effort, median};
use crate::results::{Bound, Figure, Section};

/// Frames of the simulated drive; the first ones have no travel to compare views over.
const FRAMES: usize = 80;
const SETTLING_FRAMES: usize = 20;
/// Size of the simulated pictures, pixels: the demo's.
const SIZE_PX: (usize, usize) = (640, 480);
/// Frames a second that are promised: 1.5 ms a frame.
const PROMISED: f64 = 1000.0 / 1.5;

/// Times the stage on the ground views of a drive, with its true motion.
pub fn height(effort: Effort) -> Result<Section> {
    let (graph, route) = town()?;
    let camera = dashcam(SIZE_PX.0, SIZE_PX.1)?;
    let conditions = Conditions::named("street")?;
    let sim = SimConfig { conditions, corners: CornerStyle::Drawn, ..SimConfig::default() };
    let simulator = Simulator::new(&graph, &route, &camera, &sim)?;
    let config = Config::default();
    let view = GroundView::new(&config.ground_view, config.road_surface.backprojection.bins(), &camera)?;
    let mut frames: Vec<(GroundPicture, Isometry2<f64>)> = Vec::new();
    for index in 0..FRAMES.min(simulator.frames()) {
        let frame = simulator.frame(index);
        let mut picture = view.black_picture();
        view.render(&frame.picture, &mut picture)?;
        let place = Vector2::new(frame.truth.x_m, frame.truth.y_m);
        frames.push((picture, Isometry2::new(place, frame.truth.heading_rad)));
    }
    let mut times_ms = Vec::new();
    for _ in 0..effort.rounds {
        let mut stage = HeightStage::new(&HeightConfig { used: HeightUse::Shown, ..HeightConfig::default() });
        let mut before: Option<Isometry2<f64>> = None;
        for (index, (picture, place)) in frames.iter().enumerate() {
            let motion = before.map(|before| Motion {
                previous_from_current: before.inv_mul(place),
                covariance: Matrix3::identity() * 1e-6,
                quality: 1.0,
            });
            let start = Instant::now();
            stage.step(&view, &picture.grey, motion.as_ref(), CameraTurn::default());
            if index >= SETTLING_FRAMES {
                times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            }
            before = Some(*place);
        }
    }
    let mut section = Section::new(
        "Height",
        "one thread; a frame of a simulated street with kerbs at the default ground view, views compared every 0.4 m",
    );
    section.figures.push(Figure {
        what: "ground's height".to_owned(),
        value: 1e3 / median(&mut times_ms),
        unit: "frames/s",
        promised: Some(Bound::AtLeast(PROMISED)),
    });
    Ok(section)
}
