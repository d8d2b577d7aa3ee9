//! The vehicle's motion out of a recording's twists and inertial unit, each along the axes of its frame.

use fingerpost_io::bag::{AxesSource, Frames, Inertial, Twist, VehicleMotion};

/// Half of what gravity makes a unit at rest show, m/s²: less is an accelerometer that has gravity taken out, or none.
const LEAST_GRAVITY_MPS2: f64 = 9.806_65 / 2.0;

/// What a recording says of the vehicle's motion.
#[derive(Debug, Default)]
pub(super) struct RecordedMotion {
    /// By time, nanoseconds; of two at once the first.
    pub(super) rows: Vec<(u64, VehicleMotion)>,
    /// Which source gives what, and by which axes.
    pub(super) said: Vec<String>,
    /// Why messages could not be used, each.
    pub(super) passed_over: Vec<String>,
}

/// The motion of messages, which are brought into the order of time.
pub(super) fn motion(
    twists: &mut [(u64, Twist)],
    inertial: &mut [(u64, Inertial)],
    frames: &Frames,
) -> RecordedMotion {
    twists.sort_by_key(|(at_ns, _)| *at_ns);
    inertial.sort_by_key(|(at_ns, _)| *at_ns);
    let mut recorded = RecordedMotion::default();
    for (at_ns, twist) in twists.iter() {
        match twist.of_vehicle(frames) {
            Ok(motion) if recorded.rows.last().is_none_or(|(last_ns, _)| last_ns != at_ns) => {
                recorded.rows.push((*at_ns, motion));
            }
            // A log's times grow.
            Ok(_) => {}
            Err(cause) => recorded.passed_over.push(cause.to_string()),
        }
    }
    if recorded.rows.is_empty() {
        if !inertial.is_empty() {
            let cause = "an inertial unit without a speed gives no motion.csv; record the vehicle's twist or odometry too";
            recorded.said.push(cause.to_owned());
        }
        return recorded;
    }
    let twist_frame = twists.first().map_or("", |(_, twist)| &twist.frame_id);
    if frames.axes(twist_frame).source() != AxesSource::Body {
        recorded.said.push(format!("speed: that of the twist in {}", frame_in_words(frames, twist_frame)));
    }
    let Some((_, first)) = inertial.first() else { return recorded };
    if let Some(cause) = contradiction(inertial, frames, &first.frame_id) {
        recorded.said.push(format!("{cause}; the yaw rate is that of the twist"));
        return recorded;
    }
    recorded.said.push(format!(
        "yaw rate: that of the inertial unit in {}; the twist's is not used",
        frame_in_words(frames, &first.frame_id)
    ));
    // An inertial unit measures the turn itself, where a twist may come from wheels.
    for (at_ns, motion) in &mut recorded.rows {
        let newest = inertial.partition_point(|(unit_ns, _)| unit_ns <= at_ns).checked_sub(1);
        if let Some((_, Inertial { frame_id, angular_rps, .. })) = newest.and_then(|i| inertial.get(i)) {
            [.., motion.yaw_rate_rps] = frames.axes(frame_id).in_vehicle(*angular_rps);
        }
    }
    recorded
}

fn frame_in_words(frames: &Frames, frame_id: &str) -> String {
    format!("frame {frame_id:?}, {}", frames.axes(frame_id).source().words())
}

/// Where gravity says that the unit's axes are not those of its frame: on the mean it pushes a vehicle up.
fn contradiction(inertial: &[(u64, Inertial)], frames: &Frames, frame_id: &str) -> Option<String> {
    let shown = inertial.iter().filter_map(|(_, unit)| {
        Some(frames.axes(&unit.frame_id).in_vehicle(unit.acceleration_mps2?)).filter(is_finite)
    });
    let (mut sum, mut count) = ([0.0; 3], 0);
    for acceleration in shown {
        sum = [0, 1, 2].map(|axis| sum[axis] + acceleration[axis]);
        count += 1;
    }
    let [forward, left, up] = sum.map(|sum| sum / f64::from(count.max(1)));
    let across = libm::hypot(forward, left);
    // More to the side than up: turned by more than 45 degrees, which no road does.
    (libm::hypot(across, up) > LEAST_GRAVITY_MPS2 && up < across).then(|| {
        format!(
            "the inertial unit in {} is pushed by gravity along [{forward:.1}, {left:.1}, {up:.1}] (forward, left, up), which is not up, so \
             that its axes are others; record /tf_static with base_link, or name its frame by REP 103",
            frame_in_words(frames, frame_id)
        )
    })
}

fn is_finite(vector: &[f64; 3]) -> bool {
    vector.iter().all(|part| part.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twist(frame_id: &str, linear_mps: [f64; 3], angular_rps: [f64; 3]) -> Twist {
        Twist { frame_id: frame_id.to_owned(), linear_mps, angular_rps }
    }

    fn unit(frame_id: &str, angular_rps: [f64; 3], acceleration_mps2: Option<[f64; 3]>) -> Inertial {
        Inertial { frame_id: frame_id.to_owned(), angular_rps, acceleration_mps2 }
    }

    fn moved(twist: &Twist, unit: Option<Inertial>) -> (Option<(f64, f64)>, String) {
        let mut units: Vec<_> = unit.map(|unit| (5, unit)).into_iter().collect();
        let found = motion(&mut [(7, twist.clone()), (7, twist.clone())], &mut units, &Frames::default());
        assert!(found.rows.len() < 2, "of two at once the first");
        let motion = found.rows.first().map(|(_, motion)| (motion.speed_mps, motion.yaw_rate_rps));
        (motion, [found.said, found.passed_over].concat().join("; "))
    }

    #[test]
    fn each_source_is_read_along_its_own_axes() {
        let body = twist("base_link", [8.0, 0.1, 0.0], [0.0, 0.0, 0.3]);
        let up = Some([0.0, -9.8, 0.1]);
        for (twist, unit, expected, word) in [
            (&body, None, (8.0, 0.3), ""),
            (&body, Some(unit("cam_imu_optical_frame", [0.01, -0.289, 0.01], None)), (8.0, 0.289), "optical"),
            (&body, Some(unit("imu_optical", [0.01, -0.289, 0.01], up)), (8.0, 0.289), "minus y"),
            (
                &body,
                Some(unit("imu_link", [0.0, 0.0, 0.289], Some([0.3, 0.0, 9.8]))),
                (8.0, 0.289),
                "up is z",
            ),
            // Gravity along minus y in a frame that is said to be a body's.
            (&body, Some(unit("imu_link", [0.01, -0.289, 0.01], up)), (8.0, 0.3), "not up"),
            (&twist("camera_optical", [0.1, 0.0, 8.0], [0.0, -0.3, 0.0]), None, (8.0, 0.3), "speed"),
        ] {
            let (motion, said) = moved(twist, unit);
            assert_eq!(motion, Some(expected), "{said}");
            assert!(said.contains(word), "{said}");
        }
    }

    #[test]
    fn a_twist_along_axes_on_the_ground_is_passed_over() {
        let (motion, said) = moved(&twist("map", [8.0, 0.0, 0.0], [0.0, 0.0, 0.3]), None);
        assert_eq!(motion, None);
        assert!(said.contains("\"map\"") && said.contains("base_link"), "{said}");
    }
}
