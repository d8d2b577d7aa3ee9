use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, Pixel};
use nalgebra::Point2;

use super::*;

const WIDTH: usize = 640;
const HEIGHT: usize = 480;
const LINE_M: f64 = 0.15;

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 580.0, fy: 580.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: 3_f64.to_radians(), x_m: 1.7, ..Mount::level(1.3) };
    Camera::calibrated(WIDTH, HEIGHT, intrinsics, Distortion::None, mount).unwrap()
}

/// A line of paint on the road, from its right edge on 0.15 m to the left: a parabola.
#[derive(Clone, Copy)]
struct Line {
    right_edge_m: f64,
    heading_rad: f64,
    curvature_per_m: f64,
}

impl Line {
    fn along(right_edge_m: f64) -> Self {
        Self { right_edge_m, heading_rad: 0.0, curvature_per_m: 0.0 }
    }

    fn right_edge_m(self, ahead_m: f64) -> f64 {
        self.right_edge_m
            + libm::tan(self.heading_rad) * ahead_m
            + 0.5 * self.curvature_per_m * ahead_m * ahead_m
    }
}

/// Grey road with these lines, four rays a pixel.
fn picture(camera: &Camera, lines: &[Line]) -> RgbImage {
    let mut picture = RgbImage::new(WIDTH, HEIGHT);
    for v in 0..HEIGHT {
        let row = picture.row_mut(v);
        for u in 0..WIDTH {
            let is_paint = |du: f64| {
                let place = camera.ground_of_pixel(Pixel::new(u as f64 + du, v as f64));
                place.filter(|place| place.x < 100.0).is_some_and(|place| {
                    lines.iter().any(|line| (0.0..LINE_M).contains(&(place.y - line.right_edge_m(place.x))))
                })
            };
            let white = [-0.375, -0.125, 0.125, 0.375].into_iter().filter(|du| is_paint(*du)).count();
            row[3 * u..3 * u + 3].fill(80 + 30 * white as u8);
        }
    }
    picture
}

fn region(camera: &Camera) -> LaneRegion {
    let mut region = LaneRegion::default();
    region.lay(&LanesConfig::default(), camera, 0.0, None);
    region
}

/// Thin edges of a picture of these lines, seen from a vehicle whose way has that curvature.
fn found(lines: &[Line], way_curvature_per_m: f64) -> Plane<u8> {
    let camera = camera();
    let config = LanesConfig::default();
    let mut edges = LaneEdges::new(&config, MarkingEdges::Inner).unwrap();
    let view = RoadView::new(&camera, 0.0);
    let frame = picture(&camera, lines);
    let mut steps = EdgeSteps::default();
    edges.find(&config, &region(&camera), &view, way_curvature_per_m, &frame, &mut steps).unwrap();
    steps.thin
}

/// Columns at which a row of the region has an edge.
fn columns(thin: &Plane<u8>, row: usize) -> impl Iterator<Item = f64> + '_ {
    thin.row(row).iter().enumerate().filter(|(_, edge)| **edge != 0).map(|(column, _)| column as f64)
}

/// Share of the rows between two distances in which there is an edge within 2.5 pixels of a curve on the road.
fn share_along(thin: &Plane<u8>, left_m: impl Fn(f64) -> f64, from_m: f64, to_m: f64) -> f64 {
    let camera = camera();
    let top_row = region(&camera).top_row;
    let (mut rows, mut shown) = (0, 0);
    for row in 0..thin.height() {
        let v = (row + top_row) as f64;
        let ahead_m = camera.ground_of_pixel(Pixel::new(319.5, v)).unwrap().x;
        let Some(pixel) = camera.pixel_of_ground(Point2::new(ahead_m, left_m(ahead_m))) else { continue };
        if !(from_m..to_m).contains(&ahead_m) || !(3.0..WIDTH as f64 - 3.0).contains(&pixel.u) {
            continue;
        }
        rows += 1;
        shown += usize::from(columns(thin, row).any(|column| (column - pixel.u).abs() <= 2.5));
    }
    assert!(rows > 15, "{rows} rows");
    shown as f64 / rows as f64
}

#[test]
fn inner_edges_are_found_where_they_are_and_outer_ones_are_not() {
    let (left, right) = (Line::along(1.7), Line::along(-1.5 - LINE_M));
    let thin = found(&[left, right], 0.0);
    for (inner_m, outer_m) in [(1.7, 1.7 + LINE_M), (-1.5, -1.5 - LINE_M)] {
        let inner = share_along(&thin, |_| inner_m, 5.0, 33.0);
        assert!(inner > 0.95, "inner edge at {inner_m} m in {inner} of the rows");
        // Far on, both edges are within the same pixels.
        let outer = share_along(&thin, |_| outer_m, 5.0, 10.0);
        assert!(outer < 0.05, "outer edge at {outer_m} m in {outer} of the rows");
    }
}

#[test]
fn dark_bars_have_no_inner_edge() {
    // Between two wide fields of paint the bar of road is darker than both sides: its edges are outer ones.
    let fields: Vec<Line> = (0..6)
        .flat_map(|i| [1.2 - 0.15 * f64::from(i), 2.2 + 0.15 * f64::from(i)])
        .map(Line::along)
        .collect();
    let thin = found(&fields, 0.0);
    assert!(share_along(&thin, |_| 1.35, 5.0, 12.0) < 0.05, "right edge of the bar, dark to its left");
    assert!(share_along(&thin, |_| 2.2, 5.0, 12.0) > 0.9, "left edge of the bar, bright to its left");
}

#[test]
fn a_bend_is_seen_by_who_drives_along_it_to_either_side() {
    for sign in [1.0, -1.0] {
        let curvature_per_m = sign / 50.0;
        let inner_m = [1.7, -1.5];
        let line = |right_edge_m| Line { right_edge_m, heading_rad: 0.0, curvature_per_m };
        let lines = [line(inner_m[0]), line(inner_m[1] - LINE_M)];
        for way_sign in [1.0, -1.0] {
            let thin = found(&lines, way_sign * curvature_per_m);
            for inner_m in inner_m {
                let share = share_along(&thin, |x| inner_m + 0.5 * curvature_per_m * x * x, 12.0, 21.0);
                let expected = if way_sign > 0.0 { 0.9..1.01 } else { 0.0..0.1 };
                assert!(
                    expected.contains(&share),
                    "bend {curvature_per_m}, way {way_sign}, edge {inner_m} m: {share} of the rows"
                );
            }
        }
    }
}

#[test]
fn edges_beyond_the_largest_heading_or_offset_are_dropped() {
    for sign in [1.0, -1.0] {
        let line = |right_edge_m: f64, heading_deg: f64| Line {
            right_edge_m: if sign > 0.0 { right_edge_m } else { -right_edge_m - LINE_M },
            heading_rad: (sign * heading_deg).to_radians(),
            curvature_per_m: 0.0,
        };
        let share = |line: Line, from_m: f64, to_m: f64| {
            let inner_m = if sign > 0.0 { 0.0 } else { LINE_M };
            share_along(&found(&[line], 0.0), |x| line.right_edge_m(x) + inner_m, from_m, to_m)
        };
        assert!(share(line(1.5, 10.0), 6.0, 12.0) > 0.9);
        assert!(share(line(1.5, -3.0), 6.0, 12.0) > 0.9);
        // Passes under the camera, so that it stands upright in the picture, and comes within any offset.
        assert!(share(line(-1.7 * libm::tan(0.42), 24.0), 4.5, 7.5) < 0.1);
        assert!(share(line(-1.7 * libm::tan(0.21), 12.0), 6.0, 10.0) > 0.9);
        // At 13 m an edge may be 3.6 + 1.3 m aside.
        assert!(share(line(3.4, 0.0), 11.2, 15.0) > 0.9);
        assert!(share(line(5.3, 0.0), 11.2, 15.0) < 0.1);
    }
}

#[test]
fn specks_are_dropped() {
    let camera = camera();
    let config = LanesConfig::default();
    let mut frame = picture(&camera, &[]);
    for v in 380..384 {
        frame.row_mut(v)[3 * 200..3 * 204].fill(230);
    }
    let mut edges = LaneEdges::new(&config, MarkingEdges::Inner).unwrap();
    let (view, mut steps) = (RoadView::new(&camera, 0.0), EdgeSteps::default());
    edges.find(&config, &region(&camera), &view, 0.0, &frame, &mut steps).unwrap();
    assert!(steps.oriented.as_slice().iter().any(|edge| *edge != 0), "the speck has edges of that kind");
    assert!(steps.thin.as_slice().iter().all(|edge| *edge == 0));
}

#[test]
fn the_buffer_fills_while_the_region_stays() {
    let camera = camera();
    let config = LanesConfig { reaction_time_s: 1.0, most_range_m: 60.0, ..LanesConfig::default() };
    let view = RoadView::new(&camera, 0.0);
    let mut edges = LaneEdges::new(&config, MarkingEdges::Inner).unwrap();
    let mut steps = EdgeSteps::default();
    let mut region = LaneRegion::default();
    let grey = |level: u8| {
        let mut frame = RgbImage::new(WIDTH, HEIGHT);
        (0..HEIGHT).for_each(|v| frame.row_mut(v).fill(level));
        frame
    };
    // A speed that hovers by a metre a second moves what is needed by a row or two and back.
    for (index, level) in [60, 120, 60, 120, 60, 120, 60, 120].into_iter().enumerate() {
        let speed_mps = 37.0 + f64::from(index as u32 % 3) - 1.0;
        region.lay(&config, &camera, 0.002 * f64::from(index as u32 % 2), Some(speed_mps));
        edges.find(&config, &region, &view, 0.0, &grey(level), &mut steps).unwrap();
        let mean = steps.mean.row(0)[0];
        assert!(index < 3 || (71..=109).contains(&mean), "frame {index}: {mean} is no mean of three");
    }
}

/// Paper 3, III-A: the buffer takes transient noise away.
#[test]
fn more_frames_in_the_buffer_leave_less_noise_beside_a_faint_line() {
    let camera = camera();
    let clean = picture(&camera, &[Line::along(1.7)]);
    let noisy = |frame: u64| {
        let mut noisy = clean.clone();
        for v in 0..HEIGHT {
            for (u, pixel) in noisy.row_mut(v).chunks_exact_mut(3).enumerate() {
                let place = frame << 32 | (v * WIDTH + u) as u64;
                let mixed = place.wrapping_mul(0x9E37_79B9_7F4A_7C15);
                let noise = ((mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 32) % 81;
                let level = 80 + (pixel[0] - 80) / 4 + noise as u8 - 40;
                pixel.fill(level);
            }
        }
        noisy
    };
    let seen = [1, 3, 10].map(|buffer_frames| {
        let config = LanesConfig { buffer_frames, ..LanesConfig::default() };
        let mut edges = LaneEdges::new(&config, MarkingEdges::Inner).unwrap();
        let (view, mut steps) = (RoadView::new(&camera, 0.0), EdgeSteps::default());
        for frame in 0..10 {
            edges.find(&config, &region(&camera), &view, 0.0, &noisy(frame), &mut steps).unwrap();
        }
        let thin = &steps.thin;
        assert!(share_along(thin, |_| 1.7, 5.0, 20.0) > 0.95, "{buffer_frames} frames show the line");
        thin.as_slice().iter().filter(|edge| **edge != 0).count()
    });
    assert!(seen[0] > 5 * seen[1] && seen[1] > 2 * seen[2], "edges: {seen:?}");
}

#[test]
fn a_vehicle_that_turns_on_the_spot_is_held_to_what_it_can_see() {
    let camera = camera();
    let (region, view) = (region(&camera), RoadView::new(&camera, 0.0));
    let limits = |max_heading_deg: f64, curvature_per_m: f64| {
        let (mut limits, config) = (Vec::new(), LanesConfig { max_heading_deg, ..LanesConfig::default() });
        lay_limits(&mut limits, &config, &region, &view, curvature_per_m, WIDTH);
        limits
    };
    for max_heading_deg in [1.0, 15.0, 45.0] {
        let straight = limits(max_heading_deg, 0.0);
        assert!(straight.len() > 20);
        for curvature_per_m in [1.25, -1.25, 5.0, -5.0] {
            let turning = limits(max_heading_deg, curvature_per_m);
            assert_eq!(turning.len(), straight.len(), "no row is without limits at {curvature_per_m}");
            for (turning, straight) in turning.iter().zip(&straight) {
                assert!(turning.horizon_from < turning.horizon_to, "{turning:?}");
                let moved_px = straight.ahead - turning.ahead;
                assert!(
                    moved_px * curvature_per_m as f32 > 0.0,
                    "the way leads to the turn's side: {turning:?}"
                );
            }
        }
    }
    // Headings that no configuration has are no reason to panic.
    assert!(!limits(80.0, 1.25).is_empty());
    assert!(limits(f64::NAN, 1.25).is_empty());
    // An ordinary bend is taken as it is: at 20 m a bend of 50 m radius has turned by 0.4 and led 4 m aside.
    let place = Point2::new(20.0, 0.0);
    let row = view.pixel_of_ground(place).unwrap().v - region.top_row as f64;
    let bend = limits(15.0, 0.02);
    let limit =
        bend.iter().min_by(|a, b| (a.row - row as f32).abs().total_cmp(&(b.row - row as f32).abs())).unwrap();
    let ahead = camera
        .ground_of_pixel(Pixel::new(f64::from(limit.ahead), f64::from(limit.row) + region.top_row as f64));
    let ahead = ahead.unwrap();
    assert!((ahead.y - 0.01 * ahead.x * ahead.x).abs() < 1e-3, "{ahead}");
}

#[test]
fn an_edge_must_be_brighter_outside_and_lead_to_the_horizons_stretch() {
    let limit = RowLimits {
        row: 100.0,
        from: 0.0,
        to: 640.0,
        ahead: 320.0,
        horizon_from: 300.0,
        horizon_to: 340.0,
        horizon_row: 0.0,
    };
    // Both lines lead to (320, 0): from the left its normal points left and up, from the right right and up.
    for (x, outside) in [(220.0, [-50.0, -50.0]), (420.0, [50.0, -50.0])] {
        let inside = outside.map(|g: f32| -g);
        assert!(!limit.accepts(MarkingEdges::Inner, x, 100.0, inside, 0.0), "bright on the inside");
        assert!(limit.accepts(MarkingEdges::Both, x, 100.0, inside, 0.0), "a marking's outer edge");
        for kept in [MarkingEdges::Inner, MarkingEdges::Both] {
            assert!(limit.accepts(kept, x, 100.0, outside, 0.0));
            assert!(
                !limit.accepts(kept, x, 100.0, [outside[0], 0.0], 0.0),
                "upright, 100 px beside the stretch"
            );
            assert!(!limit.accepts(kept, x, 100.0, [outside[0], -outside[1]], 0.0), "leads away");
            assert!(!limit.accepts(kept, 220.0, 100.0, [0.0, -50.0], 0.0), "level");
        }
        let nearly_level = [0.1 * outside[0], outside[1]];
        assert!(!limit.accepts(MarkingEdges::Both, x, 100.0, nearly_level, 0.0), "six degrees off level");
    }
}
