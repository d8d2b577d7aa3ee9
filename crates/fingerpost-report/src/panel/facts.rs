//! The numbers of a frame in words, one fact a line.

use fingerpost::camera_state::{CameraEvidence, CameraState};
use fingerpost::lanes::{Lane, LaneEdge, MarkingColour, MarkingKind, Side};
use fingerpost::matching::Match;
use fingerpost::motion::FlowStart;
use fingerpost::progress::GpsUse;
use fingerpost::road_surface::SampleUse;
use fingerpost::track::PossiblePlace;
use nalgebra::Isometry2;

use super::flow::REJECTED_WEIGHT;
use crate::scene::Scene;

/// A driving line of this radius and more is called straight, metres: over the 20 m of a line it leaves a straight one by 0.2 m.
const STRAIGHT_FROM_M: f64 = 1000.0;

/// More places than these are of no weight worth a line.
const MOST_PLACES: usize = 2;

/// A fact: what it is about, and what is known.
pub(crate) type Fact = (&'static str, String);

/// What the stages found, the most telling first.
pub(crate) fn facts(scene: &Scene<'_>) -> Vec<Fact> {
    let (output, evidence) = (scene.output, scene.evidence);
    let mut facts: Vec<Fact> = Vec::new();
    let CameraEvidence { state, contrast, needed_contrast } = output.camera;
    if state != CameraState::Clear {
        let state = state.name().replace('_', " ");
        facts.push(("camera", format!("{state}; contrast {contrast:.1}, needed {needed_contrast:.1}")));
        return facts;
    }
    if let Some((followed, _)) = scene.followed() {
        let sigma = |axis: usize| followed.covariance[(axis, axis)].max(0.0).sqrt();
        let pose = words(&followed.vehicle_from_feature);
        facts.push(("feature", format!("{pose}; sigma {:.2}, {:.2} m", sigma(0), sigma(1))));
    }
    if let Some(places) = places_words(&evidence.track.places) {
        facts.push(("places", places));
    }
    if evidence.track.tried > 0 {
        let best = evidence
            .track
            .sought
            .as_ref()
            .and_then(|sought| sought.matched.p)
            .map_or_else(String::new, |p| format!(", P(F) {p:.2} at the likeliest"));
        facts.push(("search", format!("{} places tried{best}", evidence.track.tried)));
    }
    if let Some(verge) = scene.matched().and_then(verge_words) {
        facts.push(("verge", verge));
    }
    let tightest = output.driving_line_curvature_per_m.iter().fold(0.0_f64, |most, k| most.max(k.abs()));
    if tightest * STRAIGHT_FROM_M >= 1.0 {
        facts.push(("line", format!("tightest radius ahead {:.1} m", 1.0 / tightest)));
    } else if !output.driving_line.is_empty() {
        facts.push(("line", "straight ahead".to_owned()));
    }
    facts.extend(output.lane.as_ref().and_then(lane_words).map(|words| ("lane", words)));
    if let Some(motion) = &output.motion {
        let step = &motion.previous_from_current;
        facts.push(("moved", format!("{}; quality {:.2}", words(step), motion.quality)));
    }
    if let Some(flow) = &evidence.motion {
        let used = flow.samples.iter().filter(|sample| sample.weight >= REJECTED_WEIGHT).count();
        let start = match flow.start {
            FlowStart::Standing => "started from standing",
            FlowStart::SameAsBefore => "started as before",
            FlowStart::CoarseSearch => "started from a coarse search",
            FlowStart::FineSearch => "started from a fine search",
        };
        let of = flow.samples.len();
        facts.push(("flow", format!("{used} of {of} used, residual {:.2} px, {start}", flow.residual_px)));
    }
    let road = &evidence.road;
    let sample = match road.sample_use {
        SampleUse::Learned => "learned",
        SampleUse::LeftOut => "left out, unlike the road so far",
        SampleUse::SurfaceChanged => "taken: the surface has changed",
        SampleUse::Unused => "not learned from",
        SampleUse::Unseen => "not seen",
    };
    facts.push((
        "road",
        format!("{}: P {:.2} in the sample, {sample}", road.detector, road.sample_probability),
    ));
    if let Some((bank, surface)) = road.bank.as_ref().and_then(|bank| Some((bank, bank.surface.as_ref()?))) {
        let founded = if bank.founded { ", new" } else { "" };
        let words = format!("{surface}, likeness {:.2}{founded}; {} known", bank.likeness, bank.surfaces);
        let won = format!("; it wins {:.0} % of the road", 100.0 * bank.won_share);
        facts.push(("surface", if bank.road_share > 0.0 { words + &won } else { words }));
    }
    if let Some(share) = road.by_colours {
        let words =
            format!("of this drive decided against the network in {:.0} % of the places", 100.0 * share);
        facts.push(("colours", words));
    }
    if let Some(memory) = &road.memory {
        let [seen, remembered, kept] =
            [memory.seen_share, memory.remembered_share, memory.kept].map(|share| 100.0 * share);
        facts.push((
            "memory",
            format!(
                "{seen:.0} % of the view seen, {remembered:.0} % remembered; {kept:.0} % kept over the step"
            ),
        ));
    }
    if let Some(route_m) = output.track.route_m {
        facts.push(("route", format!("believed at {route_m:.0} m")));
    }
    match evidence.track.gps {
        Some(GpsUse::Accepted { innovation_m }) => {
            facts.push(("GPS", format!("used, {innovation_m:+.1} m along the route")));
        }
        Some(GpsUse::Jumped { innovation_m }) => {
            facts.push(("GPS", format!("jumped, {innovation_m:+.1} m along the route")));
        }
        Some(GpsUse::OffRoute { distance_m }) => {
            facts.push(("GPS", format!("not used, {distance_m:.0} m off the route")));
        }
        Some(GpsUse::NothingNew) => facts.push(("GPS", "not used, nothing new".into())),
        None => {}
    }
    facts
}

/// Where the feature may be and how probable each place is, the likeliest first; none where it has no place.
fn places_words(places: &[PossiblePlace]) -> Option<String> {
    let present: f64 = places.iter().map(|place| place.weight).sum();
    let likeliest = places.iter().take(MOST_PLACES);
    let words: Vec<String> = likeliest
        .map(|place| format!("{:.2} at {}", place.weight, words(&place.vehicle_from_feature)))
        .collect();
    (!words.is_empty()).then(|| format!("there with probability {present:.2}: {}", words.join("; ")))
}

/// What lies beside the arms, in words; none where no verge is seen.
fn verge_words(matched: &Match) -> Option<String> {
    let arms: Vec<String> = matched
        .subs
        .iter()
        .filter_map(|sub| Some(format!("{} {}", sub.label, signed(sub.contrast()?, 2))))
        .collect();
    let overall = matched.contrast().map_or("not seen where it tells".to_owned(), |c| signed(c, 2));
    (!arms.is_empty()).then(|| format!("contrast {overall}: {}", arms.join(", ")))
}

/// The lane's edges beside the vehicle, in words; none where there is neither.
fn lane_words(lane: &Lane) -> Option<String> {
    let edge = |side: Side| lane.edge(side).map(edge_words);
    let width = lane.width_m().map(|m| format!("{m:.2} m wide"));
    let words: Vec<String> = [edge(Side::Left), edge(Side::Right), width].into_iter().flatten().collect();
    (!words.is_empty()).then(|| words.join("; "))
}

fn edge_words(edge: &LaneEdge) -> String {
    let kind = match edge.marking.kind {
        MarkingKind::Continuous => ", continuous",
        MarkingKind::Broken => ", broken",
        MarkingKind::Double => ", double",
        MarkingKind::Unknown => "",
    };
    let colour = match edge.marking.colour {
        MarkingColour::White => ", white",
        MarkingColour::Yellow => ", yellow",
        MarkingColour::Unknown => "",
    };
    format!("{} m left{kind}{colour}", signed(edge.offset_m, 2))
}

/// A pose in the vehicle frame in words.
fn words(pose: &Isometry2<f64>) -> String {
    let (left, turned) = (signed(pose.translation.y, 2), signed(pose.rotation.angle().to_degrees(), 1));
    format!("{} m ahead, {left} m left, {turned}°", signed(pose.translation.x, 2).trim_start_matches('+'))
}

/// A number with its sign and so many digits; what rounds to zero has no sign.
pub(crate) fn signed(value: f64, digits: usize) -> String {
    let text = format!("{value:+.digits$}");
    if text.chars().all(|c| !c.is_ascii_digit() || c == '0') { format!("{:.digits$}", 0.0) } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        assert_eq!([signed(-0.001, 2), signed(0.3, 2), signed(-0.06, 1)], ["0.00", "+0.30", "-0.1"]);
        assert_eq!(words(&Isometry2::translation(-1.5, 0.25)), "-1.50 m ahead, +0.25 m left, 0.0°");
    }
}
