use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::picture::{Rect, RgbImage, ValidityMask};
use nalgebra::Point2;

use super::*;
use crate::ground_view::{GroundPicture, GroundView, GroundViewConfig};
use crate::road_surface::{Memory, MemoryConfig, Perspective};

const BINS: HueSaturationBins = HueSaturationBins { hue: 8, saturation: 8 };
/// Channels of every level.
const CHANNELS: usize = 16;

/// A layer whose first output is its input `at` times 127 and a bias, scaled.
fn layer(inputs: usize, outputs: usize, at: Option<usize>, bias: i32, scale: f32, scales: &[f32]) -> Vec<u8> {
    let mut bytes = vec![0; inputs * outputs];
    if let Some(at) = at {
        bytes[at] = 127;
    }
    bytes.extend((0..outputs).flat_map(|output| if output == 0 { bias } else { 0 }.to_le_bytes()));
    bytes.extend((0..outputs).flat_map(|_| scale.to_le_bytes()));
    bytes.extend(scales.iter().flat_map(|scale| scale.to_le_bytes()));
    bytes
}

/// A network to which red is road, and all else is none, network, colours and offset weighted as given.
fn red_is_road(evidence_weights: [f32; 3]) -> Network {
    let mut bytes = b"FPROAD01".to_vec();
    let mut numbers = |numbers: &[u32]| bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    numbers(&[64, 48]);
    numbers(&[0.86_f32, 1.0, 0.36, 0.64].map(f32::to_bits));
    numbers(&[CHANNELS as u32; 4]);
    numbers(&[0, 0, 0, 2]);
    let same = 1.0 / 127.0;
    let square = |at: Option<usize>, scales: &[f32]| layer(CHANNELS, CHANNELS, at, 0, same, scales);
    // Red's share, in the middle of the window.
    bytes.extend(layer(72, CHANNELS, Some(4 * 8 + 3), 0, 2.0 * same, &[]));
    for _ in 0..3 {
        bytes.extend(layer(9, CHANNELS, None, 0, 0.0, &[]));
        bytes.extend(square(None, &[]));
    }
    bytes.extend(square(None, &[0.0; 3]));
    for _ in 0..3 {
        bytes.extend(square(None, &[0.0, 1.0]));
        bytes.extend(layer(9, CHANNELS, Some(4), 0, same, &[]));
        bytes.extend(square(Some(0), &[]));
    }
    // From -120 to 120 sixteenths.
    bytes.extend(layer(CHANNELS, 2, Some(0), -127 * 127 / 2, 240.0 / (127.0 * 127.0), &[]));
    bytes.extend(evidence_weights.map(f32::to_le_bytes).as_flattened());
    Network::from_bytes(&bytes).unwrap()
}

/// Red on the left, grey on the right.
fn picture() -> RgbImage {
    let row = [[200, 0, 0].repeat(32), [90, 90, 90].repeat(32)].concat();
    RgbImage::from_vec(64, 48, row.repeat(48)).unwrap()
}

/// Road is wanted in a camera picture whose horizon is at a third.
fn in_camera<'a>(picture: &'a GroundPicture, validity: &'a ValidityMask) -> RoadInput<'a> {
    RoadInput {
        picture,
        validity,
        sample: Rect { x: 0, y: 20, width: 16, height: 10 },
        perspective: Perspective::Camera { horizon_row: 16.0 },
        motion: None,
    }
}

#[test]
fn what_the_network_finds_is_laid_over_the_camera_picture() {
    let picture = GroundPicture { colour: picture(), ..GroundPicture::new(64, 48, BINS) };
    let mut seen = Plane::new(64, 48, 1_u8);
    seen.row_mut(10).fill(0);
    let validity = ValidityMask::from_plane(seen);
    let input = in_camera(&picture, &validity);
    let (mut network, mut found) = (red_is_road([1.0, 0.0, 0.0]), Plane::default());
    let evidence = network.estimate(input, &mut found).unwrap();
    // 43 of the picture's rows are shown to the network as 48.
    assert!((evidence.reduced_rows - 43.0 / 48.0).abs() < 1e-12, "{}", evidence.reduced_rows);
    let row = found.row(30);
    assert!(row[..28].iter().all(|&road| road == 255) && row[36..].iter().all(|&road| road == 0), "{row:?}");
    assert!(row.is_sorted_by(|left, right| left >= right), "{row:?}");
    let edge = row.iter().position(|&road| road < 128).unwrap();
    assert!((30..=34).contains(&edge), "{row:?}");
    assert!(found.row(10).iter().all(|&road| road == 0), "an unseen row is no road");
    assert_eq!((evidence.detector, evidence.sample_probability), ("network", 1.0));
}

#[test]
fn the_left_of_the_camera_is_the_left_of_the_ground_view_and_other_planes_are_at_hand_behind_a_memory() {
    let intrinsics = Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 10.0 };
    let camera = Camera::calibrated(64, 48, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
    let view = GroundView::new(&GroundViewConfig::default(), BINS, &camera).unwrap();
    let (ground, frame) = (view.black_picture(), picture());
    let input = RoadInput {
        picture: &ground,
        validity: view.validity(),
        sample: Rect { x: 0, y: 0, width: 1, height: 1 },
        perspective: Perspective::Ground { view: &view, frame: &frame },
        motion: None,
    };
    let mut found = Plane::default();
    let mut network = red_is_road([1.0, 0.0, 0.0]);
    network.estimate(input, &mut found).unwrap();
    let at = |forward_m: f64, left_m: f64| {
        let pixel = view.grid().ground_from_vehicle(Point2::new(forward_m, left_m));
        found.get(pixel.column.round() as usize, pixel.row.round() as usize)
    };
    assert_eq!([at(10.0, 2.0), at(10.0, -2.0), at(18.0, 4.0)], [255, 0, 255].map(Some));

    let mut memory = Memory::new(RoadMethod::Memory, &MemoryConfig::default(), Box::new(network));
    memory.estimate(input, &mut found).unwrap();
    let seen = memory.network().unwrap();
    let logits = |output: NetworkOutput| seen.logits(output.index());
    assert_eq!(logits(NetworkOutput::Road).and_then(|road| road.get(5, 12)), Some(118));
    assert_eq!(logits(NetworkOutput::Paint).and_then(|paint| paint.get(5, 12)), Some(0));
    assert_eq!(logits(NetworkOutput::Hidden), None, "this network has two outputs");
}

#[test]
fn the_weights_that_come_with_the_program_are_a_network_with_all_outputs() {
    assert!(NETWORK_WEIGHTS.len() <= 400_000, "{} bytes", NETWORK_WEIGHTS.len());
    let network = Network::new().unwrap();
    assert!(network.network.outputs() > NetworkOutput::Hidden.index());
    let damaged = Network::from_bytes(&NETWORK_WEIGHTS[..NETWORK_WEIGHTS.len() - 1]).err().unwrap();
    assert!(damaged.to_string().contains("cut off"), "{damaged}");
}

#[test]
fn colours_count_what_the_file_says() {
    let picture = GroundPicture { colour: picture(), ..GroundPicture::new(64, 48, BINS) };
    let validity = ValidityMask::all_seen(64, 48);
    let input = in_camera(&picture, &validity);
    let found = |evidence_weights| {
        let (mut network, mut found) = (red_is_road(evidence_weights), Plane::default());
        network.estimate(input, &mut found).unwrap();
        [found.get(10, 40), found.get(54, 40)].map(Option::unwrap)
    };
    let [red, grey] = found([0.1, 0.0, 0.0]);
    assert!((160..190).contains(&red) && (66..96).contains(&grey), "{red} {grey}");
    let [with_colours, without] = found([0.1, 1.0, 0.0]);
    assert!(with_colours > 250 && without < 5, "{with_colours} {without}");
    assert!(found([0.1, 0.0, 3.0])[1] > 200);
    let damaged = Network::from_bytes(&[NETWORK_WEIGHTS, &[0; 3]].concat()).err().unwrap();
    assert!(damaged.to_string().contains("bytes"), "{damaged}");
    let (network, _) = NETWORK_WEIGHTS.split_last_chunk::<4>().unwrap();
    let infinite = Network::from_bytes(&[network, &f32::INFINITY.to_le_bytes()].concat()).err().unwrap();
    assert!(infinite.to_string().contains("finite"), "{infinite}");
}
