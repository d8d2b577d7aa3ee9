//! `fingerpost evaluate road`: road detectors on camera pictures, against labels or to be looked at.

mod labels;
mod pictures;
mod sheet;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, bail};
use clap::{ArgGroup, Args};
use fingerpost::Config;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::road_surface::{
    Perspective, RoadDetector, RoadInput, RoadMethod, RoadSurface, RoadSurfaceConfig,
};
use fingerpost_eval::{RoadEvaluation, RoadLabels, RoadScores, stage_time};
use fingerpost_io::{picture_paths, read_picture};
use fingerpost_vision::picture::{Plane, RgbImage};
use serde::Serialize;

use self::labels::{labels_of, read_labels};
use self::pictures::{GroundViews, Pictures};
use self::sheet::{on_sheet, sheet};
use crate::arguments::DetectorName;
use crate::examples::examples;
use crate::output_path::FileKind;
use crate::parts::road_detector;
use crate::stage_clock::milliseconds;
use crate::{inputs, output, output_path};

/// Road detectors on camera pictures: how well they tell labelled road, at what cost; or a sheet to look at.
///
/// Detectors see the pictures in the order of their names, as the frames of one drive. One threshold is chosen for the
/// whole set. The road is assumed to be seen in the bottom middle of the picture, 0.35 to 0.65 of its width and 0.72 to
/// 0.95 of its height. The time of a frame is the median, with greys and histogram bins but without decoding.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("wanted").required(true).multiple(true)))]
#[command(before_long_help = examples!(
    "evaluate road --images pictures --labels labels --road 1 --void 255",
    "evaluate road --images pictures --sheet sheet.png --ground-view camera.toml"
))]
pub(crate) struct RoadArgs {
    /// Folder of camera pictures.
    #[arg(long, value_name = "DIR")]
    images: PathBuf,
    /// Folder of label pictures, grey, with the pictures' names and sizes; a pixel's value is its label.
    #[arg(long, value_name = "DIR", group = "wanted", requires = "road")]
    labels: Option<PathBuf>,
    /// Label of road.
    #[arg(long, value_name = "ID", requires = "labels")]
    road: Option<u8>,
    /// Label of pixels that count for nothing.
    #[arg(long, value_name = "ID", requires = "labels")]
    void: Option<u8>,
    /// Evaluate this detector alone, not all of them ("onnx" is among all only where --config names a network).
    #[arg(long, value_name = "NAME")]
    detector: Option<DetectorName>,
    /// Rows above this share of the height show no road and do not count.
    #[arg(long, value_name = "FRACTION", default_value = "0.3333333333", value_parser = share)]
    from_row: f64,
    /// The pictures are no drive: detectors forget what they learned before each of them.
    #[arg(long)]
    stills: bool,
    /// Configuration, of which the detectors' settings are used; every key is optional.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Write a contact sheet (PNG): some of the pictures with labelled road outlined, and each detector's surface beside.
    #[arg(long, value_name = "FILE", group = "wanted")]
    sheet: Option<PathBuf>,
    /// Show on the sheet the ground view of each picture as well, through this camera; "assumed" stands for one of 60
    /// degrees, 1.4 m above a level road, with the horizon at --from-row.
    #[arg(long, value_name = "FILE|assumed", requires = "sheet")]
    ground_view: Option<PathBuf>,
    /// Print the numbers as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// All numbers of an evaluation.
#[derive(Debug, Serialize)]
struct RoadNumbers {
    frames: usize,
    from_row: f64,
    detectors: Vec<DetectorNumbers>,
}

/// One detector's numbers.
#[derive(Debug, Serialize)]
struct DetectorNumbers {
    detector: &'static str,
    #[serde(flatten)]
    evaluation: Option<RoadEvaluation>,
    ms_per_frame: f64,
}

/// A detector with what has come of it so far.
struct Contestant {
    method: RoadMethod,
    detector: Box<dyn RoadDetector>,
    scores: Option<RoadScores>,
    times_ms: Vec<f64>,
    surface: RoadSurface,
    kept: Vec<Plane<u8>>,
}

/// A picture that is to be on the sheet.
struct Kept {
    caption: String,
    picture: RgbImage,
    labelled: Option<Plane<u8>>,
}

/// Evaluates.
pub(super) fn road(args: &RoadArgs) -> Result<()> {
    if let Some(sheet) = &args.sheet {
        let optional = [&args.labels, &args.config, &args.ground_view].into_iter().flatten();
        output_path::check_file(
            sheet,
            FileKind::Sheet,
            optional.chain([&args.images]).map(PathBuf::as_path),
        )?;
    }
    let config = inputs::config(args.config.as_deref())?;
    let pictures = picture_paths(&args.images)?;
    let labels = args.labels.as_deref().map(|folder| labels_of(&pictures, folder)).transpose()?;
    let ids = args.road.map(|road| RoadLabels { road, void: args.void });
    let mut contestants = contestants(&config, args.detector, ids)?;
    let mut drive = Pictures::new(&config, args.from_row)?;
    let mut ground_views = ground_views(args, &config)?;
    let mut kept = Vec::new();
    let bar = output::progress(Some(pictures.len() as u64), "pictures");
    for (index, path) in pictures.iter().enumerate() {
        let label =
            labels.as_ref().and_then(|labels| labels.get(index)).map(|path| read_labels(path)).transpose()?;
        let common_ms = drive.take(read_picture(path)?)?;
        if let Some(label) = label.as_ref().filter(|label| label.size() != drive.picture.colour.size()) {
            let ((width, height), (label_width, label_height)) = (drive.picture.colour.size(), label.size());
            bail!(
                "{} has {width} x {height} pixels and its labels have {label_width} x {label_height}; give labels of \
                 the picture's size",
                path.display()
            );
        }
        let on_sheet = args.sheet.is_some() && on_sheet(index, pictures.len());
        for contestant in &mut contestants {
            if args.stills {
                contestant.detector.reset();
            }
            contestant.look(&drive, common_ms)?;
            if let Some(label) = &label {
                contestant.score(label, drive.first_row)?;
            }
            if on_sheet {
                contestant.kept.push(contestant.surface.probability.clone());
            }
        }
        if on_sheet {
            let labelled = label.zip(ids).map(|(mut label, ids)| {
                label.as_mut_slice().iter_mut().for_each(|label| *label = u8::from(*label == ids.road));
                label
            });
            kept.push(Kept { caption: file_name(path), picture: drive.picture.colour.clone(), labelled });
        }
        if let Some(views) = &mut ground_views
            && on_sheet
        {
            let (ground, view) = views.take(&drive.picture.colour)?;
            for contestant in &mut contestants {
                contestant.look_at_ground(&config, view, &ground, &drive.picture.colour)?;
            }
            let caption = format!("{}, ground view", file_name(path));
            kept.push(Kept { caption, picture: ground.colour, labelled: None });
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let numbers = RoadNumbers {
        frames: pictures.len(),
        from_row: args.from_row,
        detectors: contestants.iter().map(Contestant::numbers).collect::<Result<_>>()?,
    };
    print_table(&numbers);
    if let Some(path) = &args.sheet {
        fingerpost_io::write_signed_png(path, &sheet(&kept, &contestants, &numbers))?;
        output::message(&format!("the sheet is {}", path.display()));
    }
    if args.json { output::print_json(&numbers) } else { Ok(()) }
}

/// The ground views that are asked for.
fn ground_views(args: &RoadArgs, config: &Config) -> Result<Option<GroundViews>> {
    let Some(camera) = &args.ground_view else { return Ok(None) };
    let camera = if camera.as_os_str() == "assumed" { None } else { Some(inputs::camera(camera)?) };
    GroundViews::new(config, camera, args.from_row).map(Some)
}

fn contestants(
    config: &Config,
    only: Option<DetectorName>,
    ids: Option<RoadLabels>,
) -> Result<Vec<Contestant>> {
    let given = !config.road_surface.onnx.model.is_empty();
    let all = RoadMethod::ALL.into_iter();
    all.filter(|method| only.map_or(given || *method != RoadMethod::Onnx, |only| only.0 == *method))
        .map(|method| {
            let config = RoadSurfaceConfig { detector: method, ..config.road_surface.clone() };
            Ok(Contestant {
                method,
                detector: road_detector(&config)?,
                scores: ids.map(RoadScores::new),
                times_ms: Vec::new(),
                surface: RoadSurface::default(),
                kept: Vec::new(),
            })
        })
        .collect()
}

impl Contestant {
    /// Takes in the picture at hand, for which `common_ms` were spent before.
    fn look(&mut self, drive: &Pictures, common_ms: f64) -> Result<()> {
        let (width, height) = drive.picture.colour.size();
        let input = RoadInput {
            picture: &drive.picture,
            validity: &drive.validity,
            sample: RoadSurfaceConfig::sample_region_of_camera(width, height),
            perspective: Perspective::Camera { horizon_row: drive.first_row as f64 - 0.5 },
            motion: None,
        };
        let start = Instant::now();
        self.detector.detect(input, &mut self.surface)?;
        self.times_ms.push(common_ms + milliseconds(start.elapsed()));
        Ok(())
    }

    /// Finds the road in the ground view of a single picture, as in the first frame of a drive, for the sheet.
    fn look_at_ground(
        &mut self,
        config: &Config,
        view: &GroundView,
        ground: &GroundPicture,
        frame: &RgbImage,
    ) -> Result<()> {
        let config = RoadSurfaceConfig { detector: self.method, ..config.road_surface.clone() };
        let input = RoadInput {
            picture: ground,
            validity: view.validity(),
            sample: config.sample_region(view),
            perspective: Perspective::Ground { view, frame },
            motion: None,
        };
        let mut surface = RoadSurface::default();
        road_detector(&config)?.detect(input, &mut surface)?;
        self.kept.push(surface.probability);
        Ok(())
    }

    fn score(&mut self, labels: &Plane<u8>, first_row: usize) -> Result<()> {
        let Some(scores) = &mut self.scores else { return Ok(()) };
        let skipped = first_row * labels.width();
        Ok(scores.add(&self.surface.probability.as_slice()[skipped..], &labels.as_slice()[skipped..])?)
    }

    fn numbers(&self) -> Result<DetectorNumbers> {
        Ok(DetectorNumbers {
            detector: self.method.name(),
            evaluation: self.scores.as_ref().map(RoadScores::best).transpose()?,
            ms_per_frame: stage_time(self.times_ms.iter().copied()).map_or(0.0, |time| time.median),
        })
    }
}

fn print_table(numbers: &RoadNumbers) {
    output::message(&format!("{} pictures, rows from {:.3} of the height", numbers.frames, numbers.from_row));
    output::message("detector        MaxF   IoU    threshold  IoU at 0.5  ms a frame");
    for DetectorNumbers { detector, evaluation, ms_per_frame } in &numbers.detectors {
        let [max_f, iou, threshold, at_half] = match evaluation {
            Some(of) => [of.max_f, of.iou, of.threshold, of.iou_at_half].map(|number| format!("{number:.3}")),
            None => ["-"; 4].map(str::to_owned),
        };
        output::message(&format!(
            "{detector:<14}  {max_f:<5}  {iou:<5}  {threshold:<9}  {at_half:<10}  {ms_per_frame:.2}"
        ));
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// A share of the height that leaves rows to look at.
fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.0..0.95).contains(share));
    share.ok_or_else(|| format!("{text:?} is no share of the height; give 0 to below 0.95"))
}
