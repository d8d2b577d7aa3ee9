use proptest::prelude::*;

use super::*;
use crate::test_pictures::config;

const WEIGHTS: PassageWeights = PassageWeights {
    step: 1.5,
    known_step: 0.7,
    unlike: 0.02,
    discriminant: ([0.3, -0.2, 0.5, 1.0, 0.1], 0.2),
};

/// Squared distance, three colours, texture and slope of each pixel.
type Pixel = ([f32; 3], f32, f32, f32);

fn pixels() -> impl Strategy<Value = Vec<Pixel>> {
    let pixel = (prop::array::uniform3(-1.0..6.0_f32), 0.0..90.0_f32, -4.6..0.5_f32, 0.0..1.0_f32);
    prop::collection::vec(pixel, 1..70)
}

fn plain(pixels: &[Pixel], x: usize) -> (f64, f64) {
    let ([y, rg, bg], squared, texture, slope) = pixels[x];
    let distance = f64::from(squared) / 8.0;
    let (w, offset) = WEIGHTS.discriminant;
    let f = [distance.min(3.0), y.into(), rg.into(), bg.into(), texture.into()];
    let sum: f64 = f64::from(offset) + f.iter().zip(w).map(|(f, w)| f * f64::from(w)).sum::<f64>();
    let other = sum.clamp(0.0, 1.0);
    let edge = 1.5 * f64::from(slope) * (1.0 - 0.7 * libm::exp(-distance) * (1.0 - other));
    (edge, 0.02 * (distance / (1.0 + distance / 2.0) + other))
}

fn costs_of(path: CodePath, pixels: &[Pixel]) -> Plane<u32> {
    let width = pixels.len();
    let plane = |of: fn(&Pixel) -> f32| Plane::from_vec(width, 1, pixels.iter().map(of).collect()).unwrap();
    let colour = LogColour {
        brightness: plane(|p| p.0[0]),
        red_green: plane(|p| p.0[1]),
        blue_green: plane(|p| p.0[2]),
    };
    let (squared, texture, slopes) = (plane(|p| p.1), plane(|p| p.2), plane(|p| p.3));
    let input =
        PassageInput { colour: &colour, squared_distance: &squared, slopes: &slopes, texture: &texture };
    let mut costs = Plane::new(width, 1, 0);
    PassageCost::default().compute_on(path, input, &WEIGHTS, 2048.0, &mut costs).unwrap();
    costs
}

proptest! {
    #![proptest_config(config(80))]

    #[test]
    fn costs_are_as_the_formula_says_on_every_path(pixels in pixels()) {
        let width = pixels.len();
        let edge = |x: isize| {
            // The filter continues a row by a mirror through its edge pixel.
            let last = width as isize - 1;
            let x = if x < 0 { (-x).min(last) } else if x > last { (2 * last - x).max(0) } else { x };
            plain(&pixels, x as usize).0
        };
        let first = costs_of(CodePath::PORTABLE, &pixels);
        for x in 0..width {
            let i = x as isize;
            let spread = 0.25 * edge(i - 1) + 0.5 * edge(i) + 0.25 * edge(i + 1);
            let expected = ((edge(i).max(spread) + plain(&pixels, x).1) * 2048.0).max(1.0);
            prop_assert!((f64::from(first.row(0)[x]) - expected).abs() <= 1.0 + 1e-4 * expected);
        }
        for path in CodePath::available() {
            let costs = costs_of(path, &pixels);
            prop_assert_eq!(costs.as_slice(), first.as_slice());
        }
    }
}

#[test]
fn a_step_between_known_colours_costs_less() {
    let pixel = |squared| ([4.0, 0.0, 0.0], squared, -5.0, 0.5);
    let costs = costs_of(CodePath::PORTABLE, &[pixel(0.0); 3]);
    let unknown = costs_of(CodePath::PORTABLE, &[pixel(200.0); 3]);
    assert!(2 * costs.row(0)[1] < unknown.row(0)[1], "{} and {}", costs.row(0)[1], unknown.row(0)[1]);
}
