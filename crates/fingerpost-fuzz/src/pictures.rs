//! Pictures (PNG, JPEG and PPM), and the network that looks at them.

use std::path::Path;

use fingerpost_io::{decode_picture, encode_png};
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};
use fingerpost_vision::picture::{Rect, RgbImage};
use fingerpost_vision::road_network::RoadNetwork;

use crate::must;

/// A picture that is read has the pixels of its size.
pub(crate) fn picture(bytes: &[u8]) -> bool {
    let Ok(picture) = decode_picture(bytes, Path::new("mutated")) else { return false };
    let (width, height) = picture.size();
    assert!(width > 0 && height > 0, "{width} x {height} pixels");
    assert_eq!(picture.as_slice().len(), width * height * RgbImage::CHANNELS);
    true
}

fn pattern() -> RgbImage {
    let mut picture = RgbImage::new(40, 24);
    for row in 0..24 {
        for (column, byte) in picture.row_mut(row).iter_mut().enumerate() {
            *byte = ((row * 7 + column * 3) % 251) as u8;
        }
    }
    picture
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let picture = pattern();
    let pixmap = [b"P6\n# by hand\n40 24\n255\n", picture.as_slice()].concat();
    let jpeg = |sampling| must(jpeg_file(&picture, 80, sampling), "a seed");
    vec![
        must(encode_png(&picture), "a seed"),
        jpeg(ChromaSampling::Halved),
        jpeg(ChromaSampling::Full),
        pixmap,
    ]
}

/// A network that is read says something of every place of a picture, and of the same picture the same.
pub(crate) fn road_network(bytes: &[u8]) -> bool {
    let Ok(mut network) = RoadNetwork::from_bytes(bytes) else { return false };
    let picture = pattern();
    let (width, height) = picture.size();
    let mut see = || {
        must(network.see(&picture, Rect { x: 0, y: 0, width, height }), "a picture");
        let planes: Vec<_> =
            (0..network.outputs()).filter_map(|output| network.logits(output).cloned()).collect();
        assert_eq!(planes.len(), network.outputs());
        assert!(planes.iter().all(|plane| plane.size() == network.logit_size()));
        planes
    };
    assert_eq!(see(), see());
    true
}

pub(crate) fn road_network_seeds() -> Vec<Vec<u8>> {
    vec![include_bytes!("../../fingerpost-vision/tests/golden/road_network.weights").to_vec()]
}
