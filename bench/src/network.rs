//! The road network that comes with the method: how long it looks at a frame of the footage, by instruction set.

use anyhow::Result;
use fingerpost::road_surface::NETWORK_WEIGHTS;
use fingerpost_vision::picture::Rect;
use fingerpost_vision::road_network::RoadNetwork;
use fingerpost_vision::simd::{CodePath, InstructionSet};

use crate::footage::Footage;
use crate::measure::{Contestant, Effort, side_by_side};
use crate::results::{Bound, Figure, Section, set_name};

/// Milliseconds a frame that are promised with AVX2 and more.
const PROMISED_MS: f64 = 2.0;

/// Times the network with every instruction set in turns; a frame is brought to the network's size each time.
pub fn network(effort: Effort, footage: &Footage, sets: &[InstructionSet]) -> Result<Section> {
    let frame = &footage.frames[0];
    let whole = Rect { x: 0, y: 0, width: frame.width(), height: frame.height() };
    let network = RoadNetwork::from_bytes(NETWORK_WEIGHTS)?;
    let mut contestants = Vec::new();
    for &set in sets {
        let mut network = network.clone();
        CodePath::limit(set);
        network.see(frame, whole)?;
        contestants.push(Contestant::with(set, &set_name(set), move || {
            // The same call was good a moment ago.
            let _ = network.see(frame, whole);
        }));
    }
    let mut section =
        Section::new("Network", "one thread; medians; from a frame of the footage to all logits");
    for (&set, measured) in sets.iter().zip(side_by_side(effort, &mut contestants)?) {
        section.figures.push(Figure {
            what: format!("road network, {}", measured.name),
            value: measured.median_ms,
            unit: "ms",
            promised: (set != InstructionSet::Portable).then_some(Bound::AtMost(PROMISED_MS)),
        });
    }
    Ok(section)
}
