//! What a world is drawn from where its pictures are to be learned from: wider than what one drive is tried on.
//!
//! A network that learns from drawn pictures finds in real ones what the drawn ones had; what lies outside of them it has never seen. So
//! ranges reach from one end of what cameras and streets have to the other, and kinds are drawn as often as each other, not as often as
//! they occur. Where nothing is cited a range is an assumption that was held against recorded pictures by eye.

use std::f64::consts::PI;

use super::log_between;
use super::ranges::{CameraRanges, Carrier};
use crate::conditions::{CameraLook, Streetscape};
use crate::noise::Stream;
use crate::{Conditions, Markings};

/// A small robot or a low car, a car, a van, a lorry; cameras from bumpers to roofs.
pub(super) const VEHICLES: [(f64, Carrier); 3] = [
    (0.3, Carrier { camera_height_m: [0.5, 1.3], ..super::ranges::CAR }),
    (0.5, Carrier { camera_height_m: [1.1, 2.0], ..super::ranges::CAR }),
    (0.2, Carrier { camera_height_m: [1.8, 3.0], ..super::ranges::VAN }),
];
/// From a narrow lens to a wide one, and from a camera that looks level to one that is aimed at the road.
pub(super) const CAMERA: CameraRanges =
    CameraRanges { field_of_view_deg: [40.0, 120.0], pitch_deg: [-3.0, 20.0], shows_from_m: 11.0 };

/// Kinds of light by their share, each with its sun, sky, air and water.
const LIGHTS: [(f64, Conditions); 8] = [
    (2.0, Conditions::CLEAR),
    (3.0, Conditions::STREET_SHADE),
    (1.5, OVERCAST),
    (1.0, Conditions::WET),
    (1.0, Conditions::DUSK),
    (0.5, Conditions::DUST),
    (0.6, FOG),
    (0.6, NIGHT),
];
/// A grey day without shadows.
const OVERCAST: Conditions =
    Conditions { overcast: 1.0, sky_light: 1.9, sun_light: 0.05, haze_m: 400.0, ..Conditions::CLEAR };
/// A street at night as a camera of today exposes it: the low beam and a city's sky.
const NIGHT: Conditions =
    Conditions { headlights: 0.25, sky_light: 0.08, noise_levels: 5.0, ..Conditions::LANE_NIGHT };
/// Fog through which a street is seen for some 50 m.
const FOG: Conditions =
    Conditions { overcast: 1.0, sky_light: 1.8, sun_light: 0.0, haze_m: 35.0, ..Conditions::CLEAR };

/// Height of the sun, radians: from the lowest that the scene has room for to that of a summer's noon.
const SUN_ELEVATION_RAD: [f64; 2] = [0.3, 1.1];
/// Distance over which the air takes a quarter, as a factor on the light's own.
const HAZE: [f64; 2] = [0.5, 3.0];
/// What shadows leave of the sky: from open country to narrow streets.
const SKY_LIGHT: [f64; 2] = [0.55, 1.15];
const NOISE_LEVELS: [f64; 2] = [0.3, 9.0];
const VIGNETTE: [f64; 2] = [0.0, 0.6];
const ROAD_WEAR: [f64; 2] = [0.2, 2.2];
const TREES_PER_100_M: [f64; 2] = [0.0, 20.0];
const HOUSES_PER_100_M: [f64; 2] = [0.0, 8.0];
const PARKED_PER_100_M: [f64; 2] = [0.0, 3.0];
const POSTS_PER_100_M: [f64; 2] = [0.0, 8.0];
const TRAFFIC: [f64; 2] = [0.2, 1.5];
/// Share of the worlds whose roads are broad, and how many times as wide as usual: streets of two lanes become arterial roads of three to
/// six.
const BROAD: f64 = 0.35;
const BROADNESS: [f64; 2] = [1.5, 2.8];
/// Share of the worlds whose lanes have lines between them, as many as there is room for.
const LINED_LANES: f64 = 0.4;

/// Share of the worlds in which others drive.
const WITH_TRAFFIC: f64 = 0.35;
const WORN: [f64; 2] = [0.0, 0.8];

/// Exposure, factor: half a stop too dark to more than one too bright.
const EXPOSURE: [f64; 2] = [0.65, 2.2];
/// Contrast of faded and of hard pictures, colours from pale to strong, gains of red and blue off their balance, factors.
const CONTRAST: [f64; 2] = [0.65, 1.5];
const SATURATION: [f64; 2] = [0.3, 1.6];
const GAINS: [f64; 2] = [0.8, 1.25];
/// Share of the cameras that are grey, that blur, that compress, that see the bonnet, and behind whose windscreen something is mirrored.
const GREY: f64 = 0.15;
const BLURRED: f64 = 0.5;
const COMPRESSED: f64 = 0.5;
const BONNETS: f64 = 0.25;
const VEILS: f64 = 0.3;
/// The most of each: a shutter open for 1/30 s at 10 m/s takes 3 % of the distance to a place 10 m ahead.
const MOTION_BLUR: f64 = 0.035;
const DEFOCUS: f64 = 0.3;
const COMPRESSION: f64 = 2.0;
const BONNET: [f64; 2] = [0.03, 0.2];
const VEIL: f64 = 0.25;

/// Share of the worlds with unmade roads, with snow and with leaves.
const UNMADE_WORLDS: f64 = 0.3;
const SNOWY: f64 = 0.08;
const LEAFY: f64 = 0.2;
/// Share of the worlds whose streets are lined by houses and walls, by trees, by things on the pavement, by parked vehicles.
const BUILT_UP: f64 = 0.65;
const AVENUES: f64 = 0.45;
const FURNISHED: f64 = 0.6;
const LINED: f64 = 0.6;
/// Share of the worlds with manholes, crossings and arrows.
const FITTED: f64 = 0.6;

/// How many times as wide as usual a world's roads are.
pub(super) fn broadness(seed: u64) -> f64 {
    let mut stream = Stream::new(seed, 0x4252_4f41);
    let broad = stream.between(BROADNESS[0], BROADNESS[1]);
    if stream.unit() < BROAD { broad } else { 1.0 }
}

/// A day, its streets and its camera.
pub(super) fn conditions(stream: &mut Stream) -> Conditions {
    let light = stream.choose(&LIGHTS).unwrap_or(Conditions::CLEAR);
    let is_day = light.sun_light >= 1.0;
    let mut within = |range: [f64; 2]| stream.between(range[0], range[1]);
    let mut drawn = Conditions {
        markings: Markings::Streets,
        sun_azimuth_rad: within([-PI, PI]),
        sun_elevation_rad: within(SUN_ELEVATION_RAD),
        sky_light: if is_day { within(SKY_LIGHT) } else { light.sky_light },
        shadow_strength: within([0.6, 1.0]),
        shadow_detail: within([0.0, 1.0]),
        haze_m: light.haze_m * within(HAZE),
        noise_levels: within(NOISE_LEVELS),
        vignette: within(VIGNETTE),
        road_wear: within(ROAD_WEAR),
        bare_verge: within([0.0, 1.0]),
        trees_per_100_m: within(TREES_PER_100_M),
        houses_per_100_m: within(HOUSES_PER_100_M),
        posts_per_100_m: within(POSTS_PER_100_M),
        parked_per_100_m: within(PARKED_PER_100_M),
        strips: within([0.0, 1.0]).powi(2),
        undulation_m: within([0.0, 0.15]),
        suspension_rms_rad: within([0.001, 0.006]),
        stretch_m: 0.0,
        kerbs: 0.0,
        pavements: 0.0,
        walls: 0.0,
        cross_fall: 0.0,
        parking_bays: 0.0,
        ..light
    };
    drawn.lanes.worn = within(WORN);
    let density = within(TRAFFIC);
    drawn.traffic = if stream.unit() < WITH_TRAFFIC { density } else { 0.0 };
    drawn.streetscape = streetscape(stream);
    draw_sides(stream, &mut drawn);
    drawn.camera = camera_look(stream);
    if stream.unit() < LINED_LANES {
        drawn.markings = Markings::Lanes;
    }
    drawn
}

/// What lies beside the roads: kerbs with heights, pavements without, or ground that nobody made.
fn draw_sides(stream: &mut Stream, drawn: &mut Conditions) {
    // Nobody sets kerbs beside gravel.
    let kerbed = if drawn.streetscape.unmade > 0.0 { 0.05 } else { 0.6 };
    match stream.choose(&[(kerbed, 0), (0.2, 1), (0.2, 2)]) {
        Some(0) => {
            drawn.kerbs = stream.between(0.5, 1.0);
            drawn.pavements_like_road = stream.unit();
            drawn.cross_fall = stream.between(0.0, 0.03);
            drawn.parking_bays = stream.unit();
            drawn.walls = stream.unit();
            drawn.clearance_m = 3.2;
        }
        Some(1) => {
            drawn.pavements = stream.between(0.4, 1.0);
            drawn.stretch_m = stream.between(20.0, 80.0);
        }
        _ => {}
    }
}

/// Grounds of all kinds, and in some worlds unmade roads, snow or leaves.
fn streetscape(stream: &mut Stream) -> Streetscape {
    let mut some = |share: f64, [low, high]: [f64; 2]| {
        let amount = stream.between(low, high);
        if stream.unit() < share { amount } else { 0.0 }
    };
    Streetscape {
        materials: 0.85,
        unmade: some(UNMADE_WORLDS, [0.4, 1.0]),
        ragged_m: 0.8,
        snow: some(SNOWY, [0.3, 1.0]),
        leaves: some(LEAFY, [0.1, 1.0]),
        frontage: some(BUILT_UP, [0.3, 1.0]),
        avenue_per_100_m: some(AVENUES, [3.0, 14.0]),
        furniture_per_100_m: some(FURNISHED, [1.0, 10.0]),
        fixtures: some(FITTED, [0.3, 1.0]),
        parked_rows: some(LINED, [0.3, 1.0]),
        edge_paint: 0.6,
    }
}

fn camera_look(stream: &mut Stream) -> CameraLook {
    let exposure = log_between(stream, EXPOSURE);
    let contrast = log_between(stream, CONTRAST);
    let saturation = if stream.unit() < GREY { 0.0 } else { stream.between(SATURATION[0], SATURATION[1]) };
    let white_balance = [log_between(stream, GAINS), 1.0, log_between(stream, GAINS)];
    // Most have little of it.
    let mut some = |share: f64, most: f64| {
        let draw = stream.unit().powi(2);
        if stream.unit() < share { most * draw } else { 0.0 }
    };
    let [motion_blur, defocus] = [some(BLURRED, MOTION_BLUR), some(BLURRED, DEFOCUS)];
    let [compression, veil] = [some(COMPRESSED, COMPRESSION), some(VEILS, VEIL)];
    let has_bonnet = stream.unit() < BONNETS;
    let bonnet = if has_bonnet { stream.between(BONNET[0], BONNET[1]) } else { 0.0 };
    CameraLook {
        exposure,
        contrast,
        saturation,
        white_balance,
        motion_blur,
        defocus,
        compression,
        bonnet,
        veil,
    }
}
