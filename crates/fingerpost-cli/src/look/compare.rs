//! Two runs of one drive held against each other.

use std::collections::BTreeMap;

use anyhow::{Result, bail};
use fingerpost::Config;
use fingerpost_format::FrameRecord;
use fingerpost_look::Differences;

use super::run_files::RunFiles;
use crate::changed_settings::differing;

/// What differs between the frames that both runs have, by their numbers in the input, and between their settings.
pub(super) fn differences(one: &RunFiles, other: &RunFiles) -> Result<Differences> {
    let of_other: BTreeMap<u64, usize> = other.overview.frames().iter().copied().zip(0..).collect();
    let mut differences = Differences::default();
    for (index, frame) in one.overview.frames().iter().enumerate() {
        let Some(&other_index) = of_other.get(frame) else { continue };
        let record = |run: &RunFiles, index| -> Result<FrameRecord> {
            Ok(serde_json::from_slice(&run.records.bytes(index)?)?)
        };
        let records = [record(one, index)?, record(other, other_index)?];
        differences.add([index, other_index], [&records[0], &records[1]]);
    }
    if differences.frames().is_empty() {
        bail!("{} and {} have no frame in common; give runs of one drive", one.title, other.title);
    }
    differences.finish();
    let settings = [one, other].map(|run| Config::from_toml(run.config_toml.as_deref()?).ok());
    if let [Some(one), Some(other)] = settings {
        differences.settings = differing(&one.to_json(), &other.to_json());
    }
    Ok(differences)
}
