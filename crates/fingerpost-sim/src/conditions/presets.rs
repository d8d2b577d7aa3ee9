//! The named days.

use super::{CameraLook, Conditions, LaneMarkings, Markings, Streetscape};
use crate::SimError;

/// Names of the presets, in the order of the documentation.
const NAMES: [&str; 25] = [
    "clear",
    "unmarked",
    "shadows",
    "rough",
    "ideal",
    "wet",
    "mixed",
    "dusk",
    "dust",
    "street",
    "street_shade",
    "hills",
    "knocked",
    "dirty_lens",
    "lane_continuous",
    "lane_broken",
    "lane_double",
    "lane_worn",
    "lane_yellow",
    "lane_none",
    "lane_traffic",
    "lane_night",
    "lane_rain",
    "lane_shadows",
    "lane_patches",
];

impl Conditions {
    /// A marked road on a bright day: mild shadows, undulation and suspension.
    pub const CLEAR: Self = Self {
        markings: Markings::Lines,
        lanes: LaneMarkings::WHITE,
        undulation_m: 0.03,
        hill_slope: 0.0,
        camera_knock_rad: 0.0,
        // A tenth of a degree: a sedan at 30 km/h on a good road.
        suspension_rms_rad: 0.0022,
        // A tenth of a degree for each m/s2: about 1 degree for each g.
        suspension_rad_per_mps2: 0.0018,
        wander_m: 0.10,
        noise_levels: 2.0,
        vignette: 0.18,
        shadow_strength: 0.6,
        sun_elevation_rad: 0.96,
        sun_azimuth_rad: -2.2,
        trees_per_100_m: 6.0,
        houses_per_100_m: 2.0,
        clearance_m: 1.8,
        bare_verge: 0.25,
        road_wear: 1.0,
        sky_light: 1.0,
        sun_light: 1.0,
        overcast: 0.0,
        sun_warmth: 0.0,
        shadow_detail: 0.0,
        wetness: 0.0,
        stretch_m: 0.0,
        pavements: 0.0,
        kerbs: 0.0,
        pavements_like_road: 0.0,
        cross_fall: 0.0,
        parking_bays: 0.0,
        walls: 0.0,
        dust: 0.0,
        haze_m: 330.0,
        lens_dirt: 0.0,
        headlights: 0.0,
        headlight_fading: 3,
        retroreflection: 0.0,
        traffic: 0.0,
        parked_per_100_m: 0.0,
        lamps: 0.0,
        rain: 0.0,
        posts_per_100_m: 0.0,
        guard_rails: 0.0,
        strips: 0.0,
        streetscape: Streetscape::USUAL,
        camera: CameraLook::PLAIN,
    };

    /// No markings, a ragged verge of grass and soil, few houses.
    pub const UNMARKED: Self = Self {
        markings: Markings::None,
        houses_per_100_m: 0.8,
        bare_verge: 0.45,
        road_wear: 1.3,
        ..Self::CLEAR
    };

    /// Low sun from the side, many trees and houses near the road, grey pavements: hard and dappled shadows, in which a
    /// fifth of the light is left.
    pub const SHADOWS: Self = Self {
        shadow_strength: 1.0,
        shadow_detail: 1.0,
        // What houses and trees leave of the sky: sun against shadow is about 5 to 1, as measured in streets.
        sky_light: 0.55,
        sun_elevation_rad: 0.61,
        trees_per_100_m: 18.0,
        houses_per_100_m: 4.0,
        pavements: 0.4,
        ..Self::CLEAR
    };

    /// An uneven road: the horizon and the road's far part move.
    pub const ROUGH: Self = Self {
        undulation_m: 0.30,
        suspension_rms_rad: 0.0060,
        suspension_rad_per_mps2: 0.0030,
        road_wear: 1.6,
        ..Self::CLEAR
    };

    /// Flat ground, a rigid body, no shadow and no noise: what geometry is tested on.
    pub const IDEAL: Self = Self {
        undulation_m: 0.0,
        suspension_rms_rad: 0.0,
        suspension_rad_per_mps2: 0.0,
        wander_m: 0.0,
        noise_levels: 0.0,
        vignette: 0.0,
        shadow_strength: 0.0,
        ..Self::CLEAR
    };

    /// After rain, under a grey sky: dark ground that mirrors sky, trees and houses, and puddles.
    pub const WET: Self = Self {
        wetness: 1.0,
        overcast: 0.9,
        // The exposure follows the light: ground looks about as bright as on a clear day, were it dry.
        sky_light: 1.7,
        sun_light: 0.12,
        pavements: 0.3,
        haze_m: 200.0,
        ..Self::CLEAR
    };

    /// A road whose covering changes along the drive, with trenches, tar seams and all kinds of verges.
    pub const MIXED: Self =
        Self { stretch_m: 45.0, pavements: 0.4, road_wear: 1.3, bare_verge: 0.35, ..Self::CLEAR };

    /// After sunset: little light, most of it from the sky, a noisy picture; the low beam is on.
    pub const DUSK: Self = Self {
        sky_light: 0.16,
        sun_light: 0.02,
        sun_warmth: 1.0,
        overcast: 0.4,
        // As clear days: on recorded dusk drives the noise is no stronger in grey levels, only against what is seen.
        noise_levels: 2.0,
        vignette: 0.30,
        headlights: 0.02,
        pavements: 0.4,
        haze_m: 250.0,
        ..Self::CLEAR
    };

    /// A dry, dusty day: dust on the road and on the verge, dust in the air, dirt on the lens.
    pub const DUST: Self = Self {
        dust: 0.5,
        haze_m: 40.0,
        lens_dirt: 0.12,
        overcast: 0.3,
        bare_verge: 0.6,
        markings: Markings::None,
        ..Self::CLEAR
    };

    /// A street of a town: kerbs of 6 to 16 cm with pavements of the road's own tone, parking bays, walls and hedges, and roads that fall
    /// to their sides.
    pub const STREET: Self = Self {
        markings: Markings::None,
        kerbs: 0.8,
        pavements_like_road: 1.0,
        // Roads are built with 2 to 2.5 %, and settle.
        cross_fall: 0.03,
        parking_bays: 0.3,
        walls: 0.6,
        parked_per_100_m: 3.0,
        houses_per_100_m: 4.0,
        trees_per_100_m: 4.0,
        clearance_m: 3.2,
        ..Self::CLEAR
    };

    /// The same under a low sun: most of the street lies in the shadow of houses, walls and trees.
    pub const STREET_SHADE: Self = Self {
        shadow_strength: 1.0,
        shadow_detail: 1.0,
        sky_light: 0.55,
        sun_elevation_rad: 0.61,
        trees_per_100_m: 14.0,
        houses_per_100_m: 8.0,
        ..Self::STREET
    };

    /// Hills of up to 8 %, with crests behind which the road is not seen.
    pub const HILLS: Self = Self { hill_slope: 0.08, ..Self::CLEAR };

    /// A clear day on which something knocks the camera out of place, by 1.7 degrees.
    pub const KNOCKED: Self = Self { camera_knock_rad: 0.03, ..Self::CLEAR };

    /// A clear day behind a dirty lens.
    pub const DIRTY_LENS: Self = Self { lens_dirt: 0.15, ..Self::CLEAR };

    /// The preset of that name, one of [`Self::names`].
    ///
    /// ```
    /// use fingerpost_sim::Conditions;
    /// assert_eq!(Conditions::named("clear").unwrap(), Conditions::CLEAR);
    /// assert!(Conditions::named("fog on the moon").is_err());
    /// ```
    ///
    /// # Errors
    /// [`SimError::UnknownConditions`] lists the names there are.
    pub fn named(name: &str) -> Result<Self, SimError> {
        match name {
            "clear" => Ok(Self::CLEAR),
            "unmarked" => Ok(Self::UNMARKED),
            "shadows" => Ok(Self::SHADOWS),
            "rough" => Ok(Self::ROUGH),
            "ideal" => Ok(Self::IDEAL),
            "wet" => Ok(Self::WET),
            "mixed" => Ok(Self::MIXED),
            "dusk" => Ok(Self::DUSK),
            "dust" => Ok(Self::DUST),
            "street" => Ok(Self::STREET),
            "street_shade" => Ok(Self::STREET_SHADE),
            "hills" => Ok(Self::HILLS),
            "knocked" => Ok(Self::KNOCKED),
            "dirty_lens" => Ok(Self::DIRTY_LENS),
            "lane_continuous" => Ok(Self::LANE_CONTINUOUS),
            "lane_broken" => Ok(Self::LANE_BROKEN),
            "lane_double" => Ok(Self::LANE_DOUBLE),
            "lane_worn" => Ok(Self::LANE_WORN),
            "lane_yellow" => Ok(Self::LANE_YELLOW),
            "lane_none" => Ok(Self::LANE_NONE),
            "lane_traffic" => Ok(Self::LANE_TRAFFIC),
            "lane_night" => Ok(Self::LANE_NIGHT),
            "lane_rain" => Ok(Self::LANE_RAIN),
            "lane_shadows" => Ok(Self::LANE_SHADOWS),
            "lane_patches" => Ok(Self::LANE_PATCHES),
            _ => Err(SimError::UnknownConditions { name: name.to_owned(), known: NAMES.join(", ") }),
        }
    }

    /// The names that [`Self::named`] knows.
    pub const fn names() -> &'static [&'static str] {
        &NAMES
    }
}
