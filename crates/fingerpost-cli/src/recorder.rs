//! The run folder while a run goes on: every frame's record as it comes, and the summary at the end, however it ends.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use fingerpost::FrameOutput;
use fingerpost_eval::{FeatureIdentity, evaluate_junctions, feature_summaries};
use fingerpost_format::{FrameRecord, Summary, TrackState, TruthRecord};
use fingerpost_io::RunFolder;

use crate::record::{FrameTime, broken_record, frame_record};
use crate::stage_clock::StageTimes;

/// How a run came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RunEnd {
    /// Its input, or the wanted number of frames, was at its end.
    Complete,
    /// Something or somebody ended it before.
    Interrupted,
}

/// Writes the results of a run.
#[derive(Debug)]
pub(crate) struct Recorder {
    folder: RunFolder,
    features: Vec<FeatureIdentity>,
    records: Vec<FrameRecord>,
    times: StageTimes,
    broken_frames: u64,
    started: Instant,
}

impl Recorder {
    /// Makes the run folder, replacing earlier results in it, and writes the configuration.
    pub(crate) fn create(out: &Path, config_toml: &str, features: Vec<FeatureIdentity>) -> Result<Self> {
        let folder = RunFolder::create(out)?;
        folder.write_config(config_toml)?;
        Ok(Self {
            folder,
            features,
            records: Vec::new(),
            times: StageTimes::default(),
            broken_frames: 0,
            started: Instant::now(),
        })
    }

    /// Frames recorded, broken ones with them.
    pub(crate) fn frames(&self) -> usize {
        self.records.len()
    }

    /// Whether no frame could be used.
    pub(crate) fn nothing_used(&self) -> bool {
        self.broken_frames == self.records.len() as u64
    }

    /// Adds a frame that was processed.
    pub(crate) fn add(
        &mut self,
        time: FrameTime,
        output: &FrameOutput,
        stage_ms: &BTreeMap<String, f64>,
    ) -> Result<()> {
        self.keep(frame_record(time, output, &self.features, stage_ms))
    }

    /// Adds the times of work outside the method, milliseconds.
    pub(crate) fn add_times(&mut self, stage_ms: &BTreeMap<String, f64>) {
        self.times.add(stage_ms);
    }

    /// Adds a frame that could not be used.
    pub(crate) fn add_broken(&mut self, time: FrameTime, error: String) -> Result<()> {
        self.broken_frames += 1;
        let record = broken_record(time, self.records.last(), error);
        self.keep(record)
    }

    fn keep(&mut self, record: FrameRecord) -> Result<()> {
        self.folder.append(&record)?;
        self.times.add(&record.stage_ms);
        self.records.push(record);
        Ok(())
    }

    /// Writes the summary.
    pub(crate) fn finish(self, end: RunEnd, truth: Option<&[TruthRecord]>) -> Result<Summary> {
        let elapsed_s = self.started.elapsed().as_secs_f64();
        let ids: Vec<i64> = self.features.iter().map(|feature| feature.id).collect();
        let truth = truth
            .filter(|_| !self.records.is_empty())
            .map(|truth| evaluate_junctions(&self.records, truth, &ids));
        let summary = Summary {
            frames: self.records.len() as u64,
            broken_frames: self.broken_frames,
            // A tenth of a frame a second is all that repeats.
            fps: (10.0 * self.records.len() as f64 / elapsed_s.max(1e-9)).round() / 10.0,
            stage_ms: self.times.summary(),
            features: feature_summaries(&self.records, &self.features),
            lost_frames: self.records.iter().filter(|record| record.state == TrackState::Lost).count() as u64,
            truth: None,
            interrupted: end == RunEnd::Interrupted,
        };
        // A truth that does not fit is told after the results, which are good without it.
        let (truth, misfit) = match truth.transpose() {
            Ok(evaluation) => (evaluation.map(|evaluation| evaluation.summary), None),
            Err(misfit) => (None, Some(misfit)),
        };
        let summary = Summary { truth, ..summary };
        self.folder.write_summary(&summary)?;
        match misfit {
            Some(misfit) => Err(misfit.into()),
            None => Ok(summary),
        }
    }
}
