//! One drive of a campaign: drawn, simulated, run and evaluated in memory.

use std::path::PathBuf;

use anyhow::{Error, Result};
use fingerpost::Sensors;
use fingerpost_eval::{DriveClaims, RoadEdgeScores, evaluate_junctions, feature_summaries, first_detections};
use fingerpost_format::{CampaignDrive, FrameRecord, TrackState, TruthRecord};
use fingerpost_io::{JsonLinesFile, RunFolder, write_private_file};
use fingerpost_map::{Route, write_route};
use fingerpost_record::{FrameTime, broken_record};
use fingerpost_report::Scene;
use indicatif::ProgressBar;

use super::road_edges::TrueEdges;
use super::{Plan, Setting};
use crate::driver::{Driver, FrameResult, RunSetting, Sequence};
use crate::output;
use crate::recorder::{Pictures, Recorder, RecordingWish, RunEnd, Wishes};

/// Every so many frames of a drive with a report one is written with all that was seen in it: one a second.
const PICTURE_EVERY_FRAMES: u64 = 10;

/// A drive in numbers, and what it claimed.
pub(crate) type Driven = (CampaignDrive, DriveClaims);

/// The drive of a seed; none when it was interrupted.
pub(super) fn drive(setting: &Setting<'_>, seed: u64, conditions: &str) -> Option<Driven> {
    let named = CampaignDrive { seed, conditions: conditions.to_owned(), ..CampaignDrive::default() };
    let failed = |error: &Error| {
        let error = Some(output::cause_chain(error));
        Some((CampaignDrive { error, ..named.clone() }, DriveClaims::default()))
    };
    try_drive(setting, &named).unwrap_or_else(|error| failed(&error))
}

fn try_drive(setting: &Setting<'_>, named: &CampaignDrive) -> Result<Option<Driven>> {
    let plan = Plan::new(&setting.drawing, named.seed, &named.conditions)?;
    let mut run = Run::start(setting, named, &plan)?;
    for index in 0..plan.simulator.frames() {
        if setting.interrupt.wanted() {
            return Ok(None);
        }
        let frame = plan.simulator.frame(index);
        let time = FrameTime { frame: index as u64, t_s: index as f64 / plan.fps };
        let edges = TrueEdges::new(&plan.simulator, index, &frame);
        let scores = &mut run.road_edges;
        let mut measure = |scene: &Scene<'_>| edges.measure(scene, scores);
        let result = run.driver.step_showing(time, &frame.picture, Sensors::default(), &mut measure)?;
        run.truth.push(frame.truth);
        run.take(time, result)?;
    }
    run.finish(named, &plan.route).map(Some)
}

/// The method on a drive.
struct Run {
    driver: Driver,
    /// Where a report is wanted.
    recorder: Option<Recorder>,
    /// The folder that it goes to.
    folder: PathBuf,
    records: Vec<FrameRecord>,
    truth: Vec<TruthRecord>,
    road_edges: RoadEdgeScores,
}

impl Run {
    fn start(setting: &Setting<'_>, named: &CampaignDrive, plan: &Plan) -> Result<Self> {
        let frames = plan.simulator.frames();
        let run_setting = RunSetting {
            config: &plan.config,
            camera: &plan.camera,
            route: Some(&plan.route),
            start_m: Some(plan.start_m),
            sequence: Sequence::Drive,
        };
        let name = format!("{}_{}", named.conditions, named.seed);
        let pictures =
            if setting.args.reports { Pictures::Every(PICTURE_EVERY_FRAMES) } else { Pictures::None };
        let wishes = Wishes {
            title: format!("Fingerpost campaign: {name}"),
            pictures,
            video: None,
            recording: RecordingWish::None,
            live: None,
        };
        let driver = Driver::new(run_setting, &wishes, Some(frames as u64))?;
        let folder = setting.args.out.join(name);
        let recorder = setting.args.reports.then(|| {
            let subject = driver.subject(run_setting)?;
            Recorder::create(RunFolder::create_in_campaign(&folder)?, subject, wishes, ProgressBar::hidden())
        });
        let recorder = recorder.transpose()?;
        Ok(Self {
            driver,
            recorder,
            folder,
            records: Vec::with_capacity(frames),
            truth: Vec::with_capacity(frames),
            road_edges: RoadEdgeScores::default(),
        })
    }

    fn take(&mut self, time: FrameTime, result: FrameResult) -> Result<()> {
        let record = match &result.outcome {
            Ok(seen) => seen.record.clone(),
            Err(error) => broken_record(time, self.records.last(), TrackState::Searching, error.clone()),
        };
        self.records.push(record);
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.add(result))
    }

    fn finish(self, named: &CampaignDrive, route: &Route) -> Result<Driven> {
        let Self { driver, recorder, folder, records, truth, road_edges } = self;
        if let Some(recorder) = recorder {
            recorder.finish(RunEnd::Complete, None, Some(&truth))?;
            write_private_file(&folder.join("route.geojson"), write_route(route)?)?;
            let mut lines = JsonLinesFile::create(&folder.join("truth.jsonl"))?;
            truth.iter().try_for_each(|truth| lines.append(truth))?;
            lines.finish()?;
        }
        let (drive, claims) = measure(named, &records, &truth, route, &driver)?;
        let drive = CampaignDrive { road_edges: road_edges.summary(), ..drive };
        Ok((drive, DriveClaims { road_edges, ..claims }))
    }
}

/// What became of a drive along `route`.
pub(crate) fn measure(
    named: &CampaignDrive,
    records: &[FrameRecord],
    truth: &[TruthRecord],
    route: &Route,
    driver: &Driver,
) -> Result<Driven> {
    let ids: Vec<i64> = route.features.iter().map(|feature| feature.id).collect();
    let evaluation = evaluate_junctions(records, truth, &ids)?;
    let places: Vec<(i64, f64)> =
        route.features.iter().map(|feature| (feature.id, feature.route_m)).collect();
    let first_detections = first_detections(records, truth, &places)?;
    let is_lost = |record: &FrameRecord| record.state == TrackState::Lost;
    let losses = records.windows(2).filter(|pair| !is_lost(&pair[0]) && is_lost(&pair[1])).count();
    let drive = CampaignDrive {
        route_m: route.polyline()?.length_m(),
        frames: records.len() as u64,
        losses: losses as u64,
        truth: evaluation.summary,
        features: feature_summaries(records, driver.features()),
        ..named.clone()
    };
    Ok((drive, DriveClaims { claims: evaluation.claims, first_detections, ..DriveClaims::default() }))
}
