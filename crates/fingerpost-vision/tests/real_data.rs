//! Agreement with OpenCV on ground views of KITTI odometry 00, frames that may not be shipped: the folder named by the
//! environment variable FINGERPOST_DATA holds them at `kitti/frames00`. `tools/golden/opencv_golden.py` made the flows.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::path::PathBuf;

use common::{HEIGHT, WIDTH, end_point_difference};
use fingerpost_vision::farneback::{Farneback, FarnebackParams};
use fingerpost_vision::picture::Plane;
use fingerpost_vision::warp::WarpTable;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Mean end-point difference allowed, pixels; decoders of JPEG differ by a grey level.
const FLOW_TOLERANCE_PX: f64 = 0.05;
/// One golden flow vector is kept at every so many pixels; the drives' licence lets only such samples ship.
const STEP: usize = 8;

/// The ground view that the golden flows were computed on: a level camera 1.65 m above the road.
const FOCAL_PX: f64 = 718.856;
const CENTRE_PX: [f64; 2] = [607.1928, 185.2157];
const CAMERA_HEIGHT_M: f64 = 1.65;
const FAR_M: f64 = 14.3;
const METRES_PER_PX: f64 = 0.05;

#[test]
fn flow_agrees_on_five_pairs_of_a_drive() {
    let mut farneback = Farneback::new(FarnebackParams::default()).unwrap();
    for (from, to) in [(0, 1), (40, 41), (85, 86), (104, 105), (112, 113)] {
        let (previous, next) = (ground_view(from), ground_view(to));
        let flow = farneback.flow(previous.view(), next.view(), None).unwrap();
        let (mean, largest) = end_point_difference(flow, &format!("kitti_{from}_{to}.flow"), STEP);
        assert!(mean <= FLOW_TOLERANCE_PX, "frames {from} and {to}: mean {mean} px, largest {largest} px");
    }
}

fn ground_view(frame: u32) -> Plane<u8> {
    let folder = std::env::var_os("FINGERPOST_DATA")
        .expect("set FINGERPOST_DATA to the folder of recorded drives, the one that holds kitti/frames00");
    let path = PathBuf::from(folder).join(format!("kitti/frames00/{frame:06}.jpg"));
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let pixels = decoder.decode().unwrap();
    let (width, height) = decoder.dimensions().unwrap();
    let grey = Plane::from_vec(width, height, pixels).unwrap();
    let table = WarpTable::new(WIDTH, HEIGHT, width, height, |col, row| {
        let forward_m = FAR_M - METRES_PER_PX * row as f64;
        let right_m = METRES_PER_PX * (col as f64 - (WIDTH - 1) as f64 / 2.0);
        Some([
            FOCAL_PX * right_m / forward_m + CENTRE_PX[0],
            FOCAL_PX * CAMERA_HEIGHT_M / forward_m + CENTRE_PX[1],
        ])
    })
    .unwrap();
    assert!(
        table.validity().plane().as_slice().iter().all(|&valid| valid == 1),
        "the whole view lies in the picture"
    );
    let mut view = Plane::new(WIDTH, HEIGHT, 0);
    table.warp_grey(&grey, &mut view).unwrap();
    view
}
