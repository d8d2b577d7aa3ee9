//! `fingerpost calibrate reach`: how far ahead a camera's rows show the road, and how far a driver needs to see.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use fingerpost_calibration::{FARTHEST_M, Reach, ReachOfReaction, ReachOfRows};

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

/// Prints.
pub(crate) fn reach(args: &ReachArgs) -> Result<()> {
    let reach = Reach::of(&inputs::camera(&args.camera)?);
    if reach.rows.is_empty() {
        bail!("{} sees no road within {FARTHEST_M} m; see its mount", args.camera.display());
    }
    if args.json { output::print_json(&reach) } else { output::print_text(text(&reach).trim_end()) }
}

/// Both tables as a person reads them.
fn text(reach: &Reach) -> String {
    let mut text = "  rows   range m   m per row   depth of the next row m\n".to_owned();
    for ReachOfRows { rows, range_m, m_per_row, row_depth_m } in &reach.rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{rows:>6}  {range_m:>8.2}  {m_per_row:>10.4}  {row_depth_m:>24.3}");
    }
    let speeds = reach.reactions.first().map_or(&[][..], |reaction| &reaction.needs);
    let speeds = speeds.iter().map(|need| format!("{:>17}", format!("{} km/h", need.speed_kmh)));
    let _ = writeln!(text, "\n{:<28}{:>5}{}", "driven until braking, rows", "s", speeds.collect::<String>());
    for ReachOfReaction { doing, reaction_s, needs } in &reach.reactions {
        let needs = needs.iter().map(|need| {
            let rows = need.rows.map_or("-".to_owned(), |rows| rows.to_string());
            format!("{:>9.1} m {rows:>5}", need.distance_m)
        });
        let _ = writeln!(text, "{doing:<28}{reaction_s:>5}{}", needs.collect::<String>());
    }
    text
}
