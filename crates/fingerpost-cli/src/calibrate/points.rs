//! `fingerpost calibrate points`: a camera from four picture points and their places on the road.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost_calibration::mount_from_points;
use fingerpost_format::{camera_to_toml, points_to_toml};
use fingerpost_geometry::{Camera, Pixel};
use fingerpost_io::{read_text, write_file};
use nalgebra::Point2;
use serde::Serialize;

use crate::arguments::PictureSize;
use crate::examples::examples;
use crate::output_path::FileKind;
use crate::{inputs, output, output_path};

/// Write a camera.toml from four points of the picture whose places on the road were measured (paper 1, section IV-A).
///
/// With --camera, whose lens is known, the mount is solved for, and the camera knows more than the road plane.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("lens").required(true)))]
#[command(before_long_help = examples!(
    "calibrate points --image-size 640x480 --points points.txt --out camera.toml",
    "calibrate points --camera rough.toml --points points.txt --out camera.toml"
))]
pub(crate) struct PointsArgs {
    /// Size of the pictures, pixels.
    #[arg(long, value_name = "WxH", group = "lens")]
    image_size: Option<PictureSize>,
    /// Calibration with the lens, whose mount is to be found.
    #[arg(long, value_name = "FILE", group = "lens")]
    camera: Option<PathBuf>,
    /// Four points, or a text file with one a line: U,V,FORWARD,LEFT, in pixels from the centre of the top-left one and metres
    /// from the rear axle's middle; separated by semicolons when given here, as in "285,374,8,1.5;466,374,8,-1.5;...".
    #[arg(long, value_name = "FILE|POINTS")]
    points: String,
    /// Calibration to write, camera.toml.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print the result as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report {
    image_px: [[f64; 2]; 4],
    road_m: [[f64; 2]; 4],
    /// The mount, where the lens is known.
    mount: Option<SolvedMount>,
}

#[derive(Debug, Serialize)]
struct SolvedMount {
    height_m: f64,
    pitch_deg: f64,
    yaw_deg: f64,
    roll_deg: f64,
    x_m: f64,
    y_m: f64,
    error_px: f64,
}

/// Calibrates by points.
pub(crate) fn points(args: &PointsArgs) -> Result<()> {
    let inputs = args.camera.as_deref().into_iter().chain([Path::new(&args.points)]);
    output_path::check_file(&args.out, FileKind::Camera, inputs)?;
    let (image, road_m) = four_points(&args.points)?;
    let camera = args.camera.as_deref().map(inputs::camera).transpose()?;
    let size = match (&camera, args.image_size) {
        (Some(camera), _) => (camera.width(), camera.height()),
        (None, Some(size)) => (size.width, size.height),
        (None, None) => bail!("give --image-size or --camera"),
    };
    check_inside(image, size)?;
    let (text, mount) = match &camera {
        None => (points_to_toml(size, image, road_m)?, None),
        Some(camera) => {
            let (solved, mount) = solve(camera, image, road_m)?;
            (camera_to_toml(&solved)?, Some(mount))
        }
    };
    write_file(&args.out, text)?;
    if let Some(mount) = &mount {
        output::message(&format!(
            "height {:.3} m, pitch {:.2}°, yaw {:.2}°, roll {:.2}°, {:.2} m ahead of the rear axle, {:.2} m left; the points \
             agree within {:.1} pixels",
            mount.height_m,
            mount.pitch_deg,
            mount.yaw_deg,
            mount.roll_deg,
            mount.x_m,
            mount.y_m,
            mount.error_px
        ));
    }
    output::message(&format!("camera in {}", args.out.display()));
    let report = Report {
        image_px: image.map(|pixel| [pixel.u, pixel.v]),
        road_m: road_m.map(|place| [place.x, place.y]),
        mount,
    };
    if args.json { output::print_json(&report) } else { Ok(()) }
}

fn solve(camera: &Camera, image: [Pixel; 4], road_m: [Point2<f64>; 4]) -> Result<(Camera, SolvedMount)> {
    let found = mount_from_points(camera, image, road_m).context("nothing was written")?;
    let mount = found.mount;
    let solved = SolvedMount {
        height_m: mount.height_m,
        pitch_deg: mount.pitch_rad.to_degrees(),
        yaw_deg: mount.yaw_rad.to_degrees(),
        roll_deg: mount.roll_rad.to_degrees(),
        x_m: mount.x_m,
        y_m: mount.y_m,
        error_px: found.error_px,
    };
    Ok((camera.with_mount(mount)?, solved))
}

fn check_inside(image: [Pixel; 4], (width, height): (usize, usize)) -> Result<()> {
    let inside = |pixel: &Pixel| {
        (-0.5..=width as f64 - 0.5).contains(&pixel.u) && (-0.5..=height as f64 - 0.5).contains(&pixel.v)
    };
    match image.iter().find(|pixel| !inside(pixel)) {
        None => Ok(()),
        Some(pixel) => bail!(
            "the point {},{} lies outside the picture of {width} x {height} pixels; check the picture's size and that the \
             points are U,V,FORWARD,LEFT",
            pixel.u,
            pixel.v
        ),
    }
}

/// The points of an argument or of the file that it names.
fn four_points(argument: &str) -> Result<([Pixel; 4], [Point2<f64>; 4])> {
    let path = Path::new(argument);
    let text = if path.exists() { read_text(path)? } else { argument.replace(';', "\n") };
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let form = "give four points U,V,FORWARD,LEFT, in pixels and metres, or a file with one a line";
    let numbers = lines
        .map(|line| {
            let numbers: Vec<f64> = line
                .split(',')
                .map(|number| number.trim().parse())
                .collect::<Result<_, _>>()
                .with_context(|| format!("{line:?} is no point; {form}"))?;
            <[f64; 4]>::try_from(numbers).map_err(|_| anyhow::anyhow!("{line:?} is no point; {form}"))
        })
        .collect::<Result<Vec<_>>>()?;
    let count = numbers.len();
    let Ok(points) = <[[f64; 4]; 4]>::try_from(numbers) else {
        bail!("{count} points were given; {form}");
    };
    Ok((points.map(|[u, v, _, _]| Pixel::new(u, v)), points.map(|[_, _, x, y]| Point2::new(x, y))))
}
