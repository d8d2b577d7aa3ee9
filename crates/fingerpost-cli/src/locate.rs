//! `fingerpost locate`: where the vehicle is on the map, from a motion log.

mod against_truth;
mod motion_faults;
mod tracks;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost_eval::{evaluate_location, stage_time};
use fingerpost_format::{
    FixLine, FixStatus, GpsCount, GpsLine, LocationSummary, MotionFaults, MotionLogRow, PlaceLine, StageTime,
    parse_motion_log, parse_pose_log,
};
use fingerpost_io::{
    FIXES_FILE, FolderKind, JsonLinesFile, OutputFolder, read_text_within, write_private_file,
};
use fingerpost_locate::{Fix, GpsEvidence, Locator, MotionSample, RISK, Traffic};
use fingerpost_map::{LatLon, RoadGraph};
use fingerpost_record::fix_status;
use fingerpost_report::{LocatedDrive, LocatingInput, locating_html};

use self::against_truth::Truth;
use self::motion_faults::FaultWatch;
use self::tracks::Tracks;
use crate::arguments::InputLimit;
use crate::examples::examples;
use crate::gps_track::GpsTrack;
use crate::interrupt::Preparation;
use crate::{facts, inputs, output, output_path, simulate, start_check, version};

/// Find the vehicle on a map from its speed and yaw rate alone, without a start: every road either way is possible until bends,
/// turns and distances leave one place. Each fix has a radius that the vehicle is within but for a stated risk, and says whether it
/// is converged, ambiguous, coasting or lost.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "locate --map town.osm.pbf --motion motion.csv --out located",
    "locate --map town.osm.pbf --motion motion.csv --gps gps.gpx --truth poses.csv --out located"
))]
pub(crate) struct LocateArgs {
    /// OpenStreetMap data of the area, .osm (XML) or .osm.pbf.
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    #[command(flatten)]
    limit: InputLimit,
    /// Motion log, CSV with a header: t_s,speed_mps,yaw_rate_rps (seconds, metres a second, radians a second to the left).
    #[arg(long, value_name = "FILE")]
    motion: PathBuf,
    /// GPS positions with times (GPX, NMEA or gpsd's reports), the first one at the motion log's first row, unless the times are those of
    /// 1970-01-01, which are the log's own. They are believed as far
    /// as they agree with the roads driven: errors that keep for minutes, jumps and drifts are expected.
    #[arg(long, value_name = "FILE")]
    gps: Option<PathBuf>,
    /// True poses, CSV with a header: t_s,lat,lon,heading_rad (degrees; radians anticlockwise from east). Only used to measure the
    /// results.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// The side of the road that is driven on.
    #[arg(long, value_enum, default_value = "right")]
    traffic: simulate::Traffic,
    /// Seed of where on the roads the hypotheses start.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder to write fix.jsonl, summary.json, report.html and tracks for other programs into: a new or empty one, or one of an
    /// earlier `locate`, which is replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print what summary.json holds on standard output.
    #[arg(long)]
    json: bool,
}

/// Locates.
pub(crate) fn locate(args: &LocateArgs) -> Result<()> {
    let inputs = [Some(&args.map), Some(&args.motion), args.gps.as_ref(), args.truth.as_ref()];
    output_path::check_folder(
        &args.out,
        FolderKind::Location,
        inputs.into_iter().flatten().map(PathBuf::as_path),
    )?;
    let preparation = Preparation::listen()?;
    let graph = inputs::road_graph(&args.map, args.limit)?;
    let text = |path: &PathBuf| read_text_within(path, args.limit.bytes() as u64);
    let log = parse_motion_log(&text(&args.motion)?).with_context(|| args.motion.display().to_string())?;
    let mut faults = FaultWatch::of(&log);
    faults.say(&args.motion);
    let rows = log.rows;
    log::info!("{}: {} rows of motion", args.motion.display(), rows.len());
    let truth = match &args.truth {
        Some(path) => {
            let poses = parse_pose_log(&text(path)?).with_context(|| path.display().to_string())?;
            Some(Truth::of(&graph, poses).with_context(|| path.display().to_string())?)
        }
        None => None,
    };
    let mut gps = args.gps.as_deref().map(|path| GpsTrack::read(path, args.limit)).transpose()?;
    let positions: Vec<LatLon> = gps.iter().flat_map(GpsTrack::positions).collect();
    start_check::check_on_map(&graph, &positions)?;
    let interrupt = preparation.work_begins();
    let folder = OutputFolder::take(&args.out, FolderKind::Location)?;
    let mut fixes = JsonLinesFile::create(&folder.path().join(FIXES_FILE))?;
    let traffic = match args.traffic {
        simulate::Traffic::Right => Traffic::Right,
        simulate::Traffic::Left => Traffic::Left,
        simulate::Traffic::Centre => Traffic::Centre,
    };
    let mut locator = Locator::new(&graph, traffic, args.seed);
    let (mut tally, mut tracks, mut drive) = (Tally::default(), Tracks::default(), LocatedDrive::default());
    let mut rows_used = 0;
    for row in rows.iter().take_while(|_| !interrupt.wanted()) {
        rows_used += 1;
        let started = Instant::now();
        let fix = match locator.step(sample(row)) {
            Ok(Some(fix)) => fix,
            Ok(None) => continue,
            Err(error) => {
                faults.refuse(&error);
                continue;
            }
        };
        let unseen_s = faults.watch(row);
        // What GPS says in a row is part of the fix of the next.
        let at = gps.as_mut().and_then(|gps| gps.at_row(row.t_s, rows[0].t_s));
        let evidence = at.and_then(|at| locator.gps(graph.plane().map_from_wgs84(at)));
        tally.row_ms.push(started.elapsed().as_secs_f64() * 1e3);
        let line = line(&graph, &fix, unseen_s, evidence);
        fixes.append(&line)?;
        tally.add(&line, row.t_s - rows[0].t_s);
        tracks.add(&fix, &line);
        let pose = truth.as_ref().and_then(|truth| truth.at(fix.t_s));
        tally.samples.extend(pose.map(|pose| pose.beside(&fix, &line)));
        drive.add(&fix, pose.map(|pose| pose.place_m), || locator.rivals().collect());
    }
    drive.end(locator.rivals().collect());
    fixes.finish()?;
    tracks.write(&folder)?;
    let summary = LocationSummary {
        map_notices: facts::of_notices(&graph),
        ..tally.summary(rows_used, faults.faults(), truth.is_some())
    };
    write_private_file(
        &folder.path().join("summary.json"),
        format!("{:#}\n", serde_json::to_value(&summary)?),
    )?;
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let title = format!("{} on {}", name(&args.motion), name(&args.map));
    let page =
        locating_html(&LocatingInput { title: &title, graph: &graph, drive: &drive, summary: &summary });
    write_private_file(&folder.path().join("report.html"), page)?;
    if interrupt.wanted() {
        bail!("interrupted after {rows_used} rows; results so far are in {}", args.out.display());
    }
    if let Some(StageTime { median, p95 }) = summary.row_ms {
        log::info!("a row takes {median:.3} ms in the median, {p95:.3} ms at the 95th percentile");
    }
    log::info!("{} hypotheses at the most", summary.most_hypotheses);
    print_summary(&summary, args);
    if args.json { output::print_json(&summary) } else { Ok(()) }
}

fn sample(row: &MotionLogRow) -> MotionSample {
    MotionSample { t_s: row.t_s, speed_mps: row.speed_mps, yaw_rate_rps: row.yaw_rate_rps }
}

/// What is counted on the way.
#[derive(Debug, Default)]
struct Tally {
    statuses: BTreeMap<FixStatus, usize>,
    converged_s: Option<f64>,
    most_hypotheses: usize,
    gps: GpsCount,
    row_ms: Vec<f64>,
    samples: Vec<fingerpost_eval::FixSample>,
}

impl Tally {
    fn add(&mut self, line: &FixLine, since_start_s: f64) {
        *self.statuses.entry(line.status).or_default() += 1;
        if let Some(gps) = &line.gps {
            self.gps.places += 1;
            self.gps.not_believed += usize::from(!gps.believed);
        }
        self.most_hypotheses = self.most_hypotheses.max(line.hypotheses);
        if line.status == FixStatus::Converged {
            self.converged_s.get_or_insert(since_start_s);
        }
    }

    fn summary(self, rows: usize, motion: MotionFaults, with_truth: bool) -> LocationSummary {
        LocationSummary {
            written_by: format!("fingerpost {}", version::VERSION),
            rows,
            statuses: self.statuses,
            converged_s: self.converged_s,
            risk: RISK,
            most_hypotheses: self.most_hypotheses,
            motion,
            gps: (self.gps.places > 0).then_some(self.gps),
            map_notices: Vec::new(),
            row_ms: stage_time(self.row_ms),
            truth: with_truth.then(|| evaluate_location(&self.samples)),
        }
    }
}

fn line(graph: &RoadGraph, fix: &Fix, unseen_s: Option<f64>, gps: Option<GpsEvidence>) -> FixLine {
    let at = graph.plane().wgs84_from_map(fix.place_m);
    let covariance = fix.covariance_m2;
    FixLine {
        t_s: fix.t_s,
        status: fix_status(fix.status),
        lat: at.lat_deg,
        lon: at.lon_deg,
        heading_rad: fix.heading_rad,
        covariance_m2: [[covariance.m11, covariance.m12], [covariance.m21, covariance.m22]],
        bound_m: fix.level_m,
        risk: RISK,
        weight: fix.mass,
        off_map: fix.off_map,
        hypotheses: fix.hypotheses,
        unseen_s,
        gps: gps.map(|GpsEvidence { innovation_m, believed }| GpsLine { innovation_m, believed }),
        places: fix
            .rivals
            .iter()
            .map(|rival| {
                let at = graph.plane().wgs84_from_map(rival.place_m);
                PlaceLine {
                    lat: at.lat_deg,
                    lon: at.lon_deg,
                    heading_rad: rival.heading_rad,
                    weight: rival.weight,
                }
            })
            .collect(),
    }
}

fn print_summary(summary: &LocationSummary, args: &LocateArgs) {
    let count = |status: FixStatus| summary.statuses.get(&status).copied().unwrap_or_default();
    output::message(&format!(
        "{} rows: {} converged, {} ambiguous, {} coasting, {} lost",
        summary.rows,
        count(FixStatus::Converged),
        count(FixStatus::Ambiguous),
        count(FixStatus::Coasting),
        count(FixStatus::Lost)
    ));
    if let Some(scores) = &summary.truth {
        if let Some((driven_m, error_m)) = scores.converged_m.zip(scores.fix_error_m) {
            output::message(&format!(
                "against truth: converged after {driven_m:.0} m; error from then on: median {:.2} m, p95 {:.2} m, largest {:.2} m",
                error_m.p50, error_m.p95, error_m.max
            ));
        }
        if let Some(bound_m) = scores.bound_m {
            output::message(&format!(
                "protection level: median {:.1} m, {} rows outside it",
                bound_m.p50, scores.bound_violations
            ));
        }
    }
    output::message(&format!(
        "results in {}; look at {}",
        args.out.display(),
        args.out.join("report.html").display()
    ));
}
