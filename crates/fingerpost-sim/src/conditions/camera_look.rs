//! What a camera makes of the light: exposure, colour, blur, compression, and the vehicle's bonnet in front of it.

use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;

/// How pictures look, apart from the lens and its noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraLook {
    /// Brightness against an exposure for the day: above 1 sky and walls are over-exposed.
    pub exposure: f64,
    /// Steepness of the curve from light to grey levels about the middle one: below 1 for a faded picture.
    pub contrast: f64,
    /// Strength of colours: 0 for a grey camera.
    pub saturation: f64,
    /// Gains of red, green and blue.
    pub white_balance: [f64; 3],
    /// How far a pixel moves away from the vanishing point while the shutter is open, share of its distance from there.
    pub motion_blur: f64,
    /// Share of a pixel's light that each of its neighbours in a row or column gets.
    pub defocus: f64,
    /// Coarseness of block compression, where 1 is about a JPEG file of quality 50; 0 for none.
    pub compression: f64,
    /// Height of the bonnet in the picture's middle, share of the picture's height; 0 where none is seen.
    pub bonnet: f64,
    /// Brightness of the dashboard's mirror image in the windscreen, share of the sky's light.
    pub veil: f64,
}

impl CameraLook {
    /// A camera without faults that sees no bonnet.
    pub const PLAIN: Self = Self {
        exposure: 1.0,
        contrast: 1.0,
        saturation: 1.0,
        white_balance: [1.0; 3],
        motion_blur: 0.0,
        defocus: 0.0,
        compression: 0.0,
        bonnet: 0.0,
        veil: 0.0,
    };

    /// Checks every number.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        check_range("camera.exposure", self.exposure, 0.1, 10.0, "0.1 to 10")?;
        check_range("camera.contrast", self.contrast, 0.1, 3.0, "0.1 to 3")?;
        check_range("camera.saturation", self.saturation, 0.0, 3.0, "0 to 3")?;
        for gain in self.white_balance {
            check_range("camera.white_balance", gain, 0.2, 5.0, "gains of 0.2 to 5")?;
        }
        check_range("camera.motion_blur", self.motion_blur, 0.0, 0.2, "a share from 0 to 0.2")?;
        check_range("camera.defocus", self.defocus, 0.0, 0.33, "a share from 0 to 0.33")?;
        check_range("camera.compression", self.compression, 0.0, 5.0, "0 to 5")?;
        check_range("camera.bonnet", self.bonnet, 0.0, 0.5, "a share from 0 to 0.5")?;
        check_range("camera.veil", self.veil, 0.0, 1.0, "a share between 0 and 1")
    }
}

impl Default for CameraLook {
    fn default() -> Self {
        Self::PLAIN
    }
}
