//! Panels: one picture a stage, and all of them composed into one.

mod camera;
mod classes;
mod compose;
mod facts;
mod flow;
mod ground_plot;
mod ground_view;
mod lane_steps;
mod masks;
mod road_surface;

use fingerpost_vision::picture::{Rect, RgbImage};
use rayon::prelude::*;

use crate::draw::Canvas;
use crate::palette;
use crate::scene::Scene;
use classes::Classes;
use ground_plot::GroundPlot;

pub use compose::{COMPOSED_HEIGHT_PX, COMPOSED_WIDTH_PX, compose};

/// Width of the ground pictures, pixels: three of them fit beside one another on a laptop's page.
const GROUND_PICTURE_WIDTH_PX: usize = 480;
/// Widest camera picture, pixels.
const MAX_CAMERA_WIDTH_PX: usize = 960;

/// The picture of one stage.
#[derive(Debug, Clone)]
pub struct StagePicture {
    /// Name of the stage.
    pub stage: &'static str,
    /// What is to be seen in it.
    pub legend: &'static str,
    /// The picture.
    pub picture: RgbImage,
}

/// The pictures of all stages of one frame.
#[derive(Debug, Clone)]
pub struct StagePictures {
    /// In the order of the data: camera, the network's classes where it is asked, lane steps where lanes are looked for, ground view, road
    /// surface, masks, flow.
    pub pictures: Vec<StagePicture>,
}

/// What draws each stage, in the order of the data; none where a frame has no such stage.
const DRAWINGS: [fn(&Scene<'_>) -> Option<StagePicture>; 7] = [
    |scene| Some(stage("camera", camera::LEGEND, camera_picture(scene))),
    |scene| Some(stage("network", classes::LEGEND, network_picture(scene)?)),
    |scene| Some(stage("lane steps", lane_steps::LEGEND, lane_steps_picture(scene)?)),
    |scene| Some(stage("ground view", ground_view::LEGEND, ground_picture(scene, ground_view::draw))),
    |scene| Some(stage("road surface", road_surface::LEGEND, ground_picture(scene, road_surface::draw))),
    |scene| Some(stage("masks", masks::LEGEND, ground_picture(scene, masks::draw))),
    |scene| Some(stage("flow", flow::LEGEND, ground_picture(scene, flow::draw))),
];

const fn stage(stage: &'static str, legend: &'static str, picture: RgbImage) -> StagePicture {
    StagePicture { stage, legend, picture }
}

impl StagePictures {
    /// Draws them.
    pub fn draw(scene: &Scene<'_>) -> Self {
        Self { pictures: DRAWINGS.iter().filter_map(|draw| draw(scene)).collect() }
    }

    /// Draws the same on all cores, where somebody waits for it.
    pub fn draw_on_all_cores(scene: &Scene<'_>) -> Self {
        Self { pictures: DRAWINGS.par_iter().filter_map(|draw| draw(scene)).collect() }
    }
}

fn lane_steps_picture(scene: &Scene<'_>) -> Option<RgbImage> {
    let evidence = lane_steps::shown(scene)?;
    let (width, height) = (MAX_CAMERA_WIDTH_PX, lane_steps::height_px(evidence, MAX_CAMERA_WIDTH_PX));
    let mut canvas = Canvas::new(width, height, palette::BACKGROUND);
    lane_steps::draw(&mut canvas, Rect { x: 0, y: 0, width, height }, evidence);
    Some(canvas.into_image())
}

/// The camera's picture with what the network sees in it, in the colours of [`NETWORK_CLASSES`](crate::NETWORK_CLASSES); none where no
/// network was asked.
pub fn network_picture(scene: &Scene<'_>) -> Option<RgbImage> {
    let classes = Classes::of(scene)?;
    let area = camera_area(scene);
    let mut canvas = Canvas::new(area.width, area.height, palette::BACKGROUND);
    classes.draw(&mut canvas, area);
    Some(canvas.into_image())
}

/// The area of a picture that shows the camera's.
fn camera_area(scene: &Scene<'_>) -> Rect {
    let (width, height) = scene.picture.size();
    fitted((width, height), Rect { x: 0, y: 0, width: width.min(MAX_CAMERA_WIDTH_PX), height })
}

fn camera_picture(scene: &Scene<'_>) -> RgbImage {
    let area = camera_area(scene);
    let mut canvas = Canvas::new(area.width, area.height, palette::BACKGROUND);
    camera::draw(&mut canvas, area, scene);
    canvas.into_image()
}

fn ground_picture(scene: &Scene<'_>, draw: fn(&mut Canvas, &GroundPlot<'_>, &Scene<'_>)) -> RgbImage {
    let grid = &scene.setting.grid;
    // Tall ground views stay within the screen's height.
    let room = Rect { x: 0, y: 0, width: GROUND_PICTURE_WIDTH_PX, height: 2 * GROUND_PICTURE_WIDTH_PX };
    let area = fitted((grid.columns(), grid.rows()), room);
    let mut canvas = Canvas::new(area.width, area.height, palette::BACKGROUND);
    draw(&mut canvas, &GroundPlot::new(grid, area), scene);
    canvas.into_image()
}

/// The largest area of a picture's proportions in the top left of `room`, of at least one pixel.
pub(crate) fn fitted((width, height): (usize, usize), room: Rect) -> Rect {
    let (width, height) = (width.max(1) as f64, height.max(1) as f64);
    let scale = (room.width as f64 / width).min(room.height as f64 / height);
    let side = |length: f64| ((length * scale).round() as usize).max(1);
    Rect { x: room.x, y: room.y, width: side(width), height: side(height) }
}
