//! GPS positions of a GPX track, matched to frames by time.

use std::path::Path;

use anyhow::{Context, Result, bail};
use fingerpost_map::{LatLon, parse_gpx};

/// A position farther than this in time from every frame belongs to none, seconds: receivers give one a second.
const NEAR_S: f64 = 1.0;

/// The positions of a track by the time since its first.
#[derive(Debug, Default)]
pub(crate) struct GpsTrack {
    positions: Vec<(f64, LatLon)>,
    next: usize,
}

impl GpsTrack {
    /// Reads a GPX track with times.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = fingerpost_io::read_text(path)?;
        let points = parse_gpx(&text).with_context(|| path.display().to_string())?;
        let timed: Vec<(f64, LatLon)> =
            points.iter().filter_map(|point| Some((point.time_s?, point.at))).collect();
        let Some(&(first_s, _)) = timed.first() else {
            bail!(
                "{} has no times, which say to which frames its positions belong; export it with times",
                path.display()
            );
        };
        let mut positions: Vec<(f64, LatLon)> =
            timed.into_iter().map(|(t_s, at)| (t_s - first_s, at)).collect();
        positions.sort_by(|(a_s, _), (b_s, _)| a_s.total_cmp(b_s));
        Ok(Self { positions, next: 0 })
    }

    /// The position taken nearest to `t_s`, seconds since the first frame, if it is not another frame's already. Frames
    /// are asked for in their order.
    pub(crate) fn at(&mut self, t_s: f64) -> Option<LatLon> {
        let off_s = |index: usize| self.positions.get(index).map(|(time_s, _)| (time_s - t_s).abs());
        let mut nearest = self.next;
        while off_s(nearest + 1).zip(off_s(nearest)).is_some_and(|(later_s, now_s)| later_s <= now_s) {
            nearest += 1;
        }
        let near = off_s(nearest).is_some_and(|off_s| off_s <= NEAR_S);
        // A position that is still to come may lie nearer to the next frame; it is used as soon as it has been passed.
        let taken = self.positions.get(nearest).filter(|(time_s, _)| near && *time_s <= t_s)?;
        self.next = nearest + 1;
        Some(taken.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(times_s: &[f64]) -> GpsTrack {
        let position = |&t_s: &f64| (t_s, LatLon::new(48.0 + 0.001 * t_s, 8.0).unwrap());
        GpsTrack { positions: times_s.iter().map(position).collect(), next: 0 }
    }

    #[test]
    fn every_position_goes_to_one_frame() {
        let mut gps = track(&[0.0, 1.0, 2.0]);
        let taken: Vec<usize> = (0..25).filter(|&i| gps.at(0.1 * f64::from(i as u8)).is_some()).collect();
        assert_eq!(taken, [0, 10, 20]);
    }

    #[test]
    fn positions_between_two_slow_frames_give_the_last_of_them() {
        let mut gps = track(&[0.0, 1.0, 2.0, 3.0]);
        assert!(gps.at(0.0).is_some());
        let at = gps.at(2.2).unwrap();
        assert!((at.lat_deg - 48.002).abs() < 1e-9);
    }

    #[test]
    fn a_gap_gives_nothing() {
        let mut gps = track(&[0.0, 10.0]);
        assert!(gps.at(0.0).is_some());
        assert!(gps.at(5.0).is_none());
        assert!(gps.at(12.0).is_none());
    }
}
