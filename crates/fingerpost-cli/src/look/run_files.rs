//! The files of a finished run.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use fingerpost_format::{FrameRecord, Summary};
use fingerpost_io::{LineFile, read_text};
use fingerpost_look::{Overview, Records};
use fingerpost_map::LatLon;
use fingerpost_server::Cause;

use super::folder_name;

/// What a run left.
#[derive(Debug)]
pub(super) struct RunFiles {
    /// Name of its folder.
    pub(super) title: String,
    pub(super) overview: Overview,
    pub(super) records: RecordFile,
    /// Where each frame has the vehicle on the map.
    pub(super) fixes: Vec<Option<LatLon>>,
    /// None of a run that was killed.
    pub(super) summary: Option<Summary>,
    /// Its settings.
    pub(super) config_toml: Option<String>,
}

impl RunFiles {
    /// Reads a run folder; of its records only curves and events are kept.
    pub(super) fn open(run: &Path) -> Result<Self> {
        let path = run.join("frames.jsonl");
        let file = LineFile::open(&path)?;
        let mut overview = Overview::default();
        let mut fixes = Vec::with_capacity(file.lines());
        for index in 0..file.lines() {
            let line = file.line(index)?.unwrap_or_default();
            let record: FrameRecord = serde_json::from_slice(&line)
                .with_context(|| format!("{}, line {}", path.display(), index + 1))?;
            overview.add(&record);
            fixes.push(record.fix.and_then(|fix| LatLon::new(fix.lat, fix.lon).ok()));
        }
        overview.finish();
        if file.lines() == 0 {
            bail!("{} holds no frame; name a folder that `fingerpost run` has written", path.display());
        }
        let optional = |name: &str| {
            let path = run.join(name);
            path.exists().then(|| read_text(&path)).transpose()
        };
        let summary = optional("summary.json")?.map(|text| serde_json::from_str(&text));
        Ok(Self {
            title: folder_name(run),
            overview,
            records: RecordFile(Arc::new(file)),
            fixes,
            summary: summary.transpose().with_context(|| run.join("summary.json").display().to_string())?,
            config_toml: optional("config.toml")?,
        })
    }
}

/// `frames.jsonl`.
#[derive(Debug, Clone)]
pub(super) struct RecordFile(Arc<LineFile>);

impl RecordFile {
    /// The line of an index from zero.
    pub(super) fn bytes(&self, index: usize) -> Result<Vec<u8>> {
        self.0.line(index)?.context("the run has no such frame")
    }
}

impl Records for RecordFile {
    fn line(&self, index: usize) -> Result<Vec<u8>, Cause> {
        Ok(self.bytes(index)?)
    }
}
