//! `fingerpost calibrate chessboard`: intrinsics and lens distortion from pictures of a chessboard.

mod pictures;
mod report;

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, Result};
use clap::Args;
use fingerpost_calibration::{BoardPoint, board_points, calibrate_lens, common_size};
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::Mount;
use fingerpost_io::write_file;
use fingerpost_vision::chessboard::BoardSize;

use self::pictures::{Looked, check_board, look_at_all, paths_of};
use self::report::Report;
use crate::arguments::number;
use crate::examples::examples;
use crate::output_path::FileKind;
use crate::{output, output_path};

/// Find a camera's focal lengths, principal point and lens distortion from pictures of a chessboard, and write its camera.toml.
///
/// Print a board, fix it on something flat, and take 10 to 20 pictures: the whole board in each, tilted by 30 to 45 degrees
/// in different directions, in every part of the picture. Focus and zoom must be those of the drives. Pictures that show no
/// whole board, or fit far worse than the others, are named and left out; pictures that do not fix the lens are refused and
/// nothing is written. The mount is written level, at the height given: `calibrate mount` or `calibrate points` finds it.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "calibrate chessboard pictures/ --corners 9x6 --square-m 0.025 --height-m 1.4 --out rough.toml",
    "calibrate chessboard board_1.jpg board_2.jpg board_3.jpg --corners 7x5 --height-m 1.2 --json --out rough.toml"
))]
pub(crate) struct ChessboardArgs {
    /// Pictures of the board (.jpg, .png), or folders of them, all of one size.
    #[arg(value_name = "PICTURES", required = true)]
    pictures: Vec<PathBuf>,
    /// Inner corners of the board along either side, where four squares meet: one less than its squares; 3 to 64.
    #[arg(long, value_name = "COLUMNSxROWS")]
    corners: Corners,
    /// Side of a square, metres, 0.001 to 1: with it the boards' distances are known; the lens does not depend on it.
    #[arg(long, value_name = "S", value_parser = number(0.001, 1.0, "side of a square", "metres"))]
    square_m: Option<f64>,
    /// Height of the camera above the road, metres, 0.05 to 20, for the mount that is written; roughly is enough where
    /// `calibrate mount` follows.
    #[arg(long, value_name = "H", value_parser = number(0.05, 20.0, "height", "metres"))]
    height_m: f64,
    /// Calibration to write, camera.toml.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print the lens with its standard deviations, and what became of each picture, as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// A board's inner corners given as `COLUMNSxROWS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Corners(BoardSize);

impl FromStr for Corners {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |side: &str| side.parse().ok();
        let sides = text.split_once('x').and_then(|(columns, rows)| Some((side(columns)?, side(rows)?)));
        let (columns, rows) = sides.ok_or_else(|| {
            format!(
                "{text:?} is no number of corners; give COLUMNSxROWS, as in 9x6 for a board of 10 x 7 squares"
            )
        })?;
        BoardSize::new(columns, rows).map(Self).map_err(|cause| cause.to_string())
    }
}

const NOTHING_WRITTEN: &str = "the lens cannot be trusted and nothing was written";

/// Calibrates the lens.
pub(crate) fn chessboard(args: &ChessboardArgs) -> Result<()> {
    output_path::check_file(&args.out, FileKind::Camera, args.pictures.iter().map(PathBuf::as_path))?;
    let paths = paths_of(&args.pictures)?;
    output_path::check_kept_file(&args.out, paths.iter().map(PathBuf::as_path))?;
    let looked = look_at_all(&paths, args.corners.0);
    report::say_dropped(&looked);
    check_board(&looked, args.corners.0).context(NOTHING_WRITTEN)?;
    let sizes: Vec<_> =
        looked.iter().filter_map(|looked| Some((looked.name.as_str(), looked.size?))).collect();
    let (width, height) = common_size(&sizes).context(NOTHING_WRITTEN)?;
    report::say_other_sizes(&looked, (width, height));
    let boards: Vec<_> = looked.iter().filter_map(|looked| board(looked, args)).collect();
    let lens = calibrate_lens(&boards, width, height).context(NOTHING_WRITTEN)?;
    let no_camera = "no camera has the lens that was found; take more pictures with the board at the picture's edges and corners";
    let camera = lens.camera(width, height, Mount::level(args.height_m));
    let camera = camera.context(no_camera).context(NOTHING_WRITTEN)?;
    write_file(&args.out, camera_to_toml(&camera)?)?;
    let report = Report::new(&lens, &looked, (width, height), args.square_m);
    report.say();
    output::message(&format!(
        "camera in {}, on a level mount {} m high; `fingerpost calibrate mount` finds how it is mounted",
        args.out.display(),
        args.height_m
    ));
    if args.json { output::print_json(&report) } else { Ok(()) }
}

/// The board's corners as the picture shows them, in metres, or in squares where their side is not known.
fn board(looked: &Looked, args: &ChessboardArgs) -> Option<Vec<BoardPoint>> {
    let corners = looked.corners.as_ref().ok()?;
    Some(board_points(args.corners.0, args.square_m.unwrap_or(1.0), corners))
}
