//! What a search is about: trials of one are not mixed with those of another.

use std::path::Path;

use anyhow::{Context, Result};
use fingerpost_io::{drive_digest, file_digest};
use serde_json::{Value, json};

use super::TuneArgs;
use super::keys::SearchedSettings;
use crate::version::VERSION;

/// All that trials depend on. The number of trials is not among it, so that a search can be made longer; nor that of threads.
pub(super) fn setup(args: &TuneArgs, settings: &SearchedSettings) -> Result<Value> {
    let absolute = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let drives = if args.drives.is_empty() {
        json!({
            "seeds_and_conditions": args.campaign_drives()?,
            "size": args.size.map(|size| [size.width, size.height]),
            "fps": args.fps,
            "map": args.map.as_deref().map(absolute),
            "map_digest": args.map.as_deref().map(file_digest).transpose()?,
        })
    } else {
        let folders: Vec<_> = args.drives.iter().map(|folder| absolute(folder)).collect();
        let digests: Vec<u32> =
            folders.iter().map(|folder| drive_digest(folder)).collect::<Result<_, _>>()?;
        json!({ "folders": folders, "digests": digests, "start_m": args.start_m })
    };
    Ok(json!({
        "program": VERSION,
        "drives": drives,
        "held_out": args.held_out,
        "settings": settings.base.to_json(),
        "keys": serde_json::to_value(&settings.keys).context("the keys cannot be written as JSON")?,
        "screen": args.screen,
        "objectives": args.objectives(),
        "population": args.population,
        "seed": args.seed,
    }))
}
