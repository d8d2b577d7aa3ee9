//! `fingerpost calibrate reach`: how far ahead a camera's rows show the road, and how far a driver needs to see.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use fingerpost_geometry::{Camera, Pixel};
use serde::Serialize;

use crate::examples::examples;
use crate::{inputs, output};

/// Print how far ahead each row of the picture shows the road, and how many rows a driver's reaction needs at which speed
/// (paper 3, tables II and I, for this camera).
///
/// Rows are counted from the picture's base, distances ahead from the rear axle, both down the picture's middle.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "calibrate reach --camera camera.toml",
    "calibrate reach --camera camera.toml --json"
))]
pub(crate) struct ReachArgs {
    /// Calibration, camera.toml.
    #[arg(long, value_name = "FILE")]
    camera: PathBuf,
    /// Print the numbers as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// What drivers do and how long it takes them to begin to brake, seconds (paper 3, table I).
const REACTIONS_S: [(&str, f64); 5] = [
    ("driving", 0.392),
    ("radio", 0.408),
    ("talking to a passenger", 0.453),
    ("handheld telephone", 0.464),
    ("hands-free telephone", 0.465),
];
/// Speeds for which distances are given, km/h: town, country roads, motorways.
const SPEEDS_KMH: [f64; 5] = [30.0, 50.0, 80.0, 100.0, 120.0];
/// Lines of the table of rows in the picture's height.
const LINES: usize = 48;
/// Rows that show the road farther away are left out, metres: there a row is metres deep.
const FARTHEST_M: f64 = 100.0;

/// Both tables.
#[derive(Debug, Serialize)]
struct Reach {
    rows: Vec<RowReach>,
    reactions: Vec<Reaction>,
}

/// How far the road is seen in so many rows.
#[derive(Debug, Serialize)]
struct RowReach {
    rows: usize,
    range_m: f64,
    /// Range over rows.
    m_per_row: f64,
    /// How much farther away the next row shows the road.
    row_depth_m: f64,
}

/// What a driver's reaction needs at several speeds.
#[derive(Debug, Serialize)]
struct Reaction {
    doing: &'static str,
    reaction_s: f64,
    needs: Vec<Need>,
}

#[derive(Debug, Serialize)]
struct Need {
    speed_kmh: f64,
    /// Driven until the driver begins to brake.
    distance_m: f64,
    /// Rows that show the road so far; none where none does.
    rows: Option<usize>,
}

/// Prints.
pub(crate) fn reach(args: &ReachArgs) -> Result<()> {
    let reach = Reach::of(&inputs::camera(&args.camera)?);
    if reach.rows.is_empty() {
        bail!("{} sees no road within {FARTHEST_M} m; see its mount", args.camera.display());
    }
    if args.json { output::print_json(&reach) } else { output::print_text(reach.text().trim_end()) }
}

/// How far ahead the uppermost of the picture's lowest `rows` shows the road, metres; none where it shows none.
fn range_m(camera: &Camera, rows: usize) -> Option<f64> {
    let row = camera.height().checked_sub(rows)?;
    let middle = Pixel::new((camera.width() - 1) as f64 / 2.0, row as f64);
    camera.ground_of_pixel(middle).map(|place| place.x).filter(|m| (0.0..=FARTHEST_M).contains(m))
}

impl Reach {
    fn of(camera: &Camera) -> Self {
        let step = (camera.height() / LINES).max(1);
        let line = |rows: usize| {
            let range_m = range_m(camera, rows)?;
            let next_m = self::range_m(camera, rows + 1)?;
            Some(RowReach { rows, range_m, m_per_row: range_m / rows as f64, row_depth_m: next_m - range_m })
        };
        let need = |reaction_s: f64, speed_kmh: f64| {
            let distance_m = reaction_s * speed_kmh / 3.6;
            let reaches = |rows: &usize| range_m(camera, *rows).is_some_and(|m| m >= distance_m);
            Need { speed_kmh, distance_m, rows: (1..=camera.height()).find(reaches) }
        };
        let reaction = |(doing, reaction_s)| Reaction {
            doing,
            reaction_s,
            needs: SPEEDS_KMH.iter().map(|&speed_kmh| need(reaction_s, speed_kmh)).collect(),
        };
        Self {
            rows: (step..=camera.height()).step_by(step).filter_map(line).collect(),
            reactions: REACTIONS_S.into_iter().map(reaction).collect(),
        }
    }

    fn text(&self) -> String {
        let mut text = "  rows   range m   m per row   depth of the next row m\n".to_owned();
        for RowReach { rows, range_m, m_per_row, row_depth_m } in &self.rows {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{rows:>6}  {range_m:>8.2}  {m_per_row:>10.4}  {row_depth_m:>24.3}");
        }
        let speeds = SPEEDS_KMH.map(|kmh| format!("{:>17}", format!("{kmh} km/h")));
        let _ = writeln!(text, "\n{:<28}{:>5}{}", "driven until braking, rows", "s", speeds.concat());
        for Reaction { doing, reaction_s, needs } in &self.reactions {
            let needs = needs.iter().map(|need| {
                let rows = need.rows.map_or("-".to_owned(), |rows| rows.to_string());
                format!("{:>9.1} m {rows:>5}", need.distance_m)
            });
            let _ = writeln!(text, "{doing:<28}{reaction_s:>5}{}", needs.collect::<String>());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};

    use super::*;

    #[test]
    fn rows_and_distances_are_those_of_the_ground_plane() {
        let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.0 };
        let mount = Mount { x_m: 1.5, ..Mount::level(1.2) };
        let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let reach = Reach::of(&camera);
        // Row 380 is the uppermost of a hundred: 600 * 1.2 / (380 - 239) before the camera.
        let hundred = reach.rows.iter().find(|line| line.rows == 100).unwrap();
        assert!((hundred.range_m - (1.5 + 720.0 / 141.0)).abs() < 1e-9);
        assert!((hundred.row_depth_m - (720.0 / 140.0 - 720.0 / 141.0)).abs() < 1e-9);
        assert!((hundred.m_per_row - hundred.range_m / 100.0).abs() < 1e-12);
        // The horizon is in row 239, and no row between it and a hundred metres is told.
        assert!(reach.rows.iter().all(|line| line.rows <= 480 - 247));
        // The paper's first line: 0.392 s at 120 km/h are 13 m; 720 / 11.57 = 62.2 rows below the horizon.
        let need = &reach.reactions[0].needs[4];
        assert!((need.distance_m - 13.07).abs() < 0.01);
        assert_eq!(need.rows, Some(480 - 239 - 62));
    }
}
