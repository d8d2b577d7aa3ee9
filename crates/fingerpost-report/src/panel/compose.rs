//! All panels of a frame in one picture.
//!
//! Above: state, feature, frame and time. In the middle: the camera's picture with the numbers of the frame, and the
//! four ground pictures, without a route the lane's steps in place of the masks; cameras wider than two to one lie across, others at the left. Below: every sub-mask's
//! P(F_sub), and the sentence that says what was decided.

use fingerpost::matching::{Match, Participation, SubMatch};
use fingerpost_vision::picture::{Rect, RgbImage};

use super::facts::facts;
use super::ground_plot::GroundPlot;
use super::{camera, fitted, flow, ground_view, lane_steps, masks, road_surface};
use crate::draw::{Canvas, Paint, TextSize, text_width_px, wrapped};
use crate::palette;
use crate::scene::Scene;

/// Width of the composed picture, pixels.
pub const COMPOSED_WIDTH_PX: usize = 1280;
/// Height of the composed picture, pixels; even, as video encoders ask for.
pub const COMPOSED_HEIGHT_PX: usize = 720;

const GAP_PX: usize = 8;
const HEADER_PX: usize = 36;
const FOOTER_PX: usize = 102;
/// Height of a panel's title, pixels.
const PANEL_TITLE_PX: usize = 18;
/// Cameras wider than this, as a ratio, lie across the top.
const WIDE_CAMERA: f64 = 2.0;
/// Width of a wide camera's picture, pixels; the numbers stand beside it.
const WIDE_CAMERA_PX: usize = 900;
/// Sub-masks in a line of the footer.
const CHIPS_A_LINE: usize = 5;
const CHIP_LINE_PX: usize = 22;
const BAR_PX: usize = 42;

/// A drawing of one ground panel.
type GroundPanel = (&'static str, fn(&mut Canvas, &GroundPlot<'_>, &Scene<'_>));

const GROUND_PANELS: [GroundPanel; 4] = [
    ("ground view: place", ground_view::draw),
    ("road surface", road_surface::draw),
    ("masks: P(F_sub)", masks::draw),
    ("flow", flow::draw),
];

/// Index of the masks in [`GROUND_PANELS`].
const MASKS_PANEL: usize = 2;

/// The composed picture of one frame, [`COMPOSED_WIDTH_PX`] by [`COMPOSED_HEIGHT_PX`] pixels for every camera.
pub fn compose(scene: &Scene<'_>) -> RgbImage {
    let mut canvas = Canvas::new(COMPOSED_WIDTH_PX, COMPOSED_HEIGHT_PX, palette::BACKGROUND);
    header(&mut canvas, scene);
    let (width, height) = scene.picture.size();
    let middle = Rect {
        x: GAP_PX,
        y: HEADER_PX + GAP_PX,
        width: COMPOSED_WIDTH_PX - 2 * GAP_PX,
        height: COMPOSED_HEIGHT_PX - HEADER_PX - FOOTER_PX - 2 * GAP_PX,
    };
    if width as f64 > WIDE_CAMERA * height as f64 {
        across(&mut canvas, scene, middle);
    } else {
        beside(&mut canvas, scene, middle);
    }
    footer(&mut canvas, scene);
    canvas.into_image()
}

/// Camera at the left with the numbers below, ground panels two by two at the right.
fn beside(canvas: &mut Canvas, scene: &Scene<'_>, middle: Rect) {
    let half = (middle.width - GAP_PX) / 2;
    let camera = fitted(scene.picture.size(), Rect { width: half, height: middle.height, ..middle });
    camera::draw(canvas, camera, scene);
    let below = camera.height + GAP_PX;
    let numbers =
        Rect { y: middle.y + below, width: half, height: middle.height.saturating_sub(below), ..middle };
    fact_lines(canvas, scene, numbers);
    let size = ((half - GAP_PX) / 2, (middle.height - GAP_PX) / 2);
    let left = middle.x + half + GAP_PX;
    for (i, ground) in GROUND_PANELS.iter().enumerate() {
        let (x, y) = (left + (i % 2) * (size.0 + GAP_PX), middle.y + (i / 2) * (size.1 + GAP_PX));
        panel(canvas, scene, (i, ground), Rect { x, y, width: size.0, height: size.1 });
    }
}

/// Camera across the top with the numbers beside it, ground panels in a row below.
fn across(canvas: &mut Canvas, scene: &Scene<'_>, middle: Rect) {
    let room = Rect { width: WIDE_CAMERA_PX, height: middle.height / 2 + GAP_PX, ..middle };
    let camera = fitted(scene.picture.size(), room);
    camera::draw(canvas, camera, scene);
    let beside = camera.width + 2 * GAP_PX;
    let numbers = Rect {
        x: middle.x + beside,
        width: middle.width.saturating_sub(beside),
        height: camera.height,
        ..middle
    };
    fact_lines(canvas, scene, numbers);
    let y = middle.y + camera.height + GAP_PX;
    let width = (middle.width - 3 * GAP_PX) / 4;
    let height = middle.height - camera.height - GAP_PX;
    for (i, ground) in GROUND_PANELS.iter().enumerate() {
        let x = middle.x + i * (width + GAP_PX);
        panel(canvas, scene, (i, ground), Rect { x, y, width, height });
    }
}

/// Draws a ground panel by its index, or what stands in its place.
fn panel(canvas: &mut Canvas, scene: &Scene<'_>, (index, ground): (usize, &GroundPanel), area: Rect) {
    let room =
        Rect { y: area.y + PANEL_TITLE_PX, height: area.height.saturating_sub(PANEL_TITLE_PX), ..area };
    let (title, draw) = ground;
    // Without a route there are no masks.
    let steps = (index == MASKS_PANEL && scene.setting.features.is_empty()).then(|| lane_steps::shown(scene));
    let steps = steps.flatten();
    let title = if steps.is_some() { "lane steps" } else { title };
    let corner = [area.x as f64 + 2.0, area.y as f64];
    canvas.text(corner, TextSize::SmallBold, palette::TEXT_DIM, title);
    if let Some(steps) = steps {
        lane_steps::draw(canvas, room, steps);
        return;
    }
    let grid = &scene.setting.grid;
    let mut fitted = fitted((grid.columns(), grid.rows()), room);
    fitted.x += (room.width - fitted.width.min(room.width)) / 2;
    draw(canvas, &GroundPlot::new(grid, fitted), scene);
}

fn header(canvas: &mut Canvas, scene: &Scene<'_>) {
    let bar = Rect { x: 0, y: 0, width: COMPOSED_WIDTH_PX, height: HEADER_PX };
    canvas.fill(bar, Paint::solid(palette::PANEL));
    let (name, colour) = palette::state(palette::recorded(scene.output.track.state));
    let chip = Rect { width: text_width_px(TextSize::Title, name) + 24, ..bar };
    canvas.fill(chip, Paint::solid(colour));
    canvas.text([12.0, 8.0], TextSize::Title, palette::BACKGROUND, name);

    let time = format!("frame {}   {:.2} s", scene.frame, scene.t_s);
    let time_px = text_width_px(TextSize::Title, &time);
    let time_x = COMPOSED_WIDTH_PX.saturating_sub(time_px + 12);
    canvas.text([time_x as f64, 8.0], TextSize::Title, palette::TEXT, &time);

    let Some((_, model)) = scene.followed() else { return };
    let title = format!("{}  {}", palette::kind(model.kind), model.id);
    let room = Rect { x: chip.width + 16, width: time_x.saturating_sub(chip.width + 32), ..bar };
    canvas.clipped(room, |canvas| {
        canvas.text([room.x as f64, 8.0], TextSize::Title, palette::TEXT, &title);
        let name_x = room.x + text_width_px(TextSize::Title, &title) + 16;
        canvas.text([name_x as f64, 11.0], TextSize::Small, palette::TEXT_DIM, &model.name);
    });
}

fn fact_lines(canvas: &mut Canvas, scene: &Scene<'_>, area: Rect) {
    const LINE_PX: usize = 17;
    let indent = 10 * TextSize::Small.letter_px();
    let letters = area.width.saturating_sub(indent) / TextSize::Small.letter_px();
    canvas.clipped(area, |canvas| {
        let mut y = area.y;
        for (about, fact) in facts(scene) {
            let lines = wrapped(&fact, letters, 2);
            if y + lines.len() * LINE_PX > area.y + area.height {
                break;
            }
            canvas.text([area.x as f64, y as f64], TextSize::Small, palette::TEXT_DIM, about);
            for line in lines {
                canvas.text([(area.x + indent) as f64, y as f64], TextSize::Small, palette::TEXT, &line);
                y += LINE_PX;
            }
        }
    });
}

fn footer(canvas: &mut Canvas, scene: &Scene<'_>) {
    let top = COMPOSED_HEIGHT_PX - FOOTER_PX;
    let bar = Rect { x: 0, y: top, width: COMPOSED_WIDTH_PX, height: FOOTER_PX };
    canvas.fill(bar, Paint::solid(palette::PANEL));
    if let Some(matched) = scene.matched() {
        chips(canvas, matched, top + 8);
    } else {
        let text = "no feature is followed: no masks to match";
        canvas.text([12.0, (top + 8) as f64], TextSize::Small, palette::TEXT_DIM, text);
    }
    let letters = (COMPOSED_WIDTH_PX - 24) / TextSize::Title.letter_px();
    for (i, line) in wrapped(&scene.output.why, letters, 2).iter().enumerate() {
        let y = top + 54 + i * 22;
        canvas.text([12.0, y as f64], TextSize::Title, palette::TEXT, line);
    }
}

/// Every sub-mask with a bar of its P(F_sub), the bound that decided as a tick, and the weakest underlined.
fn chips(canvas: &mut Canvas, matched: &Match, top: usize) {
    let width = (COMPOSED_WIDTH_PX - 24) / CHIPS_A_LINE;
    for (i, sub) in matched.subs.iter().enumerate().take(2 * CHIPS_A_LINE) {
        let (x, y) = (12 + (i % CHIPS_A_LINE) * width, top + (i / CHIPS_A_LINE) * CHIP_LINE_PX);
        let weakest = if matched.weakest == Some(i) { TextSize::SmallBold } else { TextSize::Small };
        chip(canvas, sub, weakest, [x, y]);
    }
}

fn chip(canvas: &mut Canvas, sub: &SubMatch, size: TextSize, [x, y]: [usize; 2]) {
    let colour = palette::sub_mask(&sub.label);
    let takes_part = sub.participation == Participation::TakesPart;
    let opacity = if takes_part { 1.0 } else { 0.35 };
    canvas.fill(Rect { x, y: y + 3, width: 11, height: 11 }, Paint::glaze(colour, opacity));
    let text_colour = if takes_part { palette::TEXT } else { palette::TEXT_DIM };
    canvas.text([(x + 16) as f64, y as f64], size, text_colour, &sub.label);
    let bar_x = x + 16 + 13 * TextSize::Small.letter_px();
    let value_x = (bar_x + BAR_PX + 6) as f64;
    let reason = match sub.participation {
        Participation::TakesPart => None,
        Participation::CutByValidity => Some("outside the picture"),
        Participation::TooShort => Some("out of view"),
    };
    if let Some(reason) = reason {
        canvas.text([bar_x as f64, y as f64], TextSize::Small, palette::TEXT_DIM, reason);
        return;
    }
    let p = sub.p.unwrap_or(0.0).clamp(0.0, 1.0);
    let bar = Rect { x: bar_x, y: y + 4, width: BAR_PX, height: 9 };
    canvas.fill(bar, Paint::glaze(palette::GRID_LINE, 0.12));
    let filled = (p * BAR_PX as f64).round() as usize;
    canvas.fill(Rect { width: filled, ..bar }, Paint::solid(colour));
    canvas.text([value_x, y as f64], size, palette::TEXT, &format!("{p:.2}"));
    if size == TextSize::SmallBold {
        let text_x = value_x + 5.0 * TextSize::Small.letter_px() as f64;
        canvas.text([text_x, y as f64], TextSize::Small, palette::TEXT_DIM, "weakest");
    }
}
