//! What the drive looks like: markings, ground, light, camera. One struct of numbers and named presets of it; a new
//! kind of day is a new preset, or a new number that the old presets leave without effect.

mod camera_look;
mod lane_presets;
mod lanes;
mod presets;
mod streetscape;

use serde::{Deserialize, Serialize};

pub use self::camera_look::CameraLook;
pub use self::lanes::{LaneMarkings, LineColour, LinePattern, LineStyle};
pub use self::streetscape::Streetscape;
use crate::SimError;
use crate::error::check_range;

/// Lines on the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Markings {
    /// None anywhere.
    None,
    /// Dashed centre lines and edge lines on roads wide enough for them.
    Lines,
    /// Lanes as [`Conditions::lanes`] says.
    Lanes,
    /// Every street its own lines or none, and stop and give-way lines at some junctions.
    Streets,
}

/// Numbers of a scene. Lengths in metres, angles in radians, shares between 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Conditions {
    /// Lines.
    pub markings: Markings,
    /// How lanes are marked, with [`Markings::Lanes`].
    pub lanes: LaneMarkings,
    /// Amplitude of the ground's longest wave (80 m), metres; the shorter ones are proportionally lower.
    pub undulation_m: f64,
    /// Steepest slope of hills, metres up for each metre along; their crests are some 60 m apart. 0 for none.
    pub hill_slope: f64,
    /// How far a knock on the way turns the camera, radians; 0 for none.
    pub camera_knock_rad: f64,
    /// Root mean square of the body's pitch and roll about the road's plane from unevenness, radians.
    pub suspension_rms_rad: f64,
    /// Pitch of the body for each m/s2 of braking, radians (nose down), and roll for each m/s2 in a bend (outwards).
    pub suspension_rad_per_mps2: f64,
    /// Amplitude of the vehicle's wander about its line, metres.
    pub wander_m: f64,
    /// Standard deviation of the sensor's noise, grey levels of 255.
    pub noise_levels: f64,
    /// Loss of brightness in the corners of the picture, share.
    pub vignette: f64,
    /// Share of the sun's light that a shadow takes away.
    pub shadow_strength: f64,
    /// Height of the sun above the horizon, radians.
    pub sun_elevation_rad: f64,
    /// Direction of the sun, radians anticlockwise from east.
    pub sun_azimuth_rad: f64,
    /// Trees for each 100 m of roadside.
    pub trees_per_100_m: f64,
    /// Houses for each 100 m of roadside.
    pub houses_per_100_m: f64,
    /// Least distance of tree crowns and walls from the road's edge, metres.
    pub clearance_m: f64,
    /// Share of bare soil in the verge's grass.
    pub bare_verge: f64,
    /// Strength of the road's patches, cracks and stains, where 1 is an ordinary road.
    pub road_wear: f64,
    /// Light of the open sky, where 1 is a clear day's at the camera's exposure.
    pub sky_light: f64,
    /// Light of the sun, likewise.
    pub sun_light: f64,
    /// How much the sky is covered: the sky's light and colour turn from blue to grey, share.
    pub overcast: f64,
    /// How far the sun's colour has turned to that of a low sun, share.
    pub sun_warmth: f64,
    /// How dappled and how sharp shadows are, share: 0 for soft ones with few flecks of sun, 1 for hard edges that turn
    /// soft from place to place, and for leaves that let many flecks through.
    pub shadow_detail: f64,
    /// Water on the ground: from 0, dry, to 1, a film that mirrors and puddles.
    pub wetness: f64,
    /// Length of the stretches after which a road's covering changes (asphalt old and new, concrete, gravel, earth),
    /// metres; 0 for the map's covering all along.
    pub stretch_m: f64,
    /// Share of the roadsides with kerb and pavement in place of grass.
    pub pavements: f64,
    /// Share of the roadsides with a kerb that has a height, and a raised pavement behind it.
    pub kerbs: f64,
    /// How much of the road's own tone these pavements are, share.
    pub pavements_like_road: f64,
    /// Largest fall across a road that has kerbs, metres for each metre.
    pub cross_fall: f64,
    /// Share of the kerbed roadsides with parking bays before the kerb, as high as the road.
    pub parking_bays: f64,
    /// Share of the roadsides with a wall or hedge behind the pavement.
    pub walls: f64,
    /// Dust on everything and in the air, which has its colour then, share.
    pub dust: f64,
    /// Distance over which about a quarter of a colour is lost to the air, metres.
    pub haze_m: f64,
    /// Dirt on the lens: share of the picture that blots cover.
    pub lens_dirt: f64,
    /// Light of the vehicle's low beam 10 m ahead, in the units of `sky_light`.
    pub headlights: f64,
    /// Power of the distance with which the low beam fades on the road: 3 for a lamp without a beam, 2 for one whose beam
    /// is strongest just below its cut-off.
    pub headlight_fading: i32,
    /// How many times as bright as in daylight paint, plates and lamps throw the low beam back.
    pub retroreflection: f64,
    /// How many vehicles there are in the other lanes, where 1 is one in each 80 m of a lane.
    pub traffic: f64,
    /// Vehicles that stand beside the road, for each 100 m.
    pub parked_per_100_m: f64,
    /// How bright the lamps of other vehicles are; 0 where they are off.
    pub lamps: f64,
    /// Rain in the air and drops on the windscreen: 1 for a heavy shower.
    pub rain: f64,
    /// Lamp posts for each 100 m of roadside.
    pub posts_per_100_m: f64,
    /// Share of the roadsides with a guard rail.
    pub guard_rails: f64,
    /// Strips of new asphalt and sealed cracks along the road: 1 where every stretch has some.
    pub strips: f64,
    /// What streets are made of.
    pub streetscape: Streetscape,
    /// What the camera makes of the light.
    pub camera: CameraLook,
}

impl Default for Conditions {
    fn default() -> Self {
        Self::CLEAR
    }
}

impl Conditions {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::OutOfRange`] names the first that is not finite or makes no scene.
    pub fn check(&self) -> Result<(), SimError> {
        let share = "a share between 0 and 1";
        check_range("undulation_m", self.undulation_m, 0.0, 1.0, "0 to 1 metre")?;
        check_range("hill_slope", self.hill_slope, 0.0, 0.12, "0 to 0.12")?;
        check_range("camera_knock_rad", self.camera_knock_rad, 0.0, 0.2, "0 to 0.2 radians")?;
        check_range("suspension_rms_rad", self.suspension_rms_rad, 0.0, 0.05, "0 to 0.05 radians")?;
        check_range("suspension_rad_per_mps2", self.suspension_rad_per_mps2, 0.0, 0.02, "0 to 0.02")?;
        check_range("wander_m", self.wander_m, 0.0, 0.5, "0 to 0.5 metres")?;
        check_range("noise_levels", self.noise_levels, 0.0, 40.0, "0 to 40 grey levels")?;
        check_range("vignette", self.vignette, 0.0, 1.0, share)?;
        check_range("shadow_strength", self.shadow_strength, 0.0, 1.0, share)?;
        // Lower suns cast shadows longer than the scene is wide.
        check_range("sun_elevation_rad", self.sun_elevation_rad, 0.3, 1.57, "0.3 to 1.57 radians")?;
        check_range("sun_azimuth_rad", self.sun_azimuth_rad, -7.0, 7.0, "radians anticlockwise from east")?;
        check_range("trees_per_100_m", self.trees_per_100_m, 0.0, 50.0, "0 to 50")?;
        check_range("houses_per_100_m", self.houses_per_100_m, 0.0, 20.0, "0 to 20")?;
        check_range("clearance_m", self.clearance_m, 1.5, 30.0, "1.5 to 30 metres")?;
        check_range("bare_verge", self.bare_verge, 0.0, 1.0, share)?;
        check_range("road_wear", self.road_wear, 0.0, 3.0, "0 to 3")?;
        check_range("sky_light", self.sky_light, 0.001, 3.0, "0.001 to 3")?;
        check_range("sun_light", self.sun_light, 0.0, 3.0, "0 to 3")?;
        check_range("overcast", self.overcast, 0.0, 1.0, share)?;
        check_range("sun_warmth", self.sun_warmth, 0.0, 1.0, share)?;
        check_range("shadow_detail", self.shadow_detail, 0.0, 1.0, share)?;
        check_range("wetness", self.wetness, 0.0, 1.0, share)?;
        check_range("stretch_m", self.stretch_m, 0.0, 1000.0, "0 to 1000 metres")?;
        check_range("pavements", self.pavements, 0.0, 1.0, share)?;
        check_range("kerbs", self.kerbs, 0.0, 1.0, share)?;
        check_range("pavements_like_road", self.pavements_like_road, 0.0, 1.0, share)?;
        check_range("cross_fall", self.cross_fall, 0.0, 0.04, "0 to 0.04")?;
        check_range("parking_bays", self.parking_bays, 0.0, 1.0, share)?;
        check_range("walls", self.walls, 0.0, 1.0, share)?;
        check_range("dust", self.dust, 0.0, 1.0, share)?;
        // Below 10 m the road itself is no longer seen.
        check_range("haze_m", self.haze_m, 10.0, 1e5, "10 to 100000 metres")?;
        check_range("lens_dirt", self.lens_dirt, 0.0, 1.0, share)?;
        check_range("headlights", self.headlights, 0.0, 3.0, "0 to 3")?;
        let fading = f64::from(self.headlight_fading);
        check_range("headlight_fading", fading, 1.0, 4.0, "a power from 1 to 4")?;
        check_range("retroreflection", self.retroreflection, 0.0, 50.0, "0 to 50")?;
        check_range("traffic", self.traffic, 0.0, 5.0, "0 to 5")?;
        check_range("parked_per_100_m", self.parked_per_100_m, 0.0, 12.0, "0 to 12")?;
        check_range("lamps", self.lamps, 0.0, 10.0, "0 to 10")?;
        check_range("rain", self.rain, 0.0, 2.0, "0 to 2")?;
        check_range("posts_per_100_m", self.posts_per_100_m, 0.0, 20.0, "0 to 20")?;
        check_range("guard_rails", self.guard_rails, 0.0, 1.0, share)?;
        check_range("strips", self.strips, 0.0, 1.0, share)?;
        self.streetscape.check()?;
        self.camera.check()?;
        self.lanes.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_listed_name_is_a_valid_preset() {
        for name in Conditions::names() {
            Conditions::named(name).unwrap().check().unwrap();
        }
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_known_ones() {
        let message = Conditions::named("sleet").unwrap_err().to_string();
        assert!(message.contains("sleet") && message.contains("clear, unmarked, shadows, rough, ideal, wet"));
    }

    #[test]
    fn absurd_numbers_are_named() {
        let bad = Conditions { noise_levels: f64::NAN, ..Conditions::CLEAR };
        assert!(bad.check().unwrap_err().to_string().starts_with("noise_levels"));
        assert!(Conditions { clearance_m: 0.0, ..Conditions::CLEAR }.check().is_err());
    }
}
