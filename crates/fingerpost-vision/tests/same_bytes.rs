//! Every machine gives the same bytes: the kernels' results on a picture that integers make, against sums that were taken once on
//! x86-64. CI runs this on 64-bit ARM too, where other instructions do the work.

// A test states what it expects by panicking.
#![allow(clippy::unwrap_used)]

use fingerpost_vision::backprojection::BackProjector;
use fingerpost_vision::canny::{Canny, CannyParams, GradientNorm};
use fingerpost_vision::corners::CornerFinder;
use fingerpost_vision::farneback::{Farneback, FarnebackParams};
use fingerpost_vision::fusion::fuse;
use fingerpost_vision::hough::{HoughLines, HoughParams};
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};
use fingerpost_vision::lucas_kanade::LucasKanade;
use fingerpost_vision::morphology::{Dilation, StructuringElement};
use fingerpost_vision::picture::{Plane, Rect, RgbImage, ValidityMask};
use fingerpost_vision::pyramid::{GreyPyramid, halve};
use fingerpost_vision::resampling::Resampler;
use fingerpost_vision::smoothing::{BoxBlur, GaussianBlur};
use fingerpost_vision::sobel::Sobel;
use fingerpost_vision::warp::WarpTable;

const WIDTH: usize = 157;
const HEIGHT: usize = 94;

/// Fowler, Noll and Vo's sum of bytes, 64 bits, 1a.
#[derive(Debug, PartialEq, Eq)]
struct Sum(u64);

impl Sum {
    fn of(bytes: impl IntoIterator<Item = u8>) -> Self {
        Self(
            bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| {
                (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
            }),
        )
    }

    fn of_floats(values: impl IntoIterator<Item = f32>) -> Self {
        Self::of(values.into_iter().flat_map(f32::to_le_bytes))
    }
}

/// Waves, blocks and noise, moved to the right.
fn picture(moved: usize) -> Plane<u8> {
    let mut noise = 0x2545_f491_u32;
    let mut value = |x: usize, y: usize| {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let x = x + 40 - moved;
        let wave = (x * x / 7 + y * 3 + x * y / 5) % 128;
        let block = if (x / 13 + y / 11).is_multiple_of(2) { 90 } else { 0 };
        (wave.min(127 - wave) + block + (noise >> 29) as usize) as u8
    };
    Plane::from_vec(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).map(|i| value(i % WIDTH, i / WIDTH)).collect())
        .unwrap()
}

fn colour() -> RgbImage {
    let (red, green) = (picture(0), picture(3));
    let pixels = red.as_slice().iter().zip(green.as_slice());
    let bytes = pixels.flat_map(|(red, green)| [*red, *green, red.wrapping_add(*green) / 2]).collect();
    RgbImage::from_vec(WIDTH, HEIGHT, bytes).unwrap()
}

fn pyramid(plane: &Plane<u8>) -> GreyPyramid {
    let mut pyramid = GreyPyramid::default();
    let filled = pyramid.fill(plane.size(), 3, 16, |base| {
        base.clone_from(plane);
        Ok::<(), ()>(())
    });
    filled.unwrap();
    pyramid
}

/// A road plane's perspective onto a square.
fn perspective() -> WarpTable {
    let place = |column: usize, row: usize| {
        let depth = 1.0 + 0.03 * (63 - row) as f64;
        Some([78.0 + (column as f64 - 31.5) * 2.3 / depth, 12.0 + 78.0 / depth])
    };
    WarpTable::new(64, 64, WIDTH, HEIGHT, place).unwrap()
}

#[test]
fn every_kernel_gives_the_bytes_that_it_always_gave() {
    let grey = picture(0);
    let fresh = || Plane::new(WIDTH, HEIGHT, 0_u8);
    let bytes = |plane: &Plane<u8>| Sum::of(plane.as_slice().iter().copied());
    let mut sums = Vec::new();

    let mut seen = RgbImage::new(64, 64);
    perspective().warp_rgb(&colour(), &mut seen).unwrap();
    sums.push(("perspective warp", Sum::of(seen.as_slice().iter().copied())));

    let mut small = RgbImage::new(61, 37);
    let whole = Rect { x: 0, y: 0, width: WIDTH, height: HEIGHT };
    let mut resampler = Resampler::new((WIDTH, HEIGHT), whole, (61, 37)).unwrap();
    resampler.resample(&colour(), &mut small).unwrap();
    sums.push(("resampling", Sum::of(small.as_slice().iter().copied())));

    sums.push(("JPEG", Sum::of(jpeg_file(&colour(), 85, ChromaSampling::Halved).unwrap())));

    let (mut dx, mut dy) = (Plane::new(WIDTH, HEIGHT, 0), Plane::new(WIDTH, HEIGHT, 0));
    Sobel::new().gradient(grey.view(), &mut dx, &mut dy).unwrap();
    let slopes = dx.as_slice().iter().chain(dy.as_slice());
    sums.push(("Sobel", Sum::of(slopes.flat_map(|slope| slope.to_le_bytes()))));

    let mut edges = fresh();
    let params = CannyParams { low: 120.0, high: 260.0, norm: GradientNorm::L1 };
    Canny::new(params).unwrap().apply(grey.view(), &mut edges).unwrap();
    sums.push(("Canny", bytes(&edges)));

    let params = HoughParams { rho_step_px: 1.0, theta_step_rad: 1_f64.to_radians(), votes: 30 };
    let mut hough = HoughLines::new(params).unwrap();
    let lines = hough.find(edges.view());
    assert!(lines.len() > 3);
    let numbers =
        lines.iter().flat_map(|line| [line.rho_px as f32, line.theta_rad as f32, line.votes as f32]);
    sums.push(("Hough lines", Sum::of_floats(numbers)));

    let mut smooth = fresh();
    BoxBlur::new(7).unwrap().apply(grey.view(), &mut smooth).unwrap();
    sums.push(("box blur", bytes(&smooth)));
    GaussianBlur::new(5, 1.1).unwrap().apply(grey.view(), &mut smooth).unwrap();
    sums.push(("Gaussian blur", bytes(&smooth)));

    let mut half = Plane::new(WIDTH / 2, HEIGHT / 2, 0);
    halve(grey.view(), &mut half).unwrap();
    sums.push(("halving", bytes(&half)));

    let mut grown = fresh();
    Dilation::new(StructuringElement::cross(5, 5).unwrap()).apply(edges.view(), &mut grown).unwrap();
    sums.push(("dilation", bytes(&grown)));

    let bins: Vec<u16> = grey.as_slice().iter().map(|value| u16::from(*value) / 16).collect();
    let bins = Plane::from_vec(WIDTH, HEIGHT, bins).unwrap();
    let levels: Vec<u8> = (0..16).map(|bin| 255 - 15 * bin).collect();
    let mut road = fresh();
    let all = ValidityMask::all_seen(WIDTH, HEIGHT);
    BackProjector::new(2).unwrap().project(&bins, &all, &levels, &mut road).unwrap();
    sums.push(("back-projection", bytes(&road)));

    let mut fused = vec![0; WIDTH * HEIGHT];
    fuse(road.as_slice(), smooth.as_slice(), 26, &mut fused).unwrap();
    sums.push(("fusion", Sum::of(fused)));

    let mut corners = Vec::new();
    CornerFinder::default().find(grey.view(), 24, 1.0, &mut corners);
    assert!(corners.len() > 5);
    sums.push(("corners", Sum::of(corners.iter().flat_map(|corner| [corner.x as u8, corner.y as u8]))));

    let (before, after) = (pyramid(&grey), pyramid(&picture(2)));
    let tracker = LucasKanade::default();
    let tracks: Vec<_> = corners
        .iter()
        .filter_map(|corner| {
            tracker.track(&before, &after, 0, [corner.x as f32, corner.y as f32], [0.0, 0.0])
        })
        .collect();
    assert!(tracks.len() > 5);
    let numbers = tracks.iter().flat_map(|track| [track.to[0], track.to[1], track.residual]);
    sums.push(("Lucas-Kanade", Sum::of_floats(numbers)));

    let mut farneback = Farneback::new(FarnebackParams::default()).unwrap();
    let flow = farneback.flow(grey.view(), picture(2).view(), None).unwrap();
    let numbers = (0..HEIGHT).flat_map(|y| (0..WIDTH).filter_map(move |x| flow.get(x, y))).flatten();
    sums.push(("Farneback's flow", Sum::of_floats(numbers)));

    let found: Vec<String> = sums.iter().map(|(kernel, sum)| format!("{kernel} {:016x}", sum.0)).collect();
    assert_eq!(found, EXPECTED, "{found:#?}");
}

const EXPECTED: [&str; 15] = [
    "perspective warp d9046ef2d2519993",
    "resampling 5871babf9eeb6e4c",
    "JPEG 4336cda0f28b307c",
    "Sobel 392ba89dfb94e3d7",
    "Canny da439c316c043ca8",
    "Hough lines 73d0480c812e6953",
    "box blur bf4170a50b90e19a",
    "Gaussian blur a31e777f45ebd783",
    "halving 1ae8f578a74ee67d",
    "dilation c93538699ab03bf4",
    "back-projection 838ae2e3cfe531e6",
    "fusion e5a36619844da8c1",
    "corners c9635bda5d02ce6f",
    "Lucas-Kanade 87b8958e3543b113",
    "Farneback's flow 1c7b1f2c8cdcb4c7",
];
