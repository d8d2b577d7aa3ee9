//! Grounds of each street's own: unmade roads, pavements of many tones, snow and leaves.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use common::{camera, graph, route};
use fingerpost_geometry::Distortion;
use fingerpost_sim::{
    Conditions, CornerStyle, Markings, PixelClass, SimConfig, SimFrame, Simulator, Streetscape,
};

/// Kerbed streets without anything that stands beside them.
const BARE: Conditions =
    Conditions { kerbs: 1.0, trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::IDEAL };

fn simulator(seed: u64, conditions: Conditions) -> Simulator {
    let graph = graph();
    let config = SimConfig { conditions, corners: CornerStyle::Drawn, seed, ..SimConfig::default() };
    let camera = camera(160, 120, Distortion::None);
    Simulator::new(&graph, &route(&graph), &camera, &config).unwrap()
}

fn frame(seed: u64, conditions: Conditions) -> SimFrame {
    simulator(seed, conditions).frame(20)
}

/// Mean green level of the pixels of a class.
fn level(frame: &SimFrame, class: PixelClass) -> f64 {
    let pixels = frame.picture.as_slice().chunks_exact(3).zip(frame.classes.as_slice());
    let levels: Vec<f64> =
        pixels.filter(|(_, of)| **of == class as u8).map(|(pixel, _)| f64::from(pixel[1])).collect();
    levels.iter().sum::<f64>() / levels.len() as f64
}

#[test]
fn pavements_reach_from_dark_to_bright_and_some_are_of_the_road_s_tone() {
    let streetscape = Streetscape { materials: 1.0, ..Streetscape::USUAL };
    let against_road: Vec<f64> = (0..24)
        .map(|seed| frame(seed, Conditions { streetscape, ..BARE }))
        .map(|frame| level(&frame, PixelClass::Raised) - level(&frame, PixelClass::Road))
        .collect();
    let within = |low: f64, high: f64| against_road.iter().filter(|by| (low..high).contains(*by)).count();
    assert!(within(-255.0, -15.0) >= 2 && within(15.0, 255.0) >= 4, "{against_road:?}");
    assert!(within(-10.0, 10.0) >= 3, "{against_road:?}");
}

#[test]
fn an_unmade_road_has_no_paint_and_a_ragged_edge() {
    let paved = Conditions { kerbs: 0.0, ..BARE };
    let streetscape = Streetscape { unmade: 1.0, ragged_m: 1.0, ..Streetscape::USUAL };
    let (paved, unmade) = (frame(3, paved), frame(3, Conditions { streetscape, ..paved }));
    let painted = |frame: &SimFrame| {
        frame.classes.as_slice().iter().filter(|&&class| class == PixelClass::Paint as u8).count()
    };
    assert!(painted(&paved) > 20 && painted(&unmade) == 0);
    let moved = paved.road.as_slice().iter().zip(unmade.road.as_slice()).filter(|(a, b)| a != b).count();
    assert!(moved > 60, "the edge differs in {moved} pixels");
    let area = |frame: &SimFrame| frame.road.as_slice().iter().filter(|&&road| road > 0).count();
    assert!(area(&unmade).abs_diff(area(&paved)) * 5 < area(&paved), "the road is as wide");
}

#[test]
fn snow_lies_beside_the_road_and_leaves_gather_at_its_edge() {
    let bare = Conditions { kerbs: 0.0, ..BARE };
    let with = |streetscape: Streetscape| frame(3, Conditions { streetscape, ..bare });
    let [plain, snowy, leafy] = [
        Streetscape { ragged_m: 0.1, ..Streetscape::USUAL },
        Streetscape { snow: 1.0, ..Streetscape::USUAL },
        Streetscape { leaves: 1.0, ..Streetscape::USUAL },
    ]
    .map(with);
    assert!(level(&snowy, PixelClass::Verge) > level(&plain, PixelClass::Verge) + 60.0);
    assert!(level(&snowy, PixelClass::Road) < level(&plain, PixelClass::Road) + 30.0);
    let reddened = |frame: &SimFrame| {
        let pixels = frame.picture.as_slice().chunks_exact(3).zip(frame.classes.as_slice());
        let is_red = |pixel: &[u8]| u16::from(pixel[0]) > u16::from(pixel[2]) + 50;
        pixels.filter(|(pixel, class)| **class == PixelClass::Road as u8 && is_red(pixel)).count()
    };
    assert!(reddened(&leafy) > reddened(&plain) + 50, "{} and {}", reddened(&leafy), reddened(&plain));
}

#[test]
fn crossings_and_arrows_are_paint_and_manholes_are_road() {
    let with = |fixtures: f64| {
        let streetscape = Streetscape { fixtures, ragged_m: 0.1, ..Streetscape::USUAL };
        Conditions { markings: Markings::None, kerbs: 0.0, streetscape, ..BARE }
    };
    let area = |frame: &SimFrame, class: PixelClass| {
        frame.classes.as_slice().iter().filter(|&&number| number == class as u8).count()
    };
    // The car is at 38 m: manholes lie 41 to 52 m along the road, crossings 56 to 60 m.
    let (mut painted, mut dark) = (0, 0);
    for seed in 0..12 {
        let [plain, fitted] = [0.0, 1.0].map(|fixtures| simulator(seed, with(fixtures)).frame(42));
        assert_eq!(area(&plain, PixelClass::Paint), 0);
        assert_eq!(plain.road, fitted.road, "what lies on the road is road");
        painted += area(&fitted, PixelClass::Paint);
        let pixels = plain.picture.as_slice().chunks_exact(3).zip(fitted.picture.as_slice().chunks_exact(3));
        dark += pixels.filter(|(before, after)| i16::from(after[1]) < i16::from(before[1]) - 15).count();
    }
    assert!(painted > 40 && dark > 100, "{painted} pixels of paint, {dark} of iron");
}
