//! The frames that everything is measured on: a recording, or else a simulated drive.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_io::{FfmpegPrograms, FrameSource, SourceOptions, VideoWriter};
use fingerpost_map::{OsmData, RoadGraph, Route, read_route};
use fingerpost_sim::{SimConfig, Simulator};
use fingerpost_vision::picture::RgbImage;

/// Width of the simulated recording, pixels: that of the peer's.
const WIDTH_PX: usize = 960;
/// Height of it, pixels.
const HEIGHT_PX: usize = 540;
/// Frames that are kept in memory, a second of driving: each is used once before any comes again.
const KEPT_FRAMES: usize = 25;
/// Length of the simulated recording, frames; longer ones are made of it by repetition.
const SIMULATED_FRAMES: usize = 200;

/// Where frames come from.
#[derive(Debug)]
pub struct Footage {
    /// A video file.
    pub video: PathBuf,
    /// Calibration for `video`, as far as the program's own stages need one.
    pub camera: Camera,
    /// The first frames of it.
    pub frames: Vec<RgbImage>,
    /// What it is.
    pub description: String,
    /// Holds the simulated video.
    _folder: Option<tempfile::TempDir>,
}

impl Footage {
    /// Reads `recording`, or simulates a drive through the demo's town.
    pub fn open(recording: Option<&Path>) -> Result<Self> {
        match recording {
            Some(path) => Self::recorded(path),
            None => Self::simulated(),
        }
    }

    /// Width and height of the frames, pixels.
    pub fn size(&self) -> (usize, usize) {
        self.frames[0].size()
    }

    fn recorded(path: &Path) -> Result<Self> {
        let frames = first_frames(path)?;
        let (width, height) = frames[0].size();
        let description = format!("{}, {width} x {height}", path.display());
        Ok(Self {
            video: path.to_owned(),
            camera: dashcam(width, height)?,
            frames,
            description,
            _folder: None,
        })
    }

    fn simulated() -> Result<Self> {
        let (graph, route) = town()?;
        let camera = dashcam(WIDTH_PX, HEIGHT_PX)?;
        let config = SimConfig::default();
        let simulator = Simulator::new(&graph, &route, &camera, &config)?;
        let folder = tempfile::tempdir()?;
        let video = folder.path().join("simulated.mp4");
        let programs = FfmpegPrograms::default();
        let mut writer = VideoWriter::create(&video, (WIDTH_PX, HEIGHT_PX), config.fps, &programs)?;
        for index in 0..SIMULATED_FRAMES.min(simulator.frames()) {
            writer.write(&simulator.frame(index).picture)?;
        }
        writer.finish()?;
        let frames = first_frames(&video)?;
        let description = format!("simulated drive through the demo's town, {WIDTH_PX} x {HEIGHT_PX}, H.264");
        Ok(Self { video, camera, frames, description, _folder: Some(folder) })
    }
}

/// The roads of the demo's town and the route through it.
pub fn town() -> Result<(RoadGraph, Route)> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/fingerpost-sim/assets");
    let read = |name: &str| std::fs::read(assets.join(name)).with_context(|| format!("{name} of the demo"));
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(&read("town.osm")?)?)?;
    let route = read_route(&String::from_utf8(read("town_route.geojson")?)?)?;
    Ok((graph, route))
}

fn first_frames(video: &Path) -> Result<Vec<RgbImage>> {
    let input = video.to_str().context("the video's path is not UTF-8")?;
    let source = FrameSource::open(input, &SourceOptions::default())?;
    let frames: Vec<RgbImage> =
        source.take(KEPT_FRAMES).map(|frame| frame.picture).collect::<Result<_, _>>()?;
    ensure!(frames.len() == KEPT_FRAMES, "{input} holds fewer than {KEPT_FRAMES} frames");
    Ok(frames)
}

/// A camera like those behind windscreens: 1.5 m up, 8 degrees nose down, 75 degrees wide.
pub fn dashcam(width: usize, height: usize) -> Result<Camera> {
    let (w, h) = (width as f64, height as f64);
    let focal_px = 0.656 * w;
    let intrinsics = Intrinsics { fx: focal_px, fy: focal_px, cx: 0.5 * (w - 1.0), cy: 0.5 * (h - 1.0) };
    let mount = Mount { pitch_rad: 8_f64.to_radians(), x_m: 1.5, ..Mount::level(1.5) };
    Ok(Camera::calibrated(width, height, intrinsics, Distortion::None, mount)?)
}
