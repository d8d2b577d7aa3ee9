//! `fingerpost convert`: others' recordings as drives.

mod frames_of_topic;
mod kept_messages;
mod kitti;
mod measured;
mod messages;
mod passed_over;
mod recorded_drive;
mod recorded_motion;

use anyhow::Result;
use clap::Subcommand;

use crate::examples::examples;

/// Make a drive folder of another's recording: frames/ with times.txt, camera.toml, and where they were recorded gps.gpx for
/// `run --gps`, motion.csv for `locate --motion` and poses.csv for `locate --truth`.
#[derive(Debug, Subcommand)]
#[command(before_long_help = examples!(
    "convert bag recorded_bag --height-m 1.4 --out drive",
    "convert kitti sequences/00 --out drive"
))]
pub(crate) enum ConvertCommand {
    Mcap(messages::McapArgs),
    Bag(messages::BagArgs),
    Kitti(kitti::KittiArgs),
}

/// Converts.
pub(crate) fn convert(command: &ConvertCommand) -> Result<()> {
    match command {
        ConvertCommand::Mcap(args) => messages::mcap(args),
        ConvertCommand::Bag(args) => messages::bag(args),
        ConvertCommand::Kitti(args) => kitti::kitti(args),
    }
}
