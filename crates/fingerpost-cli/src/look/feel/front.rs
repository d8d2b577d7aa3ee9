//! The front of a search of settings, whose points are taken over one by one.

use std::path::Path;

use anyhow::{Context, Result};
use fingerpost_format::{TuningFront, TuningObjective, TuningPoint, TuningScores};
use fingerpost_io::read_text;
use fingerpost_look::FoundPoint;

/// The points of the front that `tune` has written into a folder, those of the settings that it began with first.
pub(super) fn points(folder: &Path) -> Result<Vec<FoundPoint>> {
    let path = folder.join("front.json");
    let text = read_text(&path)?;
    let front: TuningFront = serde_json::from_str(&text).with_context(|| {
        format!("{} is no front of a search; name a folder of `fingerpost tune`", path.display())
    })?;
    let objectives: Vec<TuningObjective> =
        front.objectives.iter().copied().filter(|objective| *objective != TuningObjective::Ms).collect();
    let began = front.defaults.config.clone().unwrap_or_else(|| "what the search began with".to_owned());
    let named = front.front.into_iter().map(|point| (point.config.clone().unwrap_or_default(), point));
    let all = [(began, front.defaults)].into_iter().chain(named);
    Ok(all.map(|(name, point)| found(name, point, &objectives)).collect())
}

fn found(name: String, point: TuningPoint, objectives: &[TuningObjective]) -> FoundPoint {
    let words = |scores: &TuningScores| {
        let values = objectives.iter().map(|objective| {
            // Times stand in no front.
            let value =
                objective.of(scores, f64::NAN).map_or("–".to_owned(), |value| format!("{value:.2}"));
            format!("{} {value}", objective.name())
        });
        values.collect::<Vec<_>>().join(", ")
    };
    let searched = point.tuned.as_ref().map(words);
    let held_back = point.held_back.as_ref().map(|scores| format!("held back: {}", words(scores)));
    let results = [searched, held_back].into_iter().flatten().collect::<Vec<_>>().join("; ");
    FoundPoint { name, results, settings: point.settings }
}
