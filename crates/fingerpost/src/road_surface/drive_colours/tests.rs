use super::*;

/// Road of one grey in the left half, a verge of green in the right one; the places' logits as given.
fn scene(road: [i8; 2]) -> (RgbImage, Plane<i8>) {
    let row = [[90, 90, 95].repeat(16), [60, 110, 50].repeat(16)].concat();
    let picture = RgbImage::from_vec(32, 24, row.repeat(24)).unwrap();
    let mut logits = Plane::new(16, 12, 0);
    for y in 0..12 {
        logits.row_mut(y)[..8].fill(road[0]);
        logits.row_mut(y)[8..].fill(road[1]);
    }
    (picture, logits)
}

fn row(colours: &DriveColours, y: usize) -> impl Iterator<Item = f32> {
    colours.colours.row(y).iter().map(|&colour| colours.log_ratio[usize::from(colour)])
}

fn at(colours: &DriveColours, x: usize) -> f32 {
    row(colours, 11).nth(x).unwrap()
}

#[test]
fn what_the_network_is_sure_of_teaches_the_rest() {
    let mut colours = DriveColours::new();
    let (picture, sure) = scene([60, -60]);
    colours.learn(&picture, &sure, 4);
    let (grey, green) = (at(&colours, 2), at(&colours, 13));
    assert!(grey > 3.0 && green < -3.0, "{grey} {green}");
    // The same colours where the network does not know: they are what was learned.
    let (picture, unsure) = scene([0, 0]);
    colours.learn(&picture, &unsure, 4);
    assert!(at(&colours, 2) > 3.0 && at(&colours, 13) < -3.0);
    colours.forget();
    colours.learn(&picture, &unsure, 4);
    assert!(at(&colours, 2).abs() < 1e-6 && at(&colours, 13).abs() < 1e-6);
}

#[test]
fn a_pixel_adds_what_places_of_its_colour_have_in_steps() {
    let mut colours = DriveColours::new();
    let (picture, sure) = scene([60, -60]);
    colours.learn(&picture, &sure, 4);
    colours.weigh(2.0);
    for (pixel, x) in [([90, 90, 95], 2), ([60, 110, 50], 13)] {
        let expected = (2.0 * at(&colours, x)).round();
        assert_eq!(colours.steps(pixel), expected as i8);
    }
}

#[test]
fn a_colour_that_is_on_either_side_says_nothing() {
    let mut colours = DriveColours::new();
    let grey = RgbImage::from_vec(32, 24, vec![90; 3 * 32 * 24]).unwrap();
    colours.learn(&grey, &scene([60, -60]).1, 0);
    assert!(at(&colours, 2).abs() < 1e-3 && at(&colours, 13).abs() < 1e-3);
}

#[test]
fn nothing_is_learned_above_the_horizon() {
    let mut colours = DriveColours::new();
    let (picture, mut logits) = scene([60, -60]);
    for y in 0..6 {
        logits.row_mut(y).fill(-127);
    }
    colours.learn(&picture, &logits, 6);
    let below = at(&colours, 2);
    let mut others = DriveColours::new();
    others.learn(&picture, &logits, 0);
    assert!(below > 3.0 && at(&others, 2) < below, "{below}");
}

#[test]
fn logits_at_the_ends_and_colours_at_the_ends_have_their_bins() {
    let mut colours = DriveColours::new();
    for levels in [[0, 0, 0], [255, 255, 255], [255, 0, 0], [0, 0, 255]] {
        let picture = RgbImage::from_vec(4, 4, levels.repeat(16)).unwrap();
        let mut logits = Plane::new(2, 2, i8::MIN);
        logits.row_mut(1).fill(i8::MAX);
        colours.learn(&picture, &logits, 0);
        assert!(row(&colours, 0).all(f32::is_finite));
    }
}

#[test]
fn it_is_what_the_training_computes() {
    // Two pictures and logits, and what `tools/golden/drive_colours.py` makes of them.
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let (rgb, logits, added) =
        (read("drive_colours.rgb"), read("drive_colours.i8"), read("drive_colours.f32"));
    let mut colours = DriveColours::new();
    let frames =
        rgb.chunks_exact(3 * 48 * 32).zip(logits.chunks_exact(24 * 16)).zip(added.chunks_exact(4 * 24 * 16));
    let mut compared = 0;
    for ((rgb, logits), added) in frames {
        let picture = RgbImage::from_vec(48, 32, rgb.to_vec()).unwrap();
        let mut road = Plane::new(24, 16, 0);
        road.as_mut_slice().iter_mut().zip(logits).for_each(|(to, &from)| *to = from.cast_signed());
        colours.learn(&picture, &road, 5);
        let found = (0..16).flat_map(|y| row(&colours, y).collect::<Vec<_>>());
        for (found, expected) in found.zip(added.as_chunks().0) {
            let expected = f32::from_le_bytes(*expected);
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
            compared += usize::from(expected.abs() > 0.5);
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn shares_have_the_whole_steps_of_their_division() {
    for total in 0..=BRIGHTEST as u32 {
        let of_total = OfTotal::new(total, 0);
        for level in 0..=total.min(BRIGHTEST as u32 / 3) {
            let expected = (SHARE_STEPS * level / (total + DARK)).clamp(12, 11 + BINS as u32) - 12;
            assert_eq!(of_total.share(level), expected, "{level} of {total}");
        }
    }
}
