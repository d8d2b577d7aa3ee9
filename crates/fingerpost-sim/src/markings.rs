//! What is painted on a road: its lines, and the markings that they make.
//!
//! A layout is told across the road, metres to the left of its axis. A marking is one line or two beside each other; its
//! edges are those of its paint.

use fingerpost_format::{MarkingColour, MarkingKind, MarkingRecord};

use crate::TrafficSide;
use crate::conditions::{Conditions, LaneMarkings, LineColour, LineStyle, Markings};
use crate::course::MEDIAN_M;
use crate::roads::{Stroke, Surface};
use crate::street_paint::{EDGE_LINE_M, StreetPaint};

/// Narrowest two-way road with a centre line, metres.
const CENTRE_LINE_FROM_M: f64 = 5.0;
/// Narrowest road with edge lines, metres.
const EDGE_LINES_FROM_M: f64 = 5.4;
/// Gap between the lines of a double one, metres.
pub(crate) const DOUBLE_GAP_M: f32 = 0.12;
/// Narrowest lane that is marked, metres: a car and a mirror's width.
const NARROWEST_LANE_M: f64 = 2.2;
/// Half of the width of a car and 0.4 m to the road's edge, metres.
const HALF_CAR_M: f64 = 1.3;
/// Lines stop this far from another road's edge, metres.
const MOUTH_M: f32 = 0.6;

/// A painted line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    /// Its middle, metres to the left of the road's axis.
    pub(crate) middle_m: f32,
    /// Its width, metres.
    pub(crate) width_m: f32,
    /// Length of a dash, and of a dash and a gap together, metres; none for a continuous line.
    pub(crate) dash_m: Option<[f32; 2]>,
    /// Its colour.
    pub(crate) colour: MarkingColour,
}

/// One or two lines that bound a lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Marking {
    /// Left edge of its paint, metres to the left of the road's axis.
    pub(crate) left_m: f64,
    /// Right edge of its paint, likewise.
    pub(crate) right_m: f64,
    /// How it looks.
    pub(crate) look: MarkingRecord,
}

impl Marking {
    fn middle_m(&self) -> f64 {
        0.5 * (self.left_m + self.right_m)
    }
}

/// What is painted across a road.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Layout {
    lines: Vec<Line>,
    /// From the right to the left.
    markings: Vec<Marking>,
}

impl Layout {
    /// What is painted on a stroke, in its own direction.
    pub(crate) fn of(stroke: &Stroke, conditions: &Conditions, traffic: TrafficSide) -> Self {
        match conditions.markings {
            _ if stroke.surface != Surface::Paved => Self::default(),
            Markings::None => Self::default(),
            Markings::Lines => Self::of_street(stroke, &StreetPaint::USUAL),
            Markings::Streets => Self::of_street(stroke, &stroke.paint),
            Markings::Lanes => match Lanes::of(stroke, &conditions.lanes) {
                Some(lanes) if traffic == TrafficSide::Left => lanes.layout(&conditions.lanes).mirrored(),
                Some(lanes) => lanes.layout(&conditions.lanes),
                None => Self::default(),
            },
        }
    }

    fn of_street(stroke: &Stroke, paint: &StreetPaint) -> Self {
        let mut layout = Self::default();
        let width_m = 2.0 * stroke.half_width_m;
        let has_edges = width_m >= EDGE_LINES_FROM_M;
        let edge_m = stroke.half_width_m as f32 - paint.edges_m;
        if has_edges {
            layout.add(&paint.edge_lines(-edge_m));
        }
        if stroke.two_way && width_m >= CENTRE_LINE_FROM_M {
            layout.add(&paint.centre_lines());
        }
        if has_edges {
            layout.add(&paint.edge_lines(edge_m));
        }
        layout
    }

    /// Adds a marking of one or two lines to the left of those there are.
    fn add(&mut self, lines: &[Line]) {
        let edge = |line: &Line, side: f32| f64::from(line.middle_m + side * 0.5 * line.width_m);
        let kind = match lines {
            [_, _, ..] => MarkingKind::Double,
            [line] if line.dash_m.is_some() => MarkingKind::Broken,
            _ => MarkingKind::Continuous,
        };
        let (Some(right), Some(left)) = (lines.first(), lines.last()) else { return };
        self.markings.push(Marking {
            left_m: edge(left, 1.0),
            right_m: edge(right, -1.0),
            look: MarkingRecord { kind, colour: right.colour },
        });
        self.lines.extend(lines);
    }

    /// The same seen by who drives against the road's direction.
    pub(crate) fn mirrored(&self) -> Self {
        let turned = |line: &Line| Line { middle_m: -line.middle_m, ..*line };
        let swapped = |marking: &Marking| Marking {
            left_m: -marking.right_m,
            right_m: -marking.left_m,
            look: marking.look,
        };
        Self {
            lines: self.lines.iter().rev().map(turned).collect(),
            markings: self.markings.iter().rev().map(swapped).collect(),
        }
    }

    /// The same without the marking on the road's axis, if there is one.
    pub(crate) fn without_centre(mut self) -> Self {
        self.markings.retain(|marking| !(marking.right_m..=marking.left_m).contains(&0.0));
        self
    }

    /// The lines.
    pub(crate) fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// The markings, from the right to the left.
    pub(crate) fn markings(&self) -> &[Marking] {
        &self.markings
    }

    /// The markings to the left and to the right of a place.
    pub(crate) fn around(&self, left_m: f64) -> [Option<&Marking>; 2] {
        let first_left = self.markings.partition_point(|marking| marking.middle_m() <= left_m);
        [self.markings.get(first_left), first_left.checked_sub(1).and_then(|i| self.markings.get(i))]
    }

    /// Whether lines are drawn at a place so far from another road's edge.
    pub(crate) fn interrupted(other_m: f32) -> bool {
        other_m < MOUTH_M
    }
}

/// A road's division into lanes.
#[derive(Debug, Clone, Copy)]
struct Lanes {
    /// Lanes to either side of the axis of a two-way road, or all those of a one-way road.
    count: usize,
    width_m: f64,
    two_way: bool,
}

impl Lanes {
    /// As many lanes as there is room for; none on a road that is too narrow.
    fn of(stroke: &Stroke, markings: &LaneMarkings) -> Option<Self> {
        let half_m = stroke.half_width_m - f64::from(EDGE_LINE_M);
        let room_m = if stroke.two_way { half_m } else { 2.0 * half_m };
        // A road made just as wide as its lanes has all of them.
        let count = ((room_m / markings.lane_width_m + 1e-6).floor() as usize).max(1);
        let width_m = markings.lane_width_m.min(room_m / count as f64);
        (width_m >= NARROWEST_LANE_M).then_some(Self { count, width_m, two_way: stroke.two_way })
    }

    /// The outermost lane's middle, metres from the axis.
    fn outermost_m(&self) -> f64 {
        let lanes = if self.two_way { self.count as f64 } else { 0.5 * self.count as f64 };
        (lanes - 0.5) * self.width_m
    }

    fn layout(&self, markings: &LaneMarkings) -> Layout {
        let mut layout = Layout::default();
        let last = if self.two_way { 2 * self.count } else { self.count };
        for i in 0..=last {
            let middle_m = (i as f64 - 0.5 * last as f64) * self.width_m;
            let style = if i == 0 || i == last { markings.edge } else { markings.between };
            // Who drives along the road is to the left of its rightmost marking and to the right of all others.
            layout.add(&lines_of(
                style,
                middle_m as f32,
                markings.line_width_m as f32,
                if i == 0 { Inner::Left } else { Inner::Right },
            ));
        }
        layout
    }
}

/// The side of a marking from which it is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Inner {
    Left,
    Right,
}

/// The lines of a marking, from the right to the left; with its `inner` one on that side.
fn lines_of(style: LineStyle, middle_m: f32, width_m: f32, inner: Inner) -> Vec<Line> {
    let colour = match style.colour {
        LineColour::White => MarkingColour::White,
        LineColour::Yellow => MarkingColour::Yellow,
    };
    let dashes_m = style.pattern.dashes_m();
    let first_m = middle_m - 0.5 * (dashes_m.len() as f32 - 1.0) * (DOUBLE_GAP_M + width_m);
    (0..dashes_m.len())
        .map(|i| Line {
            middle_m: first_m + i as f32 * (DOUBLE_GAP_M + width_m),
            width_m,
            dash_m: dashes_m[if inner == Inner::Left { dashes_m.len() - 1 - i } else { i }],
            colour,
        })
        .collect()
}

/// How far left of a stroke's axis, as seen along the route, a vehicle keeps, metres.
pub(crate) fn lane_middle_m(stroke: &Stroke, conditions: &Conditions, traffic: TrafficSide) -> f64 {
    let sign = match traffic {
        TrafficSide::Left => 1.0,
        TrafficSide::Right => -1.0,
        TrafficSide::Centre => return 0.0,
    };
    let marked = conditions.markings == Markings::Lanes && stroke.surface == Surface::Paved;
    if let Some(lanes) = Lanes::of(stroke, &conditions.lanes).filter(|_| marked) {
        return sign * lanes.outermost_m();
    }
    let quarter = 0.5 * stroke.half_width_m;
    let widest = (stroke.half_width_m - HALF_CAR_M).max(0.0);
    if stroke.two_way { sign * quarter.min(widest) } else { 0.0 }
}

/// The middles of a road's lanes as seen along the route, metres to the left of its axis.
#[derive(Debug, Clone, Default)]
pub(crate) struct LanesBeside {
    /// The vehicle's.
    pub(crate) own_m: f64,
    /// Others of its direction.
    pub(crate) same_direction_m: Vec<f64>,
    /// Of the other direction.
    pub(crate) oncoming_m: Vec<f64>,
}

/// The lanes of a stroke.
pub(crate) fn lanes_beside(stroke: &Stroke, conditions: &Conditions, traffic: TrafficSide) -> LanesBeside {
    let own_m = lane_middle_m(stroke, conditions, traffic);
    let mut beside = LanesBeside { own_m, ..LanesBeside::default() };
    let Some(lanes) = Lanes::of(stroke, &conditions.lanes) else { return beside };
    let last = if lanes.two_way { 2 * lanes.count } else { lanes.count };
    for i in 0..last {
        let middle_m = (i as f64 + 0.5 - 0.5 * last as f64) * lanes.width_m;
        let is_oncoming = lanes.two_way && middle_m * own_m < 0.0;
        if is_oncoming {
            beside.oncoming_m.push(middle_m);
        } else if (middle_m - own_m).abs() > 0.5 * lanes.width_m {
            beside.same_direction_m.push(middle_m);
        }
    }
    if !lanes.two_way {
        // The carriageway of the other direction lies beyond the median.
        let sign = if traffic == TrafficSide::Left { -1.0 } else { 1.0 };
        let aside_m = sign * (2.0 * stroke.half_width_m + MEDIAN_M);
        beside.oncoming_m.extend([-0.5, 0.5].map(|lane| aside_m + lane * lanes.width_m));
    }
    beside
}

#[cfg(test)]
mod tests;
