//! The run folder while a run goes on: every frame's record as it comes, and summary and report at the end, however it
//! ends.

use std::collections::BTreeMap;
use std::fs::File;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use fingerpost::motion::MEASURED_QUALITY;
use fingerpost_eval::{DriveTotals, FeatureIdentity, FeatureOutcomes, evaluate_junctions};
use fingerpost_format::{
    CameraRecordState, FrameRecord, MountFaultRecord, SamplingRecord, Summary, TrackState, TruthRecord,
    TruthSummary, json_lines,
};
use fingerpost_io::{FfmpegPrograms, RunFolder, VideoWriter};
use fingerpost_map::{RoadGraph, Route};
use fingerpost_record::live::{LiveView, Origin};
use fingerpost_record::recording::{MessageEncoder, RecordedFrame, Recording};
use fingerpost_record::{FrameTime, broken_record, motion_doubt};
use fingerpost_report::{
    COMPOSED_HEIGHT_PX, COMPOSED_WIDTH_PX, KeyFrames, ReportInput, Thresholds, Timeline, report_html,
};
use indicatif::ProgressBar;

use crate::arguments::FrameRange;
use crate::driver::{FrameResult, Seen};
use crate::stage_clock::{FrameClock, StageTimes};
use crate::version::VERSION;
use crate::{facts, output};

/// How a run came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RunEnd {
    /// Its input, or the wanted number of frames, was at its end.
    Complete,
    /// Something or somebody ended it before.
    Interrupted,
}

/// Which annotated frames are written as pictures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Pictures {
    /// None.
    None,
    /// Some frames in a row.
    Frames(FrameRange),
    /// Every n-th frame.
    Every(u64),
}

impl Pictures {
    pub(crate) fn want(&self, frame: u64) -> bool {
        match self {
            Self::None => false,
            Self::Frames(FrameRange(frames)) => frames.contains(&frame),
            Self::Every(nth) => frame.is_multiple_of(*nth),
        }
    }
}

/// What is to be written beside the records.
#[derive(Debug)]
pub(crate) struct Wishes {
    /// Title of the report.
    pub(crate) title: String,
    /// Annotated frames as pictures.
    pub(crate) pictures: Pictures,
    /// The annotated video, where one is wanted.
    pub(crate) video: Option<VideoWish>,
    /// Whether all that was seen is recorded for viewers.
    pub(crate) recording: RecordingWish,
    /// Where viewers connect to while it runs, where they may.
    pub(crate) live: Option<LiveWish>,
}

impl Wishes {
    /// Nothing beside them.
    pub(crate) const fn records_alone() -> Self {
        Self {
            title: String::new(),
            pictures: Pictures::None,
            video: None,
            recording: RecordingWish::None,
            live: None,
        }
    }

    /// Whether anybody wants a frame as messages.
    pub(crate) fn messages(&self) -> bool {
        self.live.is_some() || self.recording == RecordingWish::Mcap
    }
}

/// Viewers that connect while it runs.
#[derive(Debug)]
pub(crate) struct LiveWish {
    /// The port that they connect to.
    pub(crate) port: u16,
    /// Sites whose pages may, beside those that always may.
    pub(crate) origins: Vec<Origin>,
}

/// Whether `run.mcap` is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RecordingWish {
    /// It is.
    Mcap,
    /// It is not.
    None,
}

/// A video that is wanted.
#[derive(Debug)]
pub(crate) struct VideoWish {
    /// Frames a second.
    pub(crate) fps: f64,
    /// What encodes it.
    pub(crate) programs: FfmpegPrograms,
}

/// What a run is about, as far as its results say.
#[derive(Debug)]
pub(crate) struct Subject {
    /// The effective configuration.
    pub(crate) config_toml: String,
    /// Texts of the rules that steer; none of controllers without rules.
    pub(crate) rules: Vec<String>,
    /// Thresholds in it.
    pub(crate) thresholds: Thresholds,
    /// The route.
    pub(crate) route: Option<Route>,
    /// The roads of the map that the vehicle is located on.
    pub(crate) roads: Option<RoadGraph>,
    /// What its features are called.
    pub(crate) features: Vec<FeatureIdentity>,
    /// Width and height of the input's pictures.
    pub(crate) picture_px: [u32; 2],
    /// What of the input is used, where that is not all of it.
    pub(crate) sampling: Option<SamplingRecord>,
    /// What it was made from, name and words, as the report says it.
    pub(crate) made_from: Vec<(&'static str, String)>,
    /// What was found before its first frame to contradict what, a sentence each.
    pub(crate) remarks: Vec<String>,
}

/// Writes the results of a run. What it keeps of a frame does not grow with their number.
#[derive(Debug)]
pub(crate) struct Recorder {
    folder: RunFolder,
    subject: Subject,
    wishes: Wishes,
    video: Option<VideoWriter>,
    recording: Option<Recording<File>>,
    live: Option<LiveView>,
    /// Makes what both of them send.
    encoder: MessageEncoder,
    key_frames: KeyFrames,
    timeline: Timeline,
    outcomes: FeatureOutcomes,
    totals: DriveTotals,
    mount_faults: Vec<MountFaultRecord>,
    camera_frames: BTreeMap<CameraRecordState, u64>,
    /// The frame before.
    last: Option<FrameRecord>,
    times: StageTimes,
    frames: u64,
    broken_frames: u64,
    damaged_frames: u64,
    dropped_frames: u64,
    lost_frames: u64,
    started: Instant,
    bar: ProgressBar,
}

impl Recorder {
    /// Begins with an empty run folder and writes the configuration. `bar` goes on with every frame.
    pub(crate) fn create(
        folder: RunFolder,
        subject: Subject,
        wishes: Wishes,
        bar: ProgressBar,
    ) -> Result<Self> {
        folder.write_config(&subject.config_toml)?;
        let size = (COMPOSED_WIDTH_PX, COMPOSED_HEIGHT_PX);
        let video = wishes.video.as_ref().map(|VideoWish { fps, programs }| {
            VideoWriter::create(&folder.video_path(), size, *fps, programs)
        });
        let video = video.transpose()?;
        let recording = match wishes.recording {
            RecordingWish::Mcap => {
                let written_by = format!("fingerpost {VERSION}");
                Some(Recording::create(folder.create_recording()?, &written_by, subject.route.as_ref())?)
            }
            RecordingWish::None => None,
        };
        let live = wishes.live.as_ref().map(|wish| begin_live(wish, subject.route.as_ref())).transpose()?;
        Ok(Self {
            folder,
            outcomes: FeatureOutcomes::new(&subject.features),
            subject,
            wishes,
            video,
            recording,
            live,
            encoder: MessageEncoder::default(),
            key_frames: KeyFrames::default(),
            timeline: Timeline::default(),
            totals: DriveTotals::new(MEASURED_QUALITY, |doubt| motion_doubt(doubt).to_string()),
            mount_faults: Vec::new(),
            camera_frames: BTreeMap::new(),
            last: None,
            times: StageTimes::default(),
            frames: 0,
            broken_frames: 0,
            damaged_frames: 0,
            dropped_frames: 0,
            lost_frames: 0,
            started: Instant::now(),
            bar,
        })
    }

    /// Frames recorded, broken ones with them.
    pub(crate) fn frames(&self) -> u64 {
        self.frames
    }

    /// Frames that could not be used.
    pub(crate) fn broken_frames(&self) -> u64 {
        self.broken_frames
    }

    /// Says how many frames were used although they are damaged.
    pub(crate) fn note_damaged(&mut self, frames: u64) {
        self.damaged_frames = frames;
    }

    /// Says how many frames of a live input were passed over because they came faster than they could be used.
    pub(crate) fn note_dropped(&mut self, frames: u64) {
        self.dropped_frames = frames;
    }

    /// Whether no frame could be used.
    pub(crate) fn nothing_used(&self) -> bool {
        self.broken_frames == self.frames
    }

    /// Adds a frame.
    pub(crate) fn add(&mut self, result: FrameResult) -> Result<()> {
        self.bar.inc(1);
        let FrameResult { time, outcome, stage_ms } = result;
        self.times.add(&stage_ms);
        match outcome {
            Ok(seen) => self.add_seen(time, seen),
            Err(error) => self.add_broken(time, error),
        }
    }

    fn add_seen(&mut self, time: FrameTime, seen: Seen) -> Result<()> {
        let mut clock = FrameClock::start();
        let Seen { record, key_frame, annotated, recorded } = seen;
        self.keep(record)?;
        self.send_to_viewers(recorded)?;
        if let Some(key_frame) = key_frame {
            self.key_frames.add(key_frame)?;
        }
        if let Some(annotated) = annotated {
            if self.wishes.pictures.want(time.frame) {
                self.folder.write_picture(time.frame, &annotated)?;
            }
            if let Some(video) = &mut self.video {
                video.write(&annotated)?;
            }
        }
        clock.finished("results");
        self.times.add(&clock.stage_ms);
        Ok(())
    }

    /// Reports a frame that could not be used.
    fn add_broken(&mut self, time: FrameTime, error: String) -> Result<()> {
        self.bar.suspend(|| output::message(&format!("frame {} is passed over: {error}", time.frame)));
        self.broken_frames += 1;
        let at_first = if self.subject.route.is_some() { TrackState::Searching } else { TrackState::NoRoute };
        let record = broken_record(time, self.last.as_ref(), at_first, error);
        self.keep(record)?;
        self.send_to_viewers(None)
    }

    /// Sends the newest record, with what else was seen in its frame, to the recording and to the viewers that are connected.
    fn send_to_viewers(&mut self, frame: Option<RecordedFrame>) -> Result<()> {
        let viewers = self.live.as_ref().filter(|live| live.has_viewers());
        let wanted = self.recording.is_some() || viewers.is_some();
        let Some(record) = self.last.as_ref().filter(|_| wanted) else { return Ok(()) };
        let messages = match frame {
            Some(frame) => self.encoder.frame(frame, record),
            None => self.encoder.record(record),
        };
        let messages = Arc::new(messages.with_context(|| format!("frame {}", record.frame))?);
        if let Some(recording) = &mut self.recording {
            recording.write(&messages).with_context(|| self.folder.recording_path().display().to_string())?;
        }
        if let Some(live) = viewers {
            live.send(&messages);
        }
        Ok(())
    }

    /// Keeps a record.
    fn keep(&mut self, record: FrameRecord) -> Result<()> {
        self.folder.append(&record)?;
        self.times.add(&record.stage_ms);
        log::debug!("frame {}: {:?}: {}", record.frame, record.state, record.why);
        self.frames += 1;
        self.lost_frames += u64::from(record.state == TrackState::Lost);
        self.timeline.add(&record, None);
        self.totals.add(&record);
        self.outcomes.add(&record);
        let camera = record.camera.map(|camera| camera.state);
        if let Some(state) = camera.filter(|state| *state != CameraRecordState::Clear) {
            *self.camera_frames.entry(state).or_default() += 1;
        }
        let fault = record.mount.as_ref().and_then(|mount| mount.fault.as_ref());
        if let Some(fault) = fault.filter(|fault| self.mount_faults.last() != Some(fault)) {
            // The moves of the camera, each once.
            self.mount_faults.push(fault.clone());
        }
        self.last = Some(record);
        Ok(())
    }

    /// Writes summary and report. A truth that does not fit is an error told after the results, which are good without
    /// it. `broke_off` says why the input ended before it should have.
    pub(crate) fn finish(
        mut self,
        end: RunEnd,
        broke_off: Option<String>,
        truth: Option<&[TruthRecord]>,
    ) -> Result<Summary> {
        let elapsed_s = self.started.elapsed().as_secs_f64();
        self.bar.finish_and_clear();
        let video = self.video.take().map_or(Ok(()), VideoWriter::finish);
        let recording = self.recording.take().map_or(Ok(()), |recording| recording.finish().map(drop));
        drop(self.live.take());
        let compared = truth.filter(|_| self.frames > 0).map(|truth| self.compare(truth)).transpose();
        let of_truth = compared.as_ref().ok().and_then(Option::as_ref);
        let features = self.outcomes.into_summaries();
        let summary = Summary {
            written_by: Some(format!("fingerpost {VERSION}")),
            drive: Some(self.totals.into_summary(&features, self.subject.remarks)),
            frames: self.frames,
            picture_px: Some(self.subject.picture_px),
            sampling: self.subject.sampling,
            map_notices: self.subject.roads.as_ref().map(facts::of_notices).unwrap_or_default(),
            broken_frames: self.broken_frames,
            damaged_frames: self.damaged_frames,
            dropped_frames: self.dropped_frames,
            // A tenth of a frame a second is all that repeats.
            fps: (10.0 * self.frames as f64 / elapsed_s.max(1e-9)).round() / 10.0,
            stage_ms: self.times.summary(),
            features,
            lost_frames: self.lost_frames,
            camera_frames: self.camera_frames,
            mount_faults: self.mount_faults,
            truth: of_truth.map(|(of_truth, _)| of_truth.clone()),
            interrupted: end == RunEnd::Interrupted,
            input_broke_off: broke_off,
        };
        self.folder.write_summary(&summary)?;
        let report = report_html(&ReportInput {
            title: &self.wishes.title,
            made_from: &self.subject.made_from,
            timeline: of_truth.map_or(&self.timeline, |(_, timeline)| timeline),
            summary: &summary,
            truth: truth.filter(|_| of_truth.is_some()),
            route: self.subject.route.as_ref(),
            roads: self.subject.roads.as_ref(),
            thresholds: self.subject.thresholds,
            rules: &self.subject.rules,
            config_toml: &self.subject.config_toml,
            key_frames: &self.key_frames,
        });
        self.folder.write_report(&report)?;
        self.folder.finish()?;
        log::info!("summary and report took {:.2} s", self.started.elapsed().as_secs_f64() - elapsed_s);
        compared?;
        video?;
        recording?;
        Ok(summary)
    }

    /// The run against truth, from what was written of it.
    fn compare(&self, truth: &[TruthRecord]) -> Result<(TruthSummary, Timeline)> {
        let path = self.folder.frames_path();
        let text = fingerpost_io::read_text(&path)?;
        let records: Result<Vec<FrameRecord>, _> =
            json_lines(&text).map(|record| record.map(essence)).collect();
        let records = records.with_context(|| path.display().to_string())?;
        let ids: Vec<i64> = self.subject.features.iter().map(|feature| feature.id).collect();
        let evaluation = evaluate_junctions(&records, truth, &ids)?;
        let timeline = Timeline::of(&records, Some(truth));
        Ok((evaluation.summary, timeline))
    }
}

/// Serves a drive along `route`, and says where.
fn begin_live(wish: &LiveWish, route: Option<&Route>) -> Result<LiveView> {
    let live = LiveView::begin(&format!("fingerpost {VERSION}"), wish.port, &wish.origins, route)?;
    output::message(&format!("viewers may connect to {}", live.address()));
    Ok(live)
}

/// What a comparison with truth and its page read of a record: a long run has many at once then.
fn essence(mut record: FrameRecord) -> FrameRecord {
    let departure = record.lanes.as_ref().and_then(|lanes| lanes.departure.as_ref());
    if record.state != TrackState::Lost && departure.is_none_or(|departure| departure.warning.is_none()) {
        // Sentences are listed for losses and departures alone.
        record.why = String::new();
    }
    if let Some(advice) = record.advice.as_mut().filter(|advice| advice.stop.is_none()) {
        // Sentences are listed for stops alone.
        advice.because = String::new();
    }
    if let Some(lanes) = &mut record.lanes {
        (lanes.left_px, lanes.right_px) = (Vec::new(), Vec::new());
    }
    if let Some(fix) = &mut record.fix {
        fix.measurements = Vec::new();
    }
    if let Some(sought) = &mut record.sought {
        sought.sub.clear();
    }
    if let Some(feature) = &mut record.feature {
        // The curves show P(F) and which arm it is that of.
        let weakest = feature.sub.values().copied().min_by(f64::total_cmp);
        feature.sub.retain(|_, p| weakest.is_some_and(|weakest| p.total_cmp(&weakest).is_eq()));
    }
    FrameRecord {
        signals: None,
        surface: None,
        driving_line_m: Vec::new(),
        driving_line_curvature_per_m: Vec::new(),
        stage_ms: BTreeMap::new(),
        ..record
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_format::{DepartureRecord, LanesRecord, Side};

    use super::*;

    #[test]
    fn what_is_kept_of_a_frame_is_small_and_tells_departures() {
        let kept = |warning| {
            let lanes = LanesRecord {
                left_px: vec![[1.0, 2.0]; 40],
                width_m: Some(3.4),
                departure: Some(DepartureRecord { warning, ..DepartureRecord::default() }),
                ..LanesRecord::default()
            };
            let time = FrameTime { frame: 3, t_s: 0.3 };
            let record = broken_record(time, None, TrackState::NoRoute, String::new());
            essence(FrameRecord { lanes: Some(lanes), ..record })
        };
        let (quiet, warned) = (kept(None), kept(Some(Side::Left)));
        assert!(quiet.why.is_empty() && !warned.why.is_empty());
        let lanes = quiet.lanes.unwrap_or_default();
        assert!(lanes.left_px.is_empty() && lanes.width_m.is_some() && lanes.departure.is_some());
    }
}
