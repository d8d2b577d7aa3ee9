//! Buses of every kind against the camera, on drives of straights, bends, junctions and stops.

use std::f64::consts::PI;

use nalgebra::{Isometry2, Matrix3, Vector2};

use super::*;

const DT_S: f64 = 0.1;

/// Numbers that repeat (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Of standard deviation 1, nearly normal.
    fn noise(&mut self) -> f64 {
        (0..12).map(|_| self.between(-0.5, 0.5)).sum()
    }
}

/// Speed and yaw rate of a drive that is at least so long, ten a second.
fn drive(numbers: &mut Numbers, metres: f64) -> Vec<[f64; 2]> {
    let (mut rows, mut driven_m, mut speed, mut curvature) = (Vec::new(), 0.0, 10.0_f64, 0.0_f64);
    while driven_m < metres {
        let (wanted_mps, wanted_per_m) = match numbers.next() % 6 {
            0 => (0.0, 0.0),
            1 | 2 => (numbers.between(8.0, 35.0), 0.0),
            3 => (numbers.between(8.0, 30.0), numbers.between(-0.006, 0.006)),
            4 => (numbers.between(4.0, 7.0), numbers.between(0.05, 0.1)),
            _ => (numbers.between(4.0, 7.0), -numbers.between(0.05, 0.1)),
        };
        // The vehicle is first as slow as it must be, then turns.
        let turned_s = if wanted_per_m.abs() > 0.01 { 4 } else { 12 };
        let change = |from: f64, to: f64, most: f64| from + (to - from).clamp(-most, most);
        for frame in 0..10 * (10 + turned_s) {
            speed = change(speed, wanted_mps, 2.5 * DT_S);
            let turns = frame >= 100 && frame < 10 * (9 + turned_s);
            curvature = change(curvature, if turns { wanted_per_m } else { 0.0 }, 0.06 * DT_S);
            rows.push([speed, speed * curvature]);
            driven_m += speed * DT_S;
        }
    }
    rows
}

/// What a bus makes of the true speed and yaw rate.
#[derive(Debug, Clone, Copy)]
struct Bus {
    scale: f64,
    yaw_scale: f64,
    yaw_bias_rps: f64,
    late_frames: usize,
    stuck: [Option<f64>; 2],
}

const SOUND: Bus = Bus { scale: 1.0, yaw_scale: 1.0, yaw_bias_rps: 0.0, late_frames: 1, stuck: [None; 2] };

/// How far was driven and turned until each was found to disagree; `camera_scale` is what its height is off by.
struct Found {
    driven_m: f64,
    turned_deg: f64,
    speed_after_m: Option<f64>,
    yaw_rate_after_deg: Option<f64>,
    /// Frames in which the bus was used behind that.
    used_after: usize,
    last: SignalsEvidence,
}

fn found(seed: u64, metres: f64, bus: Bus, camera_scale: f64) -> Found {
    let mut numbers = Numbers(seed);
    let rows = drive(&mut numbers, metres);
    found_on(&rows, &mut numbers, bus, camera_scale)
}

/// A road that winds: bends of 120 to 600 m radius to either side in turns, ten seconds and less long.
fn winding(numbers: &mut Numbers, metres: f64) -> Vec<[f64; 2]> {
    let (mut rows, mut driven_m, mut side) = (Vec::new(), 0.0, 1.0);
    while driven_m < metres {
        let (speed, seconds) = (numbers.between(15.0, 22.0), numbers.between(4.0, 10.0));
        let curvature = side / numbers.between(120.0, 600.0);
        let frames = (seconds / DT_S) as usize;
        for frame in 0..frames {
            // As a road's bends are laid out: in and out without a step.
            let into = libm::sin(PI * frame as f64 / frames as f64);
            rows.push([speed, speed * curvature * into]);
            driven_m += speed * DT_S;
        }
        side = -side;
    }
    rows
}

fn found_on(rows: &[[f64; 2]], numbers: &mut Numbers, bus: Bus, camera_scale: f64) -> Found {
    let mut signals = VehicleSignals::new(&CanConfig::default());
    let mut found = Found {
        driven_m: 0.0,
        turned_deg: 0.0,
        speed_after_m: None,
        yaw_rate_after_deg: None,
        used_after: 0,
        last: SignalsEvidence::default(),
    };
    let mut wet = 0.0;
    for (index, &[speed, yaw_rate]) in rows.iter().enumerate() {
        let [late_speed, late_yaw_rate] = rows[index.saturating_sub(bus.late_frames)];
        let sample = |value| Some(Sample { value, age_s: 0.01 });
        let of_bus = VehicleSamples {
            speed_mps: sample(bus.stuck[0].unwrap_or(bus.scale * late_speed + 0.02 * numbers.noise())),
            yaw_rate_rps: sample(
                bus.stuck[1]
                    .unwrap_or(bus.yaw_scale * late_yaw_rate + bus.yaw_bias_rps + 0.003 * numbers.noise()),
            ),
            turn_signal: None,
        };
        // A wet or blank road holds the camera back or lets it run ahead for a while.
        wet = 0.98 * wet + 0.01 * numbers.noise();
        let seen_mps = speed * (camera_scale + wet) + 0.1 * numbers.noise();
        let seen_rps = yaw_rate * (1.0 + wet) + 0.01 * numbers.noise();
        let motion = Motion {
            previous_from_current: Isometry2::new(Vector2::new(seen_mps * DT_S, 0.0), seen_rps * DT_S),
            covariance: Matrix3::identity(),
            quality: 0.9,
        };
        let input = SignalsInput { samples: Some(of_bus), motion: Some(&motion), dt_s: Some(DT_S) };
        let (_, evidence) = signals.step(input);
        found.driven_m += speed * DT_S;
        found.turned_deg += yaw_rate.abs().to_degrees() * DT_S;
        if evidence.speed_disagreement.is_some() {
            found.speed_after_m.get_or_insert(found.driven_m);
        }
        if evidence.yaw_rate_disagreement.is_some() {
            found.yaw_rate_after_deg.get_or_insert(found.turned_deg);
        }
        let used = |after: bool, of: SignalUse| usize::from(after && of.source == SignalSource::Can);
        found.used_after += used(found.speed_after_m.is_some(), evidence.speed)
            + used(found.yaw_rate_after_deg.is_some(), evidence.yaw_rate);
        found.last = evidence;
    }
    found
}

#[test]
fn a_sound_bus_is_never_found_to_disagree() {
    let mut numbers = Numbers(1);
    for seed in 0..40 {
        let bus = Bus {
            scale: numbers.between(0.95, 1.05),
            yaw_scale: numbers.between(0.95, 1.05),
            yaw_bias_rps: numbers.between(-0.5, 0.5).to_radians(),
            late_frames: numbers.next() as usize % 4,
            ..SOUND
        };
        let camera_scale = numbers.between(0.95, 1.05);
        let found = found(seed, 40_000.0, bus, camera_scale);
        assert!(found.turned_deg > 1_000.0, "the drive has turns");
        assert!(
            found.speed_after_m.is_none() && found.yaw_rate_after_deg.is_none(),
            "{seed}: {bus:?}, camera {camera_scale}: speed after {:?} m, yaw rate after {:?} degrees",
            found.speed_after_m,
            found.yaw_rate_after_deg
        );
    }
}

#[test]
fn a_wrong_speed_is_found_within_a_kilometre_and_not_used() {
    for seed in 0..12 {
        for (scale, within_m) in
            [(1.3, 1000.0), (0.7, 1000.0), (1.6, 400.0), (3.6, 100.0), (1.0 / 3.6, 500.0), (0.0, 500.0)]
        {
            let found = found(seed, 3_000.0, Bus { scale, ..SOUND }, 1.0);
            let after_m = found.speed_after_m.unwrap_or(f64::INFINITY);
            assert!(after_m < within_m, "{seed}, times {scale}: after {after_m} m");
            assert_eq!(found.yaw_rate_after_deg, None, "only the speed is wrong");
            assert_eq!(found.used_after, 0);
            let Disagreement { bus, camera, .. } = found.last.speed_disagreement.unwrap();
            assert!((bus / camera - scale).abs() < 0.12 * scale.max(1.0), "{bus} m against {camera} m");
        }
        for stuck_mps in [0.0, 4.0, 60.0] {
            let bus = Bus { stuck: [Some(stuck_mps), None], ..SOUND };
            let after_m = found(seed, 3_000.0, bus, 1.0).speed_after_m.unwrap_or(f64::INFINITY);
            assert!(after_m < 1000.0, "{seed}, stuck at {stuck_mps}: after {after_m} m");
        }
    }
}

#[test]
fn a_wrong_yaw_rate_is_found_within_a_few_turns_and_not_used() {
    for seed in 0..12 {
        for (yaw_scale, within_deg) in [
            (-1.0, 500.0),
            (180.0 / PI, 500.0),
            (PI / 180.0, 800.0),
            (0.0, 800.0),
            (1.5, 3000.0),
            (0.5, 3000.0),
        ] {
            let found = found(seed, 40_000.0, Bus { yaw_scale, ..SOUND }, 1.0);
            let after_deg = found.yaw_rate_after_deg.unwrap_or(f64::INFINITY);
            assert!(after_deg < within_deg, "{seed}, times {yaw_scale}: after {after_deg} degrees");
            assert_eq!(found.speed_after_m, None, "only the yaw rate is wrong");
            assert_eq!(found.used_after, 0);
            let Disagreement { bus, camera, .. } = found.last.yaw_rate_disagreement.unwrap();
            assert!(bus * camera * yaw_scale >= 0.0 || yaw_scale.abs() < 0.1, "{bus} against {camera}");
        }
        let stuck = found(seed, 40_000.0, Bus { stuck: [None, Some(0.1)], ..SOUND }, 1.0);
        assert!(stuck.yaw_rate_after_deg.is_some_and(|after_deg| after_deg < 300.0), "{seed}: stuck");
    }
}

#[test]
fn a_wrong_sign_is_found_within_90_degrees_of_a_winding_road_and_a_sound_bus_never() {
    let mut numbers = Numbers(7);
    for seed in 0..20 {
        let rows = winding(&mut Numbers(seed), 40_000.0);
        let sound = Bus {
            yaw_scale: numbers.between(0.95, 1.05),
            yaw_bias_rps: numbers.between(-0.5, 0.5).to_radians(),
            late_frames: numbers.next() as usize % 4,
            ..SOUND
        };
        let of = |bus: Bus| found_on(&rows, &mut Numbers(seed + 100), bus, 1.0);
        assert_eq!(of(sound).yaw_rate_after_deg, None, "{seed}: {sound:?}");
        let wrong = of(Bus { yaw_scale: -sound.yaw_scale, ..sound });
        let after_deg = wrong.yaw_rate_after_deg.unwrap_or(f64::INFINITY);
        assert!(after_deg < 90.0, "{seed}: after {after_deg} degrees");
        assert_eq!(wrong.used_after, 0);
        let Disagreement { bus, camera, .. } = wrong.last.yaw_rate_disagreement.unwrap();
        assert!(bus * camera < 0.0, "{bus} against {camera}");
    }
}

#[test]
fn a_camera_that_is_a_third_too_high_is_named_against_a_sound_bus() {
    let found = found(3, 3_000.0, SOUND, 1.0 / 1.35);
    assert!(found.speed_after_m.is_some_and(|after_m| after_m < 1000.0), "{:?}", found.speed_after_m);
}

#[test]
fn a_bus_that_agrees_again_is_used_again() {
    let mut signals = VehicleSignals::new(&CanConfig::default());
    let motion = Motion {
        previous_from_current: Isometry2::translation(1.0, 0.0),
        covariance: Matrix3::identity(),
        quality: 0.9,
    };
    let mut frames_until = |speed_mps: f64, source: SignalSource| {
        let samples = VehicleSamples {
            speed_mps: Some(Sample { value: speed_mps, age_s: 0.0 }),
            ..VehicleSamples::default()
        };
        let input = SignalsInput { samples: Some(samples), motion: Some(&motion), dt_s: Some(DT_S) };
        (0..2000).position(|_| signals.step(input).1.speed.source == source).unwrap()
    };
    // 10 m/s: ten frames are 10 m.
    let lost = frames_until(14.0, SignalSource::Camera);
    let back = frames_until(10.0, SignalSource::Can);
    assert!((50..1000).contains(&lost) && (100..1000).contains(&back), "{lost} and {back} frames");
}
