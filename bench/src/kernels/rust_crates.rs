//! The same operations in the crates kornia-imgproc and imageproc, as contestants without a promise.

use fingerpost_vision::picture::{Plane, RgbImage};
use image::{GrayImage, Luma};
use imageproc::definitions::Image;
use imageproc::distance_transform::Norm;
use kornia_image::{Image as KorniaImage, ImageSize};
use kornia_imgproc::interpolation::InterpolationMode;
use kornia_imgproc::{
    canny, color, connected_components, filter, interpolation, morphology, pyramid, resize,
};

use crate::measure::Contestant;

fn kornia_size((width, height): (usize, usize)) -> ImageSize {
    ImageSize { width, height }
}

/// A kornia picture of a plane, and an empty one of the same size.
///
/// # Panics
/// Never: a plane's data fit its size.
fn kornia_pair(plane: &Plane<u8>) -> (KorniaImage<u8, 1>, KorniaImage<u8, 1>) {
    let size = kornia_size(plane.size());
    let source = KorniaImage::new(size, plane.as_slice().to_vec()).expect("a plane's data fit its size");
    let target = KorniaImage::from_size_val(size, 0).expect("a plane's size is a picture's");
    (source, target)
}

fn kornia_rgb(image: &RgbImage) -> KorniaImage<u8, 3> {
    KorniaImage::new(kornia_size(image.size()), image.as_slice().to_vec())
        .expect("a picture's data fit its size")
}

fn imageproc_grey(plane: &Plane<u8>) -> GrayImage {
    GrayImage::from_raw(plane.width() as u32, plane.height() as u32, plane.as_slice().to_vec())
        .expect("a plane's data fit its size")
}

pub fn remaps<'a>(frame: &RgbImage, maps: [&[f32]; 2], side_px: usize) -> Vec<Contestant<'a>> {
    let source = kornia_rgb(frame);
    let size = kornia_size((side_px, side_px));
    let map =
        |values: &[f32]| KorniaImage::<f32, 1>::new(size, values.to_vec()).expect("a map of the square");
    let [map_x, map_y] = maps.map(map);
    let mut target = KorniaImage::<u8, 3>::from_size_val(size, 0).expect("a square");
    vec![Contestant::here("kornia", move || {
        let _ = interpolation::remap_u8(&source, &mut target, &map_x, &map_y, InterpolationMode::Bilinear);
    })]
}

pub fn greys<'a>(image: &RgbImage) -> Vec<Contestant<'a>> {
    let source = kornia_rgb(image);
    let mut target = KorniaImage::<u8, 1>::from_size_val(source.size(), 0).expect("a picture's size");
    vec![Contestant::here("kornia", move || {
        let _ = color::gray_from_rgb_u8(&source, &mut target);
    })]
}

pub fn gaussians<'a>(plane: &Plane<u8>, side: usize, sigma_px: f32) -> Vec<Contestant<'a>> {
    let (source, mut target) = kornia_pair(plane);
    let grey = imageproc_grey(plane);
    vec![
        Contestant::here("kornia", move || {
            let _ = filter::gaussian_blur_u8(&source, &mut target, (side, side), (sigma_px, sigma_px));
        }),
        Contestant::here("imageproc", move || {
            std::hint::black_box(imageproc::filter::gaussian_blur_f32(&grey, sigma_px));
        }),
    ]
}

pub fn box_means<'a>(plane: &Plane<u8>, side: usize) -> Vec<Contestant<'a>> {
    let (source, mut target) = kornia_pair(plane);
    let grey = imageproc_grey(plane);
    let radius = side as u32 / 2;
    vec![
        Contestant::here("kornia", move || {
            let _ = filter::box_blur_u8(&source, &mut target, (side, side));
        }),
        Contestant::here("imageproc", move || {
            std::hint::black_box(imageproc::filter::box_filter(&grey, radius, radius));
        }),
    ]
}

pub fn sobels<'a>(plane: &Plane<u8>) -> Vec<Contestant<'a>> {
    let grey = imageproc_grey(plane);
    vec![Contestant::here("imageproc", move || {
        let gradient: Image<Luma<i16>> = imageproc::gradients::horizontal_sobel(&grey);
        std::hint::black_box(gradient);
    })]
}

pub fn cannys<'a>(plane: &Plane<u8>, low: f64, high: f64) -> Vec<Contestant<'a>> {
    let (source, mut target) = kornia_pair(plane);
    let grey = imageproc_grey(plane);
    vec![
        Contestant::here("kornia", move || {
            let _ = canny::canny(&source, &mut target, low, high, false);
        }),
        Contestant::here("imageproc", move || {
            std::hint::black_box(imageproc::edges::canny(&grey, low as f32, high as f32));
        }),
    ]
}

pub fn square_dilations<'a>(plane: &Plane<u8>, side: usize) -> Vec<Contestant<'a>> {
    let (source, mut target) = kornia_pair(plane);
    let grey = imageproc_grey(plane);
    let kernel = morphology::Kernel::new(morphology::KernelShape::Box { size: side });
    let radius = side as u8 / 2;
    vec![
        Contestant::here("kornia", move || {
            let padding = kornia_imgproc::padding::PaddingMode::Constant;
            let _ = morphology::dilate(&source, &mut target, &kernel, padding, [0]);
        }),
        Contestant::here("imageproc", move || {
            std::hint::black_box(imageproc::morphology::dilate(&grey, Norm::LInf, radius));
        }),
    ]
}

pub fn components<'a>(plane: &Plane<u8>) -> Vec<Contestant<'a>> {
    let grey = imageproc_grey(plane);
    vec![Contestant::here("imageproc", move || {
        let connectivity = imageproc::region_labelling::Connectivity::Eight;
        std::hint::black_box(imageproc::region_labelling::connected_components(
            &grey,
            connectivity,
            Luma([0]),
        ));
    })]
}

pub fn hough_lines<'a>(plane: &Plane<u8>, votes: u32) -> Vec<Contestant<'a>> {
    let grey = imageproc_grey(plane);
    vec![Contestant::here("imageproc", move || {
        let options = imageproc::hough::LineDetectionOptions { vote_threshold: votes, suppression_radius: 1 };
        std::hint::black_box(imageproc::hough::detect_lines(&grey, options));
    })]
}

pub fn halvings<'a>(plane: &Plane<u8>) -> Vec<Contestant<'a>> {
    let (source, _) = kornia_pair(plane);
    let mut target = half_of(plane);
    vec![Contestant::here("kornia", move || {
        let _ = resize::resize_opencv_u8(&source, &mut target, InterpolationMode::Bilinear);
    })]
}

pub fn reductions<'a>(plane: &Plane<u8>) -> Vec<Contestant<'a>> {
    let (source, _) = kornia_pair(plane);
    let mut target = half_of(plane);
    vec![Contestant::here("kornia", move || {
        let _ = pyramid::pyrdown_u8(&source, &mut target);
    })]
}

fn half_of(plane: &Plane<u8>) -> KorniaImage<u8, 1> {
    let size = kornia_size((plane.width().div_ceil(2), plane.height().div_ceil(2)));
    KorniaImage::from_size_val(size, 0).expect("half a plane's size")
}
