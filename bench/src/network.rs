//! The road network that comes with the method: how long it looks at a frame of the footage, by instruction set, and whether all sets say the
//! same.

use anyhow::{Context, Result};
use fingerpost::road_surface::{Network, RoadDetector};
use fingerpost_vision::picture::Rect;
use fingerpost_vision::road_network::RoadNetwork;
use fingerpost_vision::simd::{CodePath, InstructionSet};

use crate::footage::Footage;
use crate::measure::{Contestant, Effort, side_by_side};
use crate::results::{Figure, Section, set_name};

/// Milliseconds a frame that are promised with AVX2 and more.
const PROMISED_MS: f64 = 2.0;

/// Compares the network's logits between the instruction sets, and times it with each in turns; a frame is brought to the network's size each
/// time.
pub fn network(effort: Effort, footage: &Footage, sets: &[InstructionSet]) -> Result<Section> {
    let frame = &footage.frames[0];
    let whole = Rect { x: 0, y: 0, width: frame.width(), height: frame.height() };
    let detector = Network::new()?;
    let network = detector.network().context("the detector \"network\" has no network")?;
    let mut section =
        Section::new("Network", "one thread; medians; from a frame of the footage to all logits");
    let mut plain = network.clone();
    CodePath::limit(InstructionSet::Portable);
    plain.see(frame, whole)?;
    let mut contestants = Vec::new();
    for &set in sets {
        let mut network = network.clone();
        CodePath::limit(set);
        network.see(frame, whole)?;
        section.figures.push(Figure {
            what: format!("logits unlike the portable ones, {}", set_name(set)),
            value: differing(&network, &plain) as f64,
            unit: "",
            promised_most: Some(0.0),
        });
        contestants.push(Contestant::with(set, &set_name(set), move || {
            // The same call was good a moment ago.
            let _ = network.see(frame, whole);
        }));
    }
    if effort.rounds == 0 {
        return Ok(section);
    }
    for (&set, measured) in sets.iter().zip(side_by_side(effort, &mut contestants)?) {
        section.figures.push(Figure {
            what: format!("road network, {}", measured.name),
            value: measured.median_ms,
            unit: "ms",
            promised_most: (set != InstructionSet::Portable).then_some(PROMISED_MS),
        });
    }
    Ok(section)
}

/// Logits of two networks that are not the same.
fn differing(one: &RoadNetwork, other: &RoadNetwork) -> usize {
    let of_output = |output: usize| {
        let (one, other) = (one.logits(output)?, other.logits(output)?);
        Some(one.as_slice().iter().zip(other.as_slice()).filter(|(one, other)| one != other).count())
    };
    (0..one.outputs()).filter_map(of_output).sum()
}
