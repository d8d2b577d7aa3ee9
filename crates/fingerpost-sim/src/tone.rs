//! From light to bytes: exposure, vignette, the display's curve, the sensor's noise.

use crate::Conditions;
use crate::surface::Colour;

/// Entries of the curve's table: a third of a grey level apart at the steepest.
const TABLE: usize = 4096;
/// Light that comes out as white.
const WHITE: f32 = 1.15;
/// The display's curve as a power (IEC 61966-2-1, its overall exponent).
const GAMMA: f64 = 2.2;
/// Level about which contrast turns.
const MIDDLE: f32 = 128.0;
/// Weights of the channels in a grey picture (ITU-R BT.601).
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];
/// Standard deviation of the sum of four random bytes.
const FOUR_BYTES_SIGMA: f32 = 147.8;
/// Share of the noise that is the same in all channels; the rest is one of colour.
const GREY_SHARE: f32 = 0.85;

/// Turns light into bytes.
#[derive(Debug, Clone)]
pub(crate) struct Development {
    levels: Vec<f32>,
    vignette: f32,
    noise_levels: f32,
    /// Gains of the three channels.
    gains: Colour,
    /// Strength of colours, where that is not as the light has it.
    saturation: Option<f32>,
}

impl Development {
    pub(crate) fn new(conditions: &Conditions) -> Self {
        let look = conditions.camera;
        let level = |i: usize| {
            let level = 255.0 * libm::pow(i as f64 / (TABLE - 1) as f64, 1.0 / GAMMA) as f32;
            match look.contrast as f32 {
                1.0 => level,
                steepness => (MIDDLE + steepness * (level - MIDDLE)).clamp(0.0, 255.0),
            }
        };
        let saturation = look.saturation as f32;
        Self {
            levels: (0..TABLE).map(level).collect(),
            vignette: conditions.vignette as f32,
            noise_levels: conditions.noise_levels as f32,
            gains: look.white_balance.map(|gain| (gain * look.exposure) as f32),
            saturation: ((saturation - 1.0).abs() > 0.0).then_some(saturation),
        }
    }

    /// The bytes of a pixel: `off_centre` is 1 in the picture's corners, `noise` 64 random bits.
    #[inline]
    pub(crate) fn develop(&self, light: Colour, off_centre: f32, noise: u64) -> [u8; 3] {
        let exposure = (1.0 - self.vignette * off_centre) * (TABLE - 1) as f32 / WHITE;
        // Neighbouring bytes added up in four lanes at once.
        let pairs = (noise & 0x00FF_00FF_00FF_00FF) + ((noise >> 8) & 0x00FF_00FF_00FF_00FF);
        let lane = |i: u32| ((pairs >> (16 * i)) & 0xFFFF) as i32 as f32 - 255.0;
        let scale = self.noise_levels / FOUR_BYTES_SIGMA;
        let grey = GREY_SHARE * scale * (lane(0) + lane(1));
        // Two bytes for each of two channels; the third balances them.
        let spread = 2.8 * (1.0 - GREY_SHARE) * scale;
        let (red, blue) = (spread * lane(2), spread * lane(3));
        let mut tint = [red, -0.5 * (red + blue), blue];
        let mut levels = [0, 1, 2].map(|i| {
            let entry = ((light[i] * self.gains[i] * exposure) as i32).clamp(0, TABLE as i32 - 1) as usize;
            self.levels[entry]
        });
        if let Some(saturation) = self.saturation {
            let luma: f32 = levels.iter().zip(LUMA).map(|(level, weight)| level * weight).sum();
            levels = levels.map(|level| luma + saturation * (level - luma));
            tint = tint.map(|level| saturation * level);
        }
        // Adding a half rounds; the conversion clamps.
        [0, 1, 2].map(|i| (levels[i] + grey + tint[i] + 0.5) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraLook;

    #[test]
    fn noise_has_the_spread_asked_for_and_no_bias() {
        let development = Development::new(&Conditions { noise_levels: 4.0, ..Conditions::IDEAL });
        let plain = Development::new(&Conditions::IDEAL).develop([0.2; 3], 0.0, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..20_000 {
            let green = development.develop([0.2; 3], 0.0, crate::noise::mix(i))[1];
            let error = f64::from(green) - f64::from(plain[1]);
            (sum, squares) = (sum + error, squares + error * error);
        }
        assert!((sum / 20_000.0).abs() < 0.15, "bias {}", sum / 20_000.0);
        let sigma = (squares / 20_000.0).sqrt();
        assert!((sigma - 4.0).abs() < 0.8, "{sigma}");
    }

    #[test]
    fn corners_are_darker_by_the_vignette() {
        let development = Development::new(&Conditions { vignette: 0.5, ..Conditions::IDEAL });
        let (middle, corner) = (development.develop([0.4; 3], 0.0, 0), development.develop([0.4; 3], 1.0, 0));
        let ratio = f64::from(corner[0]) / f64::from(middle[0]);
        assert!((ratio - libm::pow(0.5, 1.0 / GAMMA)).abs() < 0.01);
    }

    #[test]
    fn a_grey_camera_has_no_colour_and_a_gain_changes_one_channel() {
        let with = |camera: CameraLook| Development::new(&Conditions { camera, ..Conditions::IDEAL });
        let developed = |camera: CameraLook| with(camera).develop([0.3, 0.2, 0.1], 0.0, 0);
        let [red, green, blue] = developed(CameraLook { saturation: 0.0, ..CameraLook::PLAIN });
        assert!(red == green && green == blue);
        let plain = developed(CameraLook::PLAIN);
        let warm = developed(CameraLook { white_balance: [1.3, 1.0, 1.0], ..CameraLook::PLAIN });
        assert!(warm[0] > plain[0] + 10 && warm[1..] == plain[1..]);
        let faded = developed(CameraLook { contrast: 0.5, ..CameraLook::PLAIN });
        assert!(faded[0].abs_diff(faded[2]) < plain[0].abs_diff(plain[2]) / 3 * 2);
    }
}
