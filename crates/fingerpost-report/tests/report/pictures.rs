//! Drawings at known places: what is drawn where, which side is left, what keeps out of what.

use crate::painted_run::{camera, painted_run};
use fingerpost::ground_view::GroundPicture;
use fingerpost::lanes::{EdgeSteps, LaneEvidence};
use fingerpost::road_surface::{RoadEvidence, RoadSurface, SampleUse};
use fingerpost::track::{TrackEvidence, TrackOutput};
use fingerpost::{FrameEvidence, FrameOutput};
use fingerpost_geometry::{Camera, GroundGrid, Pixel};
use fingerpost_report::{COMPOSED_HEIGHT_PX, COMPOSED_WIDTH_PX, Scene, Setting, StagePictures, compose};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Plane, Rect, RgbImage};
use nalgebra::Point2;

/// All stages' pictures of a black frame with this driving line and nothing else.
fn with_line(camera: &Camera, line: Vec<Point2<f64>>) -> StagePictures {
    with(camera, line, None)
}

/// The same with what a lane finder saw.
fn with(camera: &Camera, line: Vec<Point2<f64>>, lanes: Option<&LaneEvidence>) -> StagePictures {
    let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
    let setting = Setting { camera: camera.clone(), grid, features: Vec::new(), vehicle_width_m: 1.8 };
    let (columns, rows) = (grid.columns(), grid.rows());
    let ground = GroundPicture::new(columns, rows, HueSaturationBins { hue: 32, saturation: 32 });
    let mut surface = RoadSurface { probability: Plane::new(columns, rows, 0), ..RoadSurface::default() };
    surface.probability.row_mut(10).fill(255);
    // The left half is seen.
    let mut validity = Plane::new(columns, rows, 0);
    (0..rows).for_each(|row| validity.row_mut(row)[..columns / 2].fill(1));
    let output = FrameOutput {
        camera: Default::default(),
        track: TrackOutput::default(),
        fix: None,
        advice: Default::default(),
        mount: None,
        vehicle: Default::default(),
        centreline: None,
        motion: None,
        motion_doubt: None,
        driving_line_curvature_per_m: vec![0.0; line.len()],
        driving_line: line,
        lane: None,
        departure: None,
        why: "a test".to_owned(),
    };
    let evidence = FrameEvidence {
        ground: &ground,
        validity: &validity,
        surface: &surface,
        road: RoadEvidence {
            detector: "none",
            sample: Rect { x: 190, y: 240, width: 20, height: 60 },
            sample_use: SampleUse::Learned,
            sample_probability: 0.0,
            ..RoadEvidence::default()
        },
        network: None,
        centreline: &Default::default(),
        motion: None,
        signals: None,
        track: &TrackEvidence::default(),
        lanes,
        departure: None,
        masks: None,
        fix: None,
    };
    let picture = RgbImage::new(camera.width(), camera.height());
    StagePictures::draw(&Scene {
        setting: &setting,
        frame: 0,
        t_s: 0.0,
        picture: &picture,
        output: &output,
        evidence: &evidence,
    })
}

fn stage<'a>(pictures: &'a StagePictures, name: &str) -> &'a RgbImage {
    &pictures.pictures.iter().find(|picture| picture.stage == name).unwrap().picture
}

fn brightness(picture: &RgbImage, pixel: Pixel) -> u32 {
    let colour = picture.get(pixel.u.round() as usize, pixel.v.round() as usize).unwrap();
    colour.iter().map(|&c| u32::from(c)).sum()
}

#[test]
fn the_driving_line_lies_in_the_picture_where_the_camera_sees_it() {
    let camera = camera();
    for left_m in [0.0, 2.0, -2.0] {
        let line = (8..40).map(|i| Point2::new(0.5 * f64::from(i), left_m)).collect();
        let pictures = with_line(&camera, line);
        let picture = stage(&pictures, "camera");
        assert_eq!(picture.size(), (640, 480));
        for forward_m in [7.0, 10.0, 15.0] {
            let at = |left_m| camera.pixel_of_ground(Point2::new(forward_m, left_m)).unwrap();
            let on_line = brightness(picture, at(left_m));
            assert!(on_line > 350, "{forward_m} m ahead, {left_m} m left: {on_line}");
            let in_ribbon = brightness(picture, at(left_m + 0.6));
            assert!((60..300).contains(&in_ribbon), "the vehicle's width: {in_ribbon}");
            for beside in [1.3, -1.3] {
                assert_eq!(brightness(picture, at(left_m + beside)), 0, "outside the vehicle's width");
            }
        }
        assert_eq!(brightness(picture, Pixel::new(320.0, 60.0)), 0, "nothing in the sky");
    }
}

#[test]
fn the_ground_pictures_have_left_at_the_left_and_far_at_the_top() {
    let pictures = with_line(&camera(), (8..40).map(|i| Point2::new(0.5 * f64::from(i), 2.5)).collect());
    let ground = stage(&pictures, "ground view");
    assert_eq!(ground.size(), (480, 384));
    // 2.5 m left of 20 m in 480 pixels is 60 pixels left of the middle.
    let [red, green, blue] = ground.get(180, 100).unwrap();
    assert!(green > 150 && green > red && green > blue, "the line is green: {red} {green} {blue}");
    assert_eq!(ground.get(160, 100), Some([0, 0, 0]), "black ground where it is seen");
    let unseen = ground.get(300, 100).unwrap();
    assert!(unseen.iter().all(|&c| (45..100).contains(&c)), "grey where it is not: {unseen:?}");

    let surface = stage(&pictures, "road surface");
    let [road, far_from_road] = [12, 40].map(|row| surface.get(60, row).unwrap());
    assert!(road[0] > 200 && road[1] > 180 && road[2] < 100, "road is yellow, near the top: {road:?}");
    assert!(far_from_road[0] < 60 && far_from_road[1] < 60, "no road is dark: {far_from_road:?}");
}

/// Six tiles of 477 x 149 pixels, two in a line, under titles of 16 pixels.
#[test]
fn every_step_of_the_lane_finder_is_shown_and_thin_lines_stay_whole() {
    const SIZE: (usize, usize) = (640, 200);
    let plane = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
        let mut plane = Plane::new(SIZE.0, SIZE.1, 0_u8);
        rows.for_each(|row| plane.row_mut(row)[columns.clone()].fill(255));
        plane
    };
    // A long piece at the left, and a speck at the right that is too small.
    let mut dilated = plane(100..104, 0..200);
    (79..82).for_each(|row| dilated.row_mut(row)[500..510].fill(255));
    let steps = EdgeSteps {
        top_row: 280,
        mean: Plane::new(SIZE.0, SIZE.1, 120),
        edges: plane(333..334, 0..200),
        oriented: plane(0..0, 0..0),
        dilated,
        labelled: plane(100..104, 0..200),
        thin: plane(102..103, 0..200),
    };
    assert!(with(&camera(), Vec::new(), None).pictures.iter().all(|picture| picture.stage != "lane steps"));
    let evidence = LaneEvidence { steps, ..LaneEvidence::default() };
    let pictures = with(&camera(), Vec::new(), Some(&evidence));
    let picture = stage(&pictures, "lane steps");
    assert_eq!(picture.size(), (960, 3 * (150 + 16) + 12));
    let tile = |step: usize, column: usize, row: usize| {
        let scale = 477.0 / 640.0;
        let at = |px: usize| (px as f64 * scale) as usize;
        picture.get(step % 2 * 483 + at(column), step / 2 * 171 + 16 + at(row)).unwrap()
    };
    assert_eq!(tile(0, 300, 100), [120; 3], "the grey mean");
    for row in (0..200).step_by(7) {
        assert!(tile(1, 333, row)[0] > 200, "row {row} of the edges");
        assert_eq!(tile(1, 320, row), [0; 3]);
        assert_eq!(tile(2, 333, row), [0; 3], "no edge has the direction");
    }
    let [red, green, blue] = tile(3, 102, 100);
    assert!(green > 200 && blue < 100, "a piece that is kept: {red} {green} {blue}");
    let [red, green, blue] = tile(3, 505, 80);
    assert!(red > 200 && green < 100 && blue < 100, "one that is not: {red} {green} {blue}");
    assert_eq!((tile(4, 505, 80), tile(4, 102, 100)[0] > 200), ([0; 3], true));
    assert!(tile(5, 102, 100)[0] > 200);
}

#[test]
fn masks_are_coloured_where_their_spans_are() {
    let mut checked = 0;
    painted_run(&camera(), "A x B", &mut |scene| {
        let Some(placed) = scene.evidence.masks.as_ref().filter(|_| checked < 2) else { return };
        checked += 1;
        let pictures = StagePictures::draw(scene);
        let picture = stage(&pictures, "masks");
        let (columns, rows) = (scene.setting.grid.columns(), scene.setting.grid.rows());
        let mut masked = Plane::new(columns, rows, false);
        for sub in &placed.masks.subs {
            let inside = Rect { x: 0, y: 0, width: columns, height: rows };
            let spans = sub.spans.translated(placed.column, placed.row).intersect_rect(inside);
            for span in spans.spans() {
                masked.row_mut(span.row as usize)[span.start as usize..span.end as usize].fill(true);
            }
        }
        let coloured = |column: usize, row: usize| {
            let scale = picture.width() as f64 / columns as f64;
            let at = |place: usize| ((place as f64 + 0.5) * scale) as usize;
            let [red, green, blue] = picture.get(at(column), at(row)).unwrap();
            red.abs_diff(green).max(green.abs_diff(blue)) > 12
        };
        let (mut right, mut all) = ([0, 0], [0, 0]);
        for row in 0..rows {
            for column in (0..columns).filter(|&column| scene.evidence.validity.get(column, row) == Some(1)) {
                let expected = masked.get(column, row).unwrap();
                all[usize::from(expected)] += 1;
                right[usize::from(expected)] += usize::from(coloured(column, row) == expected);
            }
        }
        // Labels cover some of both; they are a few per cent of the ground and up to a third of the masks.
        assert!(right[1] * 3 > all[1] * 2, "{} of {} mask pixels are coloured", right[1], all[1]);
        assert!(right[0] * 20 > all[0] * 19, "{} of {} others are grey", right[0], all[0]);
    });
    assert_eq!(checked, 2, "the junction was followed");
}

#[test]
fn the_composed_picture_has_one_size_for_every_camera_and_shows_the_frame() {
    let mut seen = 0;
    painted_run(&camera(), "A x B", &mut |scene| {
        if scene.frame % 12 != 5 {
            return;
        }
        seen += 1;
        let composed = compose(scene);
        assert_eq!(composed.size(), (COMPOSED_WIDTH_PX, COMPOSED_HEIGHT_PX));
        assert_eq!(composed, compose(scene), "the same bytes again");
        // The camera's picture is reduced from 640 to 628 pixels with its top left corner at (8, 44): sky is sky.
        assert_eq!(composed.get(300, 80), scene.picture.get(300, 40));
    });
    assert_eq!(seen, 3);
}
