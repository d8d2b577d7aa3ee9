//! `fingerpost calibrate`: a camera's calibration from what it sees, and what it says.

mod chessboard;
mod mount;
mod points;
mod reach;

use anyhow::Result;
use clap::Subcommand;

/// Calibrate a camera and write its camera.toml, or print how far a calibrated one sees.
#[derive(Debug, Subcommand)]
pub(crate) enum CalibrateCommand {
    Chessboard(chessboard::ChessboardArgs),
    Mount(mount::MountArgs),
    Points(points::PointsArgs),
    Reach(reach::ReachArgs),
}

/// Calibrates, or prints.
pub(crate) fn calibrate(command: &CalibrateCommand) -> Result<()> {
    match command {
        CalibrateCommand::Chessboard(args) => chessboard::chessboard(args),
        CalibrateCommand::Mount(args) => mount::mount(args),
        CalibrateCommand::Points(args) => points::points(args),
        CalibrateCommand::Reach(args) => reach::reach(args),
    }
}
