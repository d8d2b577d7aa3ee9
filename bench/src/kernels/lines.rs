//! Lines and segments of edge pictures, and thin lines of wide ones.

use std::f64::consts::PI;

use anyhow::Result;
use fingerpost_vision::hough::{HoughLines, HoughParams, HoughSegments};
use fingerpost_vision::picture::Plane;
use serde_json::json;

use super::edges::edge_picture;
use super::{Bench, Kernel, Promise, SIDE_PX, agreement, array_of_plane, rust_crates, size_of};
use crate::results::{Agreement, Row};

/// Steps of a pixel and a degree.
const PARAMS: HoughParams = HoughParams { rho_step_px: 1.0, theta_step_rad: PI / 180.0, votes: 60 };
/// Strongest lines that are compared.
const STRONGEST: usize = 20;
/// Shortest segment, pixels.
const SHORTEST_PX: f64 = 30.0;
/// Widest gap in a segment, pixels.
const WIDEST_GAP_PX: f64 = 10.0;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let edges = edge_picture(&bench.frames[0])?;
    let mut rows = lines(bench, &edges)?;
    rows.extend(segments(bench, &edges)?);
    Ok(rows)
}

fn lines(bench: &mut Bench<'_>, edges: &Plane<u8>) -> Result<Vec<Row>> {
    let theirs =
        bench.opencv_gives("hough_lines", &json!({"votes": PARAMS.votes}), &[array_of_plane(edges)])?;
    let theirs: Vec<[f64; 2]> =
        theirs[0].f32s().as_chunks::<2>().0.iter().map(|line| line.map(f64::from)).collect();
    let kernel = Kernel {
        what: "Hough lines",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: HoughLines::new(PARAMS)?,
        work: &|finder| {
            finder.find(edges.view());
            Ok(())
        },
        compare: &|finder| {
            let lines = finder.find(edges.view()).iter();
            let ours: Vec<[f64; 2]> = lines.map(|line| [line.rho_px, line.theta_rad]).collect();
            Ok(same_lines(&ours, &theirs))
        },
    };
    bench.rows(&kernel, rust_crates::hough_lines(edges, PARAMS.votes))
}

/// Each of OpenCV's strongest lines is within a bin of one of ours that is about as strong.
fn same_lines(ours: &[[f64; 2]], theirs: &[[f64; 2]]) -> Agreement {
    let near = |[rho, theta]: [f64; 2]| {
        ours.iter().take(2 * STRONGEST).any(|line| {
            (line[0] - rho).abs() <= PARAMS.rho_step_px + 1e-6
                && (line[1] - theta).abs() <= PARAMS.theta_step_rad + 1e-6
        })
    };
    let strongest = theirs.len().min(STRONGEST);
    let found = theirs.iter().take(strongest).filter(|line| near(**line)).count();
    agreement::share_of(found, strongest, 1.0, "of the strongest lines within a bin")
}

/// Segments are not compared one by one: OpenCV's are found in a random order of the pixels.
fn segments(bench: &mut Bench<'_>, edges: &Plane<u8>) -> Result<Vec<Row>> {
    let params = HoughParams { votes: 50, ..PARAMS };
    let parameters = json!({"votes": params.votes, "min_length": SHORTEST_PX, "max_gap": WIDEST_GAP_PX});
    let theirs = bench.opencv_gives("hough_segments", &parameters, &[array_of_plane(edges)])?;
    let theirs = theirs[0].i32s();
    let kernel = Kernel {
        what: "Hough segments",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: HoughSegments::new(params, SHORTEST_PX, WIDEST_GAP_PX)?,
        work: &|finder| {
            finder.find(edges.view());
            Ok(())
        },
        compare: &|finder| {
            let segments = finder.find(edges.view()).iter();
            let ours: Vec<[[f64; 2]; 2]> =
                segments.map(|segment| [segment.start_px, segment.end_px]).collect();
            Ok(same_long_segments(&ours, &theirs))
        },
    };
    bench.rows(&kernel, Vec::new())
}

/// The middles of OpenCV's long segments lie on ours.
fn same_long_segments(ours: &[[[f64; 2]; 2]], theirs: &[i32]) -> Agreement {
    let (theirs, _) = theirs.as_chunks::<4>();
    let long = theirs
        .iter()
        .filter(|s| libm::hypot(f64::from(s[2] - s[0]), f64::from(s[3] - s[1])) >= 2.0 * SHORTEST_PX);
    let (mut covered, mut all) = (0, 0);
    for segment in long {
        all += 1;
        let [x0, y0, x1, y1] = segment.map(f64::from);
        covered += usize::from(on_a_segment(ours, [0.5 * (x0 + x1), 0.5 * (y0 + y1)]));
    }
    Agreement {
        found: format!("{covered} of OpenCV's {all} long segments lie on ours, {} in all", ours.len()),
        // Which pixels are left for a segment depends on the order in which others were found.
        holds: all > 0 && 10 * covered >= 9 * all,
    }
}

/// Whether the point lies within two pixels of a segment.
fn on_a_segment(segments: &[[[f64; 2]; 2]], [x, y]: [f64; 2]) -> bool {
    segments.iter().any(|[a, b]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let along = ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy).max(1e-9);
        let along = along.clamp(0.0, 1.0);
        libm::hypot(x - a[0] - along * dx, y - a[1] - along * dy) <= 2.0
    })
}
