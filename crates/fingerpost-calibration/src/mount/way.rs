//! The way of a drive in heights of the camera, which a known way turns into a height.

use nalgebra::Vector3;

use super::cadence::{Beside, Cadence, SeenWay};
use super::frame_intervals::frame_intervals_s;
use super::road_plane::RoadPlane;
use super::{Estimated, LEAST_ROAD, Look};

/// Share of a measured length that texture and waves of the road leave uncertain.
pub(super) const LENGTH_FLOOR: f64 = 0.01;

/// What a tyre holds at the most, m/s²: as much as gravity presses on it.
const MOST_ACCELERATION_MPS2: f64 = 9.806_65;

/// A way in heights of the camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) heights: f64,
    sigma_share: f64,
    /// By how much it may be another as frames are missing where it is not seen, as a share of it.
    unseen_share: f64,
    /// Frames that repeat the one before, and those that are missing between others.
    pub(super) repeated: usize,
    pub(super) missing: usize,
    /// By how much the time that passed may be another than the frames say, as a share of it.
    time_share: f64,
}

impl Way {
    /// What repeated and missing frames leave open of a height by a known distance, as a share of it.
    pub(super) const fn open_by_distance(&self) -> f64 {
        self.unseen_share
    }

    /// The same of a height by a known speed, to which the time belongs.
    pub(super) fn open_by_speed(&self) -> f64 {
        libm::hypot(self.unseen_share, self.time_share)
    }

    /// The height at which the way is so long, of which frames leave the share `open`.
    pub(super) fn height(&self, way_m: f64, open: f64) -> Estimated {
        let value = way_m / self.heights;
        Estimated { value, sigma: value * libm::hypot(self.sigma_share, open) }
    }
}

/// The way of the whole drive in heights of the camera, which is roughly `height_m` metres, when the road's normal is `normal`: as
/// each frame shows it, and where one does not, as its neighbours do.
pub(super) fn way(looks: &[Look], normal: &Vector3<f64>, height_m: f64) -> Option<Way> {
    let (first, last) = looks.first().zip(looks.last())?;
    let mean_s = (last.t_s - first.t_s) / (looks.len() - 1).max(1) as f64;
    let stamps_s: Vec<f64> = looks.iter().map(|look| look.t_s).collect();
    // How long each frame but the first took, in mean ones.
    let lengths: Vec<f64> =
        frame_intervals_s(&stamps_s).iter().map(|interval_s| interval_s / mean_s).collect();
    let seen: Vec<SeenWay> =
        looks.iter().skip(1).zip(&lengths).map(|(look, length)| seen(look, *length, normal)).collect();
    let least_jump = MOST_ACCELERATION_MPS2 * mean_s * mean_s / height_m;
    let (seen, doubtful) = without_false_stands(seen, least_jump);
    let ways: Vec<Option<f64>> = seen.iter().map(|seen| seen.way).collect();
    if ways.iter().flatten().filter(|way| **way > 0.0).count() < LEAST_ROAD {
        return None;
    }
    let cadence = Cadence::of(&seen, least_jump);
    let (repeated, missing) = cadence.as_ref().map_or((0, 0), |cadence| (cadence.repeated, cadence.missing));
    // Where the intervals cannot be counted, any time may have passed.
    let time_share = cadence.as_ref().map_or(0.0, |cadence| {
        cadence.intervals_per_frame.map_or(1.0, |intervals_per_frame| (1.0 - intervals_per_frame).abs())
    });
    let unseen_share =
        cadence.as_ref().map_or(0.0, |cadence| cadence.unseen_share) + doubtful as f64 / seen.len() as f64;
    let steps = match cadence {
        Some(cadence) => cadence.ways,
        None => (0..ways.len()).map(|frame| middle_of_neighbours(&ways, frame)).collect(),
    };
    let heights: f64 = steps.iter().zip(&lengths).map(|(step, length)| step * length).sum();
    // Differences of neighbours show the noise of a frame.
    let noise: Vec<f64> =
        ways.iter().zip(&steps).filter_map(|(seen, step)| Some(((*seen)? - step).powi(2))).collect();
    let seen_variance: f64 = noise.iter().sum();
    let sigma_share = libm::hypot(
        (seen_variance + unseen_variance(&ways, &lengths, seen_variance / noise.len() as f64)).sqrt()
            / heights,
        LENGTH_FLOOR,
    );
    Some(Way { heights, sigma_share, unseen_share, repeated, missing, time_share })
}

/// What a frame that took so many mean ones shows.
fn seen(look: &Look, length: f64, normal: &Vector3<f64>) -> SeenWay {
    let way = match (&look.plane, &look.sighting) {
        (Some(plane), _) => Some(plane.way_with_normal(normal) / length),
        // A vehicle that stands makes no way.
        (None, Some(sighting)) if !sighting.moves => Some(0.0),
        _ => None,
    };
    let way = way.filter(|way| way.is_finite());
    let least_share = look.sighting.map_or(0.0, |sighting| sighting.least_way_share());
    SeenWay { way, least: way.unwrap_or_default() * least_share, is_still: look.is_still }
}

/// What frames show, with stands only where a vehicle can have stopped: beside a frame that moves too fast for that by `least_jump`, the
/// change of the way from one frame to the next that no tyre brings about, and beside none that is slow enough, a frame that shows no motion
/// is one in which it cannot be seen. So are those beside which no way is seen; how many of these there are in a row with others is given
/// as well, as the vehicle may have stood there. Frames that repeat the one before are the cadence's.
fn without_false_stands(mut seen: Vec<SeenWay>, least_jump: f64) -> (Vec<SeenWay>, usize) {
    let is_at_rest = |seen: &SeenWay| seen.way == Some(0.0);
    let (mut start, mut doubtful) = (0, 0);
    while start < seen.len() {
        let is_rest = is_at_rest(&seen[start]);
        let end = start + seen[start..].iter().take_while(|seen| is_at_rest(seen) == is_rest).count();
        let beside = Beside::of(&seen, start..end, least_jump);
        if is_rest && beside != Beside::Slow {
            let unseen = seen[start..end].iter_mut().filter(|seen| !seen.is_still);
            let count = unseen.map(|seen| seen.way = None).count();
            doubtful += if beside == Beside::Unseen && count > 1 { count } else { 0 };
        }
        start = end;
    }
    (seen, doubtful)
}

/// Frames of whose ways one may be wrong and the median is not.
const LEAST_FOR_MEDIAN: usize = 3;

/// Variance of the way in frames that do not show it: those in a row all have that of the frames about them, with one error of
/// `frame_variance`.
fn unseen_variance(ways: &[Option<f64>], lengths: &[f64], frame_variance: f64) -> f64 {
    let mut start = 0;
    let runs = ways.chunk_by(|a, b| a.is_some() == b.is_some()).map(|run| {
        let run_lengths = &lengths[start..start + run.len()];
        start += run.len();
        if run[0].is_some() { 0.0 } else { run_lengths.iter().sum() }
    });
    runs.map(|length: f64| frame_variance * length * length).sum()
}

/// Median of what a frame and its two neighbours to either side show; where fewer than three show something, of the nearest three.
fn middle_of_neighbours(seen: &[Option<f64>], frame: usize) -> f64 {
    for reach in 2..seen.len().max(3) {
        let near = &seen[frame.saturating_sub(reach)..(frame + reach + 1).min(seen.len())];
        let mut values: Vec<f64> = near.iter().flatten().copied().collect();
        if values.len() >= LEAST_FOR_MEDIAN {
            values.sort_unstable_by(f64::total_cmp);
            return values[values.len() / 2];
        }
    }
    0.0
}

/// Way of a frame in heights of the camera, the median.
pub(super) fn typical_way(roads: &[RoadPlane], normal: &Vector3<f64>) -> Option<f64> {
    let mut ways: Vec<f64> = roads.iter().map(|plane| plane.way_with_normal(normal)).collect();
    ways.sort_unstable_by(f64::total_cmp);
    ways.get(ways.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_in_a_row_that_show_no_way_have_one_error() {
        let ways = [None, Some(1.0), None, None, Some(1.0)];
        assert!((unseen_variance(&ways, &[1.0, 1.0, 2.0, 1.0, 1.0], 0.5) - 0.5 * (1.0 + 9.0)).abs() < 1e-12);
        assert!(unseen_variance(&[], &[], 0.5) <= 0.0);
    }

    #[test]
    fn a_stand_is_believed_beside_frames_as_slow_as_stopping_and_starting() {
        let of = |ways: &[Option<f64>]| -> Vec<SeenWay> {
            ways.iter().map(|&way| SeenWay { way, least: 0.0, is_still: false }).collect()
        };
        let kept = |ways: &[Option<f64>]| -> Vec<Option<f64>> {
            without_false_stands(of(ways), 0.2).0.iter().map(|seen| seen.way).collect()
        };
        let stopping = [Some(0.3), Some(0.15), Some(0.0), Some(0.0), Some(0.0), Some(0.1), None];
        assert_eq!(kept(&stopping), stopping);
        assert_eq!(kept(&[None, Some(0.0), None]), [None, None, None]);
        assert_eq!(kept(&[Some(0.0), Some(0.9)]), [None, Some(0.9)]);
        assert_eq!(kept(&[Some(0.9), Some(0.0), Some(0.9)]), [Some(0.9), None, Some(0.9)]);
        // However many frames show no motion, nobody stops from a full speed in one.
        let [moved, rest] = [[Some(0.9)], [Some(0.0)]];
        let unseen = [&moved[..], &[None; 5], &moved].concat();
        assert_eq!(kept(&[&moved[..], &rest.repeat(5), &moved].concat()), unseen);
        assert_eq!(kept(&[&rest.repeat(5), &moved[..]].concat()), unseen[1..]);
        // Whether a vehicle stands that was not seen before and behind is in doubt.
        let night = of(&[&[None], &rest.repeat(5)[..], &[None]].concat());
        assert_eq!(without_false_stands(night, 0.2), (of(&[None; 7]), 5));
        // A picture that comes again is the cadence's.
        let repeated = SeenWay { way: Some(0.0), least: 0.0, is_still: true };
        let [filled, fast] = [[repeated; 3].to_vec(), of(&moved)];
        let after = [&fast[..], &filled, &of(&rest), &fast].concat();
        let hidden = [&fast[..], &filled, &of(&[None]), &fast].concat();
        assert_eq!(without_false_stands(after, 0.2), (hidden, 0));
    }

    #[test]
    fn a_vehicle_that_is_lost_from_sight_as_it_stops_stands() {
        // Slower than a third of a height a frame it is not seen to move.
        let slow = |way: f64| SeenWay { way: Some(way), least: 0.3, is_still: false };
        let stop = [slow(0.45), slow(0.4), slow(0.0), slow(0.0), slow(0.0), slow(0.35), slow(0.4)];
        assert_eq!(without_false_stands(stop.to_vec(), 0.2), (stop.to_vec(), 0));
    }
}
