//! One colour and one word for one meaning, in pictures and pages alike.
//!
//! The arms' hues are those of Okabe and Ito ("Color universal design", 2008), which people with any colour vision can
//! tell apart, lightened where they have to stand on dark asphalt.

use fingerpost::road_surface::{Knowledge, NetworkOutput};
use fingerpost::track::State;
use fingerpost_format::{FixStatus, TrackState};
use fingerpost_locate::Status;
use fingerpost_map::FeatureKind;

/// Red, green, blue.
pub type Rgb = [u8; 3];

pub(crate) const BACKGROUND: Rgb = [22, 25, 29];
pub(crate) const PANEL: Rgb = [33, 37, 43];
pub(crate) const UNSEEN: Rgb = [52, 56, 63];
pub(crate) const UNSEEN_HATCH: Rgb = [72, 77, 86];
pub(crate) const TEXT: Rgb = [232, 235, 239];
pub(crate) const TEXT_DIM: Rgb = [150, 157, 167];
pub(crate) const GRID_LINE: Rgb = [255, 255, 255];
pub(crate) const SHADE: Rgb = [0, 0, 0];

/// What was measured and used.
pub(crate) const ACCEPTED: Rgb = [86, 220, 233];
/// What was measured and rejected.
pub(crate) const REJECTED: Rgb = [255, 72, 72];
/// Where ego-motion expected the feature.
pub(crate) const PREDICTED: Rgb = [255, 255, 255];
/// Where the feature is believed after the frame.
pub(crate) const UPDATED: Rgb = [255, 221, 51];
/// The road's middle by the edges of its surface.
pub(crate) const CENTRELINE: Rgb = [255, 128, 32];
/// The region in front of the vehicle that is assumed to be road.
pub(crate) const SAMPLE: Rgb = [255, 255, 255];

/// An edge of the lane.
pub(crate) const LANE: Rgb = [190, 120, 255];

/// What the road network tells from other things, as it is drawn.
#[derive(Debug, Clone, Copy)]
pub struct NetworkClass {
    pub(crate) output: NetworkOutput,
    /// Its name as people say it.
    pub name: &'static str,
    /// Its colour.
    pub colour: Rgb,
}

/// What the network sees, what lies over the others last.
pub const NETWORK_CLASSES: [NetworkClass; 4] = [
    NetworkClass { output: NetworkOutput::Road, name: "road", colour: [40, 200, 90] },
    NetworkClass {
        output: NetworkOutput::Raised,
        name: "raised ground, as pavements",
        colour: [222, 90, 200],
    },
    NetworkClass { output: NetworkOutput::Hidden, name: "what hides the ground", colour: REJECTED },
    NetworkClass { output: NetworkOutput::Paint, name: "paint on the road", colour: [255, 255, 255] },
];

const DRIVING_LINE: Rgb = [124, 224, 84];
const APPROACH: Rgb = [86, 180, 233];
const EXIT: Rgb = [240, 159, 30];
const SIDES: [Rgb; 4] = [[222, 128, 190], [240, 228, 66], [0, 190, 150], [200, 170, 255]];

/// Colour of a sub-mask by its label: `approach`, `exit`, `driving_line`, `side_1`, `side_2`, ...
pub fn sub_mask(label: &str) -> Rgb {
    match label {
        "approach" => APPROACH,
        "exit" => EXIT,
        "driving_line" => DRIVING_LINE,
        side => {
            let number = side.rsplit('_').next().and_then(|n| n.parse::<usize>().ok()).unwrap_or(1);
            SIDES[number.saturating_sub(1) % SIDES.len()]
        }
    }
}

/// Colour of a numbered piece of a picture; neighbours by number differ, and all from [`REJECTED`].
pub(crate) const fn piece(number: u32) -> Rgb {
    const COLOURS: [Rgb; 6] = [APPROACH, SIDES[1], SIDES[0], DRIVING_LINE, SIDES[3], SIDES[2]];
    COLOURS[number as usize % COLOURS.len()]
}

/// Name and colour of a state.
pub(crate) const fn state(state: TrackState) -> (&'static str, Rgb) {
    match state {
        TrackState::NoRoute => ("no route", [130, 137, 147]),
        TrackState::Searching => ("searching", [104, 140, 196]),
        TrackState::Tracking => ("tracking", [62, 168, 92]),
        TrackState::Arrived => ("arrived", [214, 166, 24]),
        TrackState::Lost => ("lost", [214, 62, 62]),
        TrackState::RouteDone => ("route done", [150, 120, 190]),
    }
}

/// Name and colour of what a fix on the map is worth.
pub(crate) const fn fix_status(status: Status) -> (&'static str, Rgb) {
    match status {
        Status::Converged => ("converged", [62, 168, 92]),
        Status::Ambiguous => ("ambiguous", [104, 140, 196]),
        Status::Coasting => ("coasting", [214, 166, 24]),
        Status::Lost => ("lost", [214, 62, 62]),
    }
}

/// What a fix is worth, from the files.
pub(crate) const fn status(status: FixStatus) -> Status {
    match status {
        FixStatus::Converged => Status::Converged,
        FixStatus::Ambiguous => Status::Ambiguous,
        FixStatus::Coasting => Status::Coasting,
        FixStatus::Lost => Status::Lost,
    }
}

/// The state as files have it.
pub(crate) const fn recorded(state: State) -> TrackState {
    match state {
        State::NoRoute => TrackState::NoRoute,
        State::Searching => TrackState::Searching,
        State::Tracking => TrackState::Tracking,
        State::Arrived => TrackState::Arrived,
        State::Lost => TrackState::Lost,
        State::RouteDone => TrackState::RouteDone,
    }
}

/// Name of a kind of feature as people say it.
pub(crate) const fn kind(kind: FeatureKind) -> &'static str {
    match kind {
        FeatureKind::Junction => "junction",
        FeatureKind::SideRoad => "side road",
        FeatureKind::Bend => "bend",
    }
}

/// Colour of a road probability (255 = 1): dark blue over teal to bright yellow, its lightness rising all the way.
pub(crate) fn heat(probability: u8) -> Rgb {
    const STOPS: [Rgb; 5] = [[26, 16, 60], [54, 62, 130], [38, 128, 140], [96, 190, 98], [250, 230, 50]];
    let place = f64::from(probability) / 255.0 * (STOPS.len() - 1) as f64;
    let below = (place.floor() as usize).min(STOPS.len() - 2);
    mix(STOPS[below], STOPS[below + 1], place - below as f64)
}

/// Colour of a road probability that is remembered, not seen: dark to light violet, unlike any colour of [`heat`].
pub(crate) fn remembered(probability: u8) -> Rgb {
    mix([44, 26, 50], [214, 140, 240], f64::from(probability) / 255.0)
}

/// The colour of a road probability by what is known of it.
pub fn road_colour(probability: u8, knowledge: Knowledge) -> Rgb {
    match knowledge {
        Knowledge::Seen => heat(probability),
        Knowledge::Remembered => remembered(probability),
        Knowledge::Unknown => UNSEEN,
    }
}

/// Grey of a road probability, as the ground for coloured masks.
pub(crate) fn shade(probability: u8) -> Rgb {
    // Kept off black and white, so that both dark unseen areas and light labels stand out.
    [(30.0 + 0.62 * f64::from(probability)) as u8; 3]
}

/// `share` of `to` over `from`.
pub(crate) fn mix(from: Rgb, to: Rgb, share: f64) -> Rgb {
    let channel = |c: usize| {
        (f64::from(from[c]) + (f64::from(to[c]) - f64::from(from[c])) * share.clamp(0.0, 1.0)).round() as u8
    };
    [channel(0), channel(1), channel(2)]
}

/// A colour as CSS has it.
pub(crate) fn css([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sub_mask_has_its_own_colour() {
        let labels = ["approach", "exit", "driving_line", "side_1", "side_2", "side_3", "side_4"];
        for (i, a) in labels.iter().enumerate() {
            for b in &labels[i + 1..] {
                assert_ne!(sub_mask(a), sub_mask(b), "{a} and {b}");
            }
        }
    }

    #[test]
    fn more_probable_road_is_lighter() {
        let lightness = |p: u8| heat(p).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!((0..255).all(|p| lightness(p) <= lightness(p + 1) + 1));
        assert!(lightness(255) > lightness(0) + 300);
        for p in 0..=255 {
            let nearest = (0..=255).map(|q| {
                let apart = |channel: usize| i32::from(remembered(p)[channel]) - i32::from(heat(q)[channel]);
                (0..3).map(|channel| apart(channel).pow(2)).sum::<i32>()
            });
            assert!(nearest.min().unwrap() > 20 * 20, "{p} remembered looks like something seen");
        }
    }
}
