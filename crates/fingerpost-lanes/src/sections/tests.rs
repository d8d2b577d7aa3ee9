use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use nalgebra::Point2;

use super::*;

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 580.0, fy: 580.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: 3_f64.to_radians(), x_m: 1.7, ..Mount::level(1.3) };
    Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap()
}

/// How far the line of an edge may be off, pixels: of those that a drawn edge gives the one with the largest inner angle is
/// kept, be it along the edge or a degree or two across it. In the second section it is 0.1 m.
const MOST_OFF_PX: f64 = 8.0;

/// A straight line on the road: where it passes the rear axle, metres to the left, and its direction, degrees.
#[derive(Clone, Copy)]
struct Line {
    left_m: f64,
    heading_deg: f64,
}

impl Line {
    fn along(left_m: f64) -> Self {
        Self { left_m, heading_deg: 0.0 }
    }

    fn at(self, ahead_m: f64) -> Point2<f64> {
        Point2::new(ahead_m, self.left_m + libm::tan(self.heading_deg.to_radians()) * ahead_m)
    }

    /// Its column in a row.
    fn column(self, view: &RoadView<'_>, row: f64) -> f64 {
        let pixel = |ahead_m: f64| view.pixel_of_ground(self.at(ahead_m)).unwrap();
        let (near, far) = (pixel(6.0), pixel(30.0));
        near.u + (row - near.v) / (far.v - near.v) * (far.u - near.u)
    }
}

/// The candidates of a picture with these lines.
fn candidates(lines: &[Line]) -> (LaneRegion, Vec<LineCandidate>) {
    let (camera, config) = (camera(), LanesConfig::default());
    let view = RoadView::new(&camera, 0.0);
    let mut region = LaneRegion::default();
    region.lay(&config, &camera, 0.0, None);
    let mut thin = Plane::new(640, region.base_row - region.top_row, 0_u8);
    for row in region.top_row..region.base_row {
        for line in lines {
            let column = line.column(&view, row as f64).round();
            if (0.0..640.0).contains(&column) {
                thin.row_mut(row - region.top_row)[column as usize] = 255;
            }
        }
    }
    let mut sections = SectionLines::new(LineSelection::ForPaint).unwrap();
    sections.find(&config, &region, &view, &thin, |_, _, best| best);
    (region, sections.candidates().to_vec())
}

/// How far a candidate's ends are from a line, pixels.
fn off_px(candidate: &LineCandidate, line: Line) -> f64 {
    let camera = camera();
    let view = RoadView::new(&camera, 0.0);
    let ends = [candidate.lower_px, candidate.upper_px];
    ends.map(|end| (end.u - line.column(&view, end.v)).abs()).into_iter().fold(0.0, f64::max)
}

/// The candidate that is the edge of its section and side.
fn kept(found: &[LineCandidate], section: usize, side: Side) -> LineCandidate {
    let is_kept = |c: &&LineCandidate| (c.section, c.side, c.verdict) == (section, side, LineVerdict::Kept);
    let mut kept = found.iter().filter(is_kept);
    let (first, more) = (kept.next(), kept.next());
    assert!(more.is_none(), "one edge a section");
    *first.unwrap()
}

/// A candidate between two places of the road.
fn candidate(side: Side, near: (f64, f64), far: (f64, f64)) -> LineCandidate {
    let camera = camera();
    let view = RoadView::new(&camera, 0.0);
    let pixel = |(ahead_m, left_m)| view.pixel_of_ground(Point2::new(ahead_m, left_m)).unwrap();
    LineCandidate {
        side,
        section: 0,
        lower_px: pixel(near),
        upper_px: pixel(far),
        votes: 50,
        verdict: LineVerdict::NotInnermost,
    }
}

fn judged(candidate: &LineCandidate, before: Option<&LineCandidate>) -> LineVerdict {
    let camera = camera();
    let before = before.map(|before| (before, LineSelection::ForPaint));
    verdict(&LanesConfig::default(), &RoadView::new(&camera, 0.0), candidate, before)
}

#[test]
fn the_lanes_edges_are_kept_in_every_section_where_they_are() {
    let edges = [(Side::Left, Line::along(1.8)), (Side::Right, Line::along(-1.5))];
    let (region, found) = candidates(&edges.map(|(_, line)| line));
    let middle = |c: &LineCandidate| 0.5 * (c.lower_px.u + c.upper_px.u);
    assert!(found.iter().all(|c| (middle(c) < 319.5) == (c.side == Side::Left)), "{found:?}");
    for (section, &[upper, lower]) in region.sections.iter().enumerate() {
        for (side, line) in edges {
            let kept = kept(&found, section, side);
            assert!(off_px(&kept, line) < MOST_OFF_PX, "section {section}: {kept:?}");
            assert!((kept.lower_px.v - lower as f64).abs() < 1e-9);
            assert!((kept.upper_px.v - upper as f64).abs() < 1e-9);
        }
    }
}

#[test]
fn of_two_lines_the_one_nearer_to_the_vehicle_is_the_edge() {
    for sign in [1.0, -1.0] {
        let (inner, outer) = (Line::along(1.5 * sign), Line::along(2.6 * sign));
        let (_, found) = candidates(&[outer, inner]);
        let side = if sign > 0.0 { Side::Left } else { Side::Right };
        for section in 0..3 {
            let kept = kept(&found, section, side);
            assert!(off_px(&kept, inner) < MOST_OFF_PX, "{side:?}, section {section}: {kept:?}");
            assert!(
                section == 0 || found.iter().any(|c| c.section == section && off_px(c, outer) < 2.0),
                "the outer line is seen in section {section}"
            );
        }
    }
}

#[test]
fn of_two_lines_in_the_lowest_section_the_inner_one_is_kept() {
    for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        let (inner, outer) = (Line::along(0.7 * sign), Line::along(1.3 * sign));
        let (_, found) = candidates(&[outer, inner]);
        assert!(off_px(&kept(&found, 0, side), inner) < 2.0, "{side:?}: {found:?}");
        let outer = found.iter().filter(|c| c.section == 0 && off_px(c, outer) < 2.0);
        let verdicts: Vec<LineVerdict> = outer.map(|c| c.verdict).collect();
        assert!(!verdicts.is_empty() && verdicts.iter().all(|v| *v == LineVerdict::NotInnermost));
    }
}

#[test]
fn a_line_across_the_lane_is_none_of_its_edges() {
    for sign in [1.0, -1.0] {
        let across = Line { left_m: 1.0 * sign, heading_deg: 40.0 * sign };
        let (_, found) = candidates(&[across]);
        assert!(found.iter().all(|c| c.verdict != LineVerdict::Kept), "{found:?}");
        let (near, far) = (across.at(6.0), across.at(9.0));
        let side = if sign > 0.0 { Side::Left } else { Side::Right };
        let alone = candidate(side, (near.x, near.y), (far.x, far.y));
        assert_eq!(judged(&alone, None), LineVerdict::Direction);
    }
}

#[test]
fn directions_up_to_twice_the_largest_heading_are_possible() {
    for sign in [1.0, -1.0] {
        let side = if sign > 0.0 { Side::Left } else { Side::Right };
        for (heading_deg, expected) in [
            (28.0, LineVerdict::NotInnermost),
            (-28.0, LineVerdict::NotInnermost),
            (33.0, LineVerdict::Direction),
        ] {
            let rise_m = 3.0 * libm::tan(f64::to_radians(heading_deg));
            let line = candidate(side, (6.0, 2.0 * sign), (9.0, 2.0 * sign + rise_m));
            assert_eq!(judged(&line, None), expected, "{side:?}, {heading_deg} degrees");
        }
    }
}

#[test]
fn an_edge_is_beside_the_vehicle_on_its_own_side() {
    for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        for (left_m, expected) in [
            (1.5, LineVerdict::NotInnermost),
            (3.5, LineVerdict::NotInnermost),
            (3.7, LineVerdict::Distance),
            (-0.1, LineVerdict::NotInnermost),
            (-0.3, LineVerdict::Distance),
            (-1.5, LineVerdict::Distance),
        ] {
            let line = candidate(side, (6.0, sign * left_m), (12.0, sign * left_m));
            assert_eq!(judged(&line, None), expected, "{side:?}, {left_m} m outside");
        }
    }
}

#[test]
fn a_further_section_goes_on_from_the_one_before() {
    for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        let before = candidate(side, (6.0, 1.7 * sign), (10.0, 1.7 * sign));
        let straight_on = candidate(side, (10.0, 1.7 * sign), (18.0, 1.7 * sign));
        assert_eq!(judged(&straight_on, Some(&before)), LineVerdict::NotInnermost);
        // Beside it by less and by more than a joint may gape.
        for (aside_m, expected) in [(0.3, LineVerdict::NotInnermost), (0.6, LineVerdict::Joint)] {
            for aside_m in [aside_m, -aside_m] {
                let outside_m = sign * (1.7 + aside_m);
                let beside = candidate(side, (10.0, outside_m), (14.0, outside_m));
                let turned = (beside.inner_angle_rad() - before.inner_angle_rad()).to_degrees();
                let expected = if turned.abs() > 8.0 { LineVerdict::Turns } else { expected };
                assert_eq!(judged(&beside, Some(&before)), expected, "{side:?}, {aside_m} m");
            }
        }
        for turns_to_m in [-1.2, 1.2] {
            let bent = candidate(side, (10.0, 1.7 * sign), (14.0, 1.7 * sign + turns_to_m));
            assert_eq!(judged(&bent, Some(&before)), LineVerdict::Turns, "{side:?}, to {turns_to_m} m");
        }
    }
}

#[test]
fn inner_angles_mirror_and_grow_towards_the_vehicle() {
    let angle_deg =
        |side, left_m: f64| candidate(side, (6.0, left_m), (12.0, left_m)).inner_angle_rad().to_degrees();
    for left_m in [0.8, 1.7, 3.0] {
        let (left, right) = (angle_deg(Side::Left, left_m), angle_deg(Side::Right, -left_m));
        assert!((left - right).abs() < 1e-6, "{left_m} m: {left} and {right}");
        // Seen from 1.3 m, a line so far aside rises by 1.3 m over that.
        let expected = libm::atan2(1.3, left_m).to_degrees();
        assert!((left - expected).abs() < 1.0, "{left_m} m: {left}, not {expected}");
    }
    // A line that leads outwards leans beyond the upright.
    let outward = candidate(Side::Left, (6.0, 0.3), (9.0, 2.0)).inner_angle_rad().to_degrees();
    assert!(outward > 95.0, "{outward}");
}

#[test]
fn a_line_goes_on_beyond_its_ends() {
    let mut line = candidate(Side::Left, (6.0, 1.7), (12.0, 1.7));
    (line.lower_px, line.upper_px) = (Pixel::new(100.0, 400.0), Pixel::new(160.0, 340.0));
    assert!((line.column_at(400.0) - 100.0).abs() < 1e-12);
    assert!((line.column_at(310.0) - 190.0).abs() < 1e-12);
    assert!((line.column_at(420.0) - 80.0).abs() < 1e-12);
}
