//! Pictures used at a lower resolution than they have, with the camera that takes them.

use anyhow::{Context, Result, bail};
use fingerpost_format::FrameRecord;
use fingerpost_geometry::{Camera, PictureScale, Pixel};
use fingerpost_record::{PIXEL_DIGITS, rounded};
use fingerpost_vision::picture::{Rect, RgbImage};
use fingerpost_vision::resampling::Resampler;

/// Makes a camera's pictures smaller.
pub(crate) struct PictureScaling {
    camera: Camera,
    input_px: (usize, usize),
    scale: PictureScale,
    resampler: Resampler,
    picture: RgbImage,
}

impl PictureScaling {
    /// To `width` pixels across, and as many down as keep the shape to the nearest pixel. None where they have that width.
    ///
    /// # Errors
    /// When the camera's pictures are narrower, or so flat that too few rows would be left.
    pub(crate) fn to_width(camera: &Camera, width: usize) -> Result<Option<Self>> {
        let input_px = (camera.width(), camera.height());
        if width == input_px.0 {
            return Ok(None);
        }
        if width > input_px.0 {
            bail!(
                "--width {width} is more than the {} pixels of the calibration; pictures are only made smaller, so give at most that, or \
                 leave it out",
                input_px.0
            );
        }
        // Rounded to the nearest.
        let height = (2 * input_px.1 * width + input_px.0) / (2 * input_px.0);
        let context = || format!("pictures of {width} x {height} pixels, as --width {width} makes them");
        let whole = Rect { x: 0, y: 0, width: input_px.0, height: input_px.1 };
        let scaled = camera.scaled_to(width, height).with_context(context)?;
        Ok(Some(Self {
            camera: scaled,
            input_px,
            scale: PictureScale::between(input_px, (width, height)),
            resampler: Resampler::new(input_px, whole, (width, height)).with_context(context)?,
            picture: RgbImage::new(width, height),
        }))
    }

    /// The camera at the lower resolution.
    pub(crate) const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Size of the pictures that come in, pixels.
    pub(crate) const fn input_px(&self) -> (usize, usize) {
        self.input_px
    }

    /// Takes a picture in. Says whether it has the size that the calibration states; others are not made smaller.
    pub(crate) fn shrink(&mut self, picture: &RgbImage) -> bool {
        self.resampler.resample(picture, &mut self.picture).is_ok()
    }

    /// The picture that was taken in last, at the lower resolution.
    pub(crate) const fn picture(&self) -> &RgbImage {
        &self.picture
    }

    /// Turns the places in a record's picture into those of the input's picture.
    pub(crate) fn in_input_pixels(&self, record: &mut FrameRecord) {
        let Some(lanes) = &mut record.lanes else { return };
        for [u, v] in lanes.left_px.iter_mut().chain(&mut lanes.right_px) {
            let pixel = self.scale.unscaled(Pixel::new(*u, *v));
            (*u, *v) = (rounded(pixel.u, PIXEL_DIGITS), rounded(pixel.v, PIXEL_DIGITS));
        }
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_format::LanesRecord;
    use fingerpost_geometry::{Distortion, Intrinsics, Mount};
    use nalgebra::Point2;

    use super::*;

    fn camera() -> Camera {
        let lens = Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap();
        let intrinsics = Intrinsics { fx: 600.0, fy: 590.0, cx: 322.0, cy: 218.0 };
        Camera::calibrated(640, 480, intrinsics, lens, Mount { pitch_rad: 0.05, ..Mount::level(1.5) })
            .unwrap()
    }

    /// Paints a bright disc about a pixel.
    fn painted(at: Pixel) -> RgbImage {
        let mut picture = RgbImage::new(640, 480);
        for (v, u) in (0..480).flat_map(|v| (0..640).map(move |u| (v, u))) {
            // Soft at its edge, so that its middle is where it is to a hundredth of a pixel.
            let light = (7.0 - at.distance(Pixel::new(u as f64, v as f64))).clamp(0.0, 1.0);
            picture.row_mut(v)[3 * u..][..3].fill((200.0 * light) as u8);
        }
        picture
    }

    /// Where the light of a picture has its middle.
    fn middle(picture: &RgbImage) -> Pixel {
        let (mut sum, mut u_sum, mut v_sum) = (0.0, 0.0, 0.0);
        for (v, u) in (0..picture.height()).flat_map(|v| (0..picture.width()).map(move |u| (v, u))) {
            let light = f64::from(picture.get(u, v).unwrap()[1]);
            (sum, u_sum, v_sum) = (sum + light, u_sum + light * u as f64, v_sum + light * v as f64);
        }
        Pixel::new(u_sum / sum, v_sum / sum)
    }

    #[test]
    fn a_place_on_the_road_stays_where_it_is() {
        let camera = camera();
        for width in [512, 333, 150] {
            let mut scaling = PictureScaling::to_width(&camera, width).unwrap().unwrap();
            for place in [(6.0, 1.5), (9.0, -2.0), (14.0, 0.0)].map(|(x, y)| Point2::new(x, y)) {
                assert!(scaling.shrink(&painted(camera.pixel_of_ground(place).unwrap())));
                let seen = middle(scaling.picture());
                let expected = scaling.camera().pixel_of_ground(place).unwrap();
                // A mistaken half pixel of the input would be 0.12 at the smallest of these sizes.
                assert!(seen.distance(expected) < 0.03, "{width} {place:?}: {seen:?} for {expected:?}");
            }
        }
    }

    #[test]
    fn the_shape_is_kept_and_no_picture_grows() {
        let size = |width| {
            let scaled = PictureScaling::to_width(&camera(), width).unwrap()?;
            Some((scaled.camera().width(), scaled.camera().height()))
        };
        assert_eq!(size(640), None);
        assert_eq!(size(320), Some((320, 240)));
        assert_eq!(size(150), Some((150, 113)));
        for (width, word) in [(641, "640 pixels"), (16, "image.height")] {
            let error = format!("{:#}", PictureScaling::to_width(&camera(), width).err().unwrap());
            assert!(error.contains(word) && error.contains(&format!("--width {width}")), "{error}");
        }
    }

    #[test]
    fn places_in_records_are_those_of_the_input() {
        let scaling = PictureScaling::to_width(&camera(), 160).unwrap().unwrap();
        let lanes = LanesRecord { left_px: vec![[0.0, 10.0]], ..LanesRecord::default() };
        let time = fingerpost_record::FrameTime { frame: 0, t_s: 0.0 };
        let at_first = fingerpost_format::TrackState::NoRoute;
        let record = fingerpost_record::broken_record(time, None, at_first, String::new());
        let mut record = FrameRecord { lanes: Some(lanes), ..record };
        scaling.in_input_pixels(&mut record);
        assert_eq!(record.lanes.unwrap().left_px, [[1.5, 41.5]]);
    }
}
