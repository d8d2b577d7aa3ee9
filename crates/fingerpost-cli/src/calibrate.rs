//! `fingerpost calibrate`: a camera's calibration from what it sees, and what it says.

mod chessboard;
mod mount;
mod points;
mod reach;

use anyhow::Result;
use clap::Subcommand;

use crate::examples::examples;

/// Calibrate a camera and write its camera.toml, or print how far a calibrated one sees.
#[derive(Debug, Subcommand)]
#[command(before_long_help = examples!(
    "calibrate chessboard pictures/ --corners 9x6 --square-m 0.025 --height-m 1.4 --out rough.toml",
    "calibrate mount drive.mp4 --camera rough.toml --speed-mps 13.9 --out camera.toml"
))]
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
