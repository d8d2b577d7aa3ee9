//! The lane as the files have it.

use fingerpost::lanes::departure::DepartureOutput;
use fingerpost::lanes::{Lane, LaneEdge, Marking, MarkingColour, MarkingKind, Side};
use fingerpost_format::{DepartureRecord, LaneEdgeRecord, LanesRecord, MarkingRecord};

use crate::frame::{ANGLE_DIGITS, DIGITS, rounded};

/// Digits behind the point of pixels.
pub const PIXEL_DIGITS: i32 = 2;
/// Digits of curvatures, 1/m: 1 cm at 100 m ahead.
const CURVATURE_DIGITS: i32 = 6;

/// The record of a frame's lane.
pub(crate) fn lanes_record(lane: &Lane, departure: Option<&DepartureOutput>) -> LanesRecord {
    let pixels = |side: Side| {
        let points = lane.edge(side).map_or(&[][..], |edge| &edge.points_px);
        points.iter().map(|p| [p.u, p.v].map(|px| rounded(px, PIXEL_DIGITS))).collect()
    };
    let edge = |side: Side| lane.edge(side).map(edge_record);
    LanesRecord {
        left_px: pixels(Side::Left),
        right_px: pixels(Side::Right),
        left: edge(Side::Left),
        right: edge(Side::Right),
        width_m: lane.width_m().map(|m| rounded(m, DIGITS)),
        departure: departure.map(departure_record),
    }
}

fn edge_record(edge: &LaneEdge) -> LaneEdgeRecord {
    LaneEdgeRecord {
        offset_m: rounded(edge.offset_m, DIGITS),
        heading_rad: rounded(edge.heading_rad, ANGLE_DIGITS),
        curvature_per_m: rounded(edge.curvature_per_m, CURVATURE_DIGITS),
        marking: marking_record(edge.marking),
        kept_frames: edge.kept_frames,
    }
}

fn departure_record(departure: &DepartureOutput) -> DepartureRecord {
    DepartureRecord {
        warning: departure.warning.map(|side| match side {
            Side::Left => fingerpost_format::Side::Left,
            Side::Right => fingerpost_format::Side::Right,
        }),
        lateral_speed_mps: departure.lateral_speed_mps.map(|mps| rounded(mps, DIGITS)),
        time_to_crossing_s: departure.time_to_crossing_s.map(|s| rounded(s, DIGITS)),
        silent_because: departure.silence.map(|silence| silence.name().to_owned()),
    }
}

const fn marking_record(marking: Marking) -> MarkingRecord {
    MarkingRecord {
        kind: match marking.kind {
            MarkingKind::Continuous => fingerpost_format::MarkingKind::Continuous,
            MarkingKind::Broken => fingerpost_format::MarkingKind::Broken,
            MarkingKind::Double => fingerpost_format::MarkingKind::Double,
            MarkingKind::Unknown => fingerpost_format::MarkingKind::Unknown,
        },
        colour: match marking.colour {
            MarkingColour::White => fingerpost_format::MarkingColour::White,
            MarkingColour::Yellow => fingerpost_format::MarkingColour::Yellow,
            MarkingColour::Unknown => fingerpost_format::MarkingColour::Unknown,
        },
    }
}
