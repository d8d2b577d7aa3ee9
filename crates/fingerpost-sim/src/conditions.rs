//! What the drive looks like: markings, ground, light, camera. One struct of numbers and named presets of it; a new
//! kind of day is a new preset, or a new number that the old presets leave at zero.

use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;

/// White lines on the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Markings {
    /// None anywhere.
    None,
    /// Dashed centre lines and edge lines on roads wide enough for them.
    Lines,
}

/// Numbers of a scene. Lengths in metres, angles in radians, shares between 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Conditions {
    /// White lines.
    pub markings: Markings,
    /// Amplitude of the ground's longest wave (80 m), metres; the shorter ones are proportionally lower.
    pub undulation_m: f64,
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
}

/// Names of the presets, in the order of the documentation.
const NAMES: [&str; 5] = ["clear", "unmarked", "shadows", "rough", "ideal"];

impl Default for Conditions {
    fn default() -> Self {
        Self::CLEAR
    }
}

impl Conditions {
    /// A marked road on a bright day: mild shadows, undulation and suspension.
    pub const CLEAR: Self = Self {
        markings: Markings::Lines,
        undulation_m: 0.03,
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
    };

    /// No markings, a ragged verge of grass and soil, few houses.
    pub const UNMARKED: Self = Self {
        markings: Markings::None,
        houses_per_100_m: 0.8,
        bare_verge: 0.45,
        road_wear: 1.3,
        ..Self::CLEAR
    };

    /// Low sun from the side and many trees near the road.
    pub const SHADOWS: Self = Self {
        shadow_strength: 0.95,
        sun_elevation_rad: 0.61,
        trees_per_100_m: 18.0,
        houses_per_100_m: 3.0,
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

    /// The preset of that name: `clear`, `unmarked`, `shadows`, `rough` or `ideal`.
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
            _ => Err(SimError::UnknownConditions { name: name.to_owned(), known: NAMES.join(", ") }),
        }
    }

    /// The names that [`Self::named`] knows.
    pub const fn names() -> &'static [&'static str] {
        &NAMES
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::OutOfRange`] names the first that is not finite or makes no scene.
    pub fn check(&self) -> Result<(), SimError> {
        let share = "a share between 0 and 1";
        check_range("undulation_m", self.undulation_m, 0.0, 1.0, "0 to 1 metre")?;
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
        check_range("road_wear", self.road_wear, 0.0, 3.0, "0 to 3")
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
        assert!(message.contains("sleet") && message.contains("clear, unmarked, shadows, rough, ideal"));
    }

    #[test]
    fn absurd_numbers_are_named() {
        let bad = Conditions { noise_levels: f64::NAN, ..Conditions::CLEAR };
        assert!(bad.check().unwrap_err().to_string().starts_with("noise_levels"));
        assert!(Conditions { clearance_m: 0.0, ..Conditions::CLEAR }.check().is_err());
    }
}
