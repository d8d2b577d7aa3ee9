//! `fingerpost calibrate`: a camera's calibration from what it sees.

mod mount;
mod points;

use anyhow::Result;
use clap::Subcommand;

/// Calibrate a camera and write its camera.toml.
#[derive(Debug, Subcommand)]
pub(crate) enum CalibrateCommand {
    Mount(mount::MountArgs),
    Points(points::PointsArgs),
}

/// Calibrates.
pub(crate) fn calibrate(command: &CalibrateCommand) -> Result<()> {
    match command {
        CalibrateCommand::Mount(args) => mount::mount(args),
        CalibrateCommand::Points(args) => points::points(args),
    }
}
