//! The road network's kernels against PyTorch's results, committed (`tools/golden/road_network.py` made them).
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use std::path::PathBuf;

use fingerpost_vision::picture::{Rect, RgbImage};
use fingerpost_vision::road_network::RoadNetwork;

const WIDTH: usize = 48;
const HEIGHT: usize = 32;

fn golden(name: &str) -> Vec<u8> {
    std::fs::read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)).unwrap()
}

#[test]
fn the_network_gives_the_logits_that_pytorch_gives() {
    let mut network = RoadNetwork::from_bytes(&golden("road_network.weights")).unwrap();
    let (pictures, logits) = (golden("road_network.rgb"), golden("road_network.i8"));
    let (columns, rows) = network.logit_size();
    let of_picture = logits.chunks_exact(network.outputs() * columns * rows);
    assert_eq!(of_picture.len(), 3);
    for (bytes, expected) in pictures.chunks_exact(3 * WIDTH * HEIGHT).zip(of_picture) {
        let picture = RgbImage::from_vec(WIDTH, HEIGHT, bytes.to_vec()).unwrap();
        network.see(&picture, Rect { x: 0, y: 0, width: WIDTH, height: HEIGHT }).unwrap();
        let found: Vec<u8> = (0..network.outputs())
            .flat_map(|output| network.logits(output).unwrap().as_slice())
            .map(|&logit| logit.cast_unsigned())
            .collect();
        assert_eq!(found, expected);
    }
}
