//! GPS positions of a track, matched to frames by their times.

use std::path::Path;

use anyhow::{Result, bail};
use fingerpost_map::{GpsClock, LatLon};

use crate::arguments::InputLimit;
use crate::{inputs, output};

/// A position farther than this in time from every frame belongs to none, seconds: receivers give one a second.
const NEAR_S: f64 = 1.0;

/// A position farther than this in time from the middle one is none of the drive's, seconds: no drive takes half a day, and a
/// receiver that has just been switched on says 1980 or a day a thousand weeks ago.
const DRIVE_S: f64 = 43_200.0;

/// Seconds of the day with which the clock of a track begins that counts from the first frame, as `convert` writes it: no receiver
/// says 1970, and a drive ends within a day.
const DRIVE_CLOCK_S: std::ops::Range<f64> = 0.0..86_400.0;

/// What the times of a track count from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Clock {
    /// Its first position, which belongs to the first frame.
    #[default]
    Own,
    /// The first frame.
    Drive,
}

/// The positions of a track by time.
#[derive(Debug, Default)]
pub(crate) struct GpsTrack {
    clock: Clock,
    positions: Vec<(f64, LatLon)>,
    next: usize,
    /// Whether one of them has been given to a frame.
    is_used: bool,
}

/// What of a track's positions is not as in the log of one drive.
#[derive(Debug, Default, PartialEq, Eq)]
struct TrackFaults {
    /// Positions that were passed over because another place has their time.
    at_one_time: usize,
    /// Positions that belong to no drive with most of the others: the place of the first in the file, from zero, and how many there are.
    of_other_times: Option<(usize, usize)>,
    /// The latest stands first, and each before the one that came before it.
    is_backwards: bool,
    /// Positions that are too early for the first frame, which the first of them in the file belongs to.
    before_first: usize,
}

impl GpsTrack {
    /// Reads a track with times, and says what of it is not as in the log of one drive.
    pub(crate) fn read(path: &Path, limit: InputLimit) -> Result<Self> {
        let log = inputs::gps_log(path, limit)?;
        let timed: Vec<(f64, LatLon)> =
            log.points.iter().filter_map(|point| Some((point.time_s?, point.at))).collect();
        let (track, faults) = Self::of(timed, log.clock);
        let name = path.display();
        if track.positions.is_empty() {
            bail!(
                "{name} has no times, which say to which frames its positions belong; export it with times"
            );
        }
        let TrackFaults { at_one_time, of_other_times, is_backwards, before_first } = faults;
        if at_one_time > 0 && track.positions.len() == 1 {
            bail!(
                "{name} has no times that tell its positions apart: all {} of them are of one moment; export it with the time of each, or \
                 leave --gps out",
                at_one_time + 1
            );
        }
        let say = |fault: String| output::message(&format!("{name}: {fault}"));
        if log.clock == GpsClock::Midnight {
            say("its sentences (GGA) give the time of day and no date; its first position is taken to belong to the first frame".to_owned());
        }
        if is_backwards {
            say("its positions stand in falling order of their times; they are used in rising order"
                .to_owned());
        }
        if at_one_time > 0 {
            say(format!(
                "{at_one_time} positions are passed over, which have the time of another place before them"
            ));
        }
        let first_timed = log.points.iter().position(|point| point.time_s.is_some()).unwrap_or_default();
        if first_timed > 0 && track.clock == Clock::Own && !is_backwards {
            say(format!(
                "its first {first_timed} positions have no time; position {} is taken to belong to the first frame",
                first_timed + 1
            ));
        }
        if before_first > 0 {
            say(format!(
                "{before_first} of its positions were taken before its first one, which is taken to belong to the first frame, and belong \
                 to no frame; sort the track by time where that is not so"
            ));
        }
        if let Some((first, count)) = of_other_times {
            say(format!(
                "{count} positions are passed over, of times more than {:.0} hours from the rest; the first of them is its position {}",
                DRIVE_S / 3600.0,
                first + 1
            ));
        }
        Ok(track)
    }

    /// The positions by time, seconds on the log's clock, from the first of the drive.
    fn of(timed: Vec<(f64, LatLon)>, log_clock: GpsClock) -> (Self, TrackFaults) {
        let mut times_s: Vec<f64> = timed.iter().map(|(t_s, _)| *t_s).collect();
        times_s.sort_by(f64::total_cmp);
        let middle_s = times_s.get(times_s.len() / 2).copied().unwrap_or_default();
        let of_drive = |t_s: f64| (t_s - middle_s).abs() <= DRIVE_S;
        let first_other = timed.iter().position(|(t_s, _)| !of_drive(*t_s));
        let others = timed.iter().filter(|(t_s, _)| !of_drive(*t_s)).count();
        let mut positions: Vec<(f64, LatLon)> = timed.into_iter().filter(|(t_s, _)| of_drive(*t_s)).collect();
        // A few that are out of order are the receiver's; most are, where the track is stored from its end.
        let steps = |falls: fn(f64, f64) -> bool| {
            positions.windows(2).filter(|pair| falls(pair[0].0, pair[1].0)).count()
        };
        let is_backwards = steps(|before_s, t_s| t_s < before_s) > steps(|before_s, t_s| t_s > before_s);
        if is_backwards {
            positions.reverse();
        }
        // The first one belongs to the first frame, whatever clock it has, unless that is the drive's own.
        let counts_from_frame = log_clock == GpsClock::Utc && DRIVE_CLOCK_S.contains(&middle_s);
        let clock = if counts_from_frame { Clock::Drive } else { Clock::Own };
        let first_s = positions.first().filter(|_| clock == Clock::Own).map_or(0.0, |(t_s, _)| *t_s);
        positions.iter_mut().for_each(|(t_s, _)| *t_s -= first_s);
        positions.sort_by(|(a_s, _), (b_s, _)| a_s.total_cmp(b_s));
        let mut at_one_time = 0;
        positions.dedup_by(|(later_s, later), (earlier_s, earlier)| {
            let same_time = later_s.total_cmp(earlier_s).is_eq();
            at_one_time += usize::from(same_time && later != earlier);
            same_time
        });
        let is_too_early = |t_s: f64| clock == Clock::Own && t_s < -NEAR_S;
        let faults = TrackFaults {
            at_one_time,
            of_other_times: first_other.map(|first| (first, others)),
            is_backwards,
            before_first: positions.iter().filter(|(t_s, _)| is_too_early(*t_s)).count(),
        };
        (Self { clock, positions, ..Self::default() }, faults)
    }

    /// That none of its positions belonged to a frame, where that is so: a sentence.
    pub(crate) fn unused(&self) -> Option<String> {
        let (first, last) = self.positions.first().zip(self.positions.last()).filter(|_| !self.is_used)?;
        Some(format!(
            "none of the {} GPS positions was used: they were taken {:.0} to {:.0} s after the first frame, and none within a second of \
             a frame; give the track of this drive",
            self.positions.len(),
            first.0,
            last.0
        ))
    }

    /// All positions, in the order of their times.
    pub(crate) fn positions(&self) -> impl Iterator<Item = LatLon> {
        self.positions.iter().map(|(_, at)| *at)
    }

    /// The position for a row of a motion log at `t_s` whose first row has `first_s`, as [`Self::at`].
    pub(crate) fn at_row(&mut self, t_s: f64, first_s: f64) -> Option<LatLon> {
        self.at(if self.clock == Clock::Drive { t_s } else { t_s - first_s })
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
        let at = taken.1;
        self.next = nearest + 1;
        self.is_used = true;
        Some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(times_s: &[f64]) -> GpsTrack {
        let position = |&t_s: &f64| (t_s, LatLon::new(48.0 + 0.001 * t_s, 8.0).unwrap());
        GpsTrack { positions: times_s.iter().map(position).collect(), ..GpsTrack::default() }
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
    fn a_receiver_that_wakes_up_in_another_year_spoils_no_other_position() {
        let at = LatLon::new(48.0, 8.0).unwrap();
        let drive: Vec<(f64, LatLon)> = (0..60).map(|i| (1.7e9 + f64::from(i), at)).collect();
        for (place, wrong_s) in [(0, 3.2e8), (0, 0.0), (30, 4.0e9), (59, -6e10), (7, 1.7e9 + 1e5)] {
            let mut timed = drive.clone();
            timed.insert(place, (wrong_s, at));
            let (track, faults) = GpsTrack::of(timed, GpsClock::Utc);
            assert_eq!((faults.of_other_times, faults.is_backwards), (Some((place, 1)), false));
            let times_s: Vec<f64> = track.positions.iter().map(|(t_s, _)| *t_s).collect();
            assert_eq!(times_s, (0..60).map(f64::from).collect::<Vec<_>>());
        }
        assert_eq!(GpsTrack::of(drive, GpsClock::Utc).1, TrackFaults::default());
    }

    #[test]
    fn times_of_the_drive_itself_stay() {
        let at = LatLon::new(48.0, 8.0).unwrap();
        let times_s = |since_s: f64, clock: GpsClock| {
            let timed = [0.7, 1.7, 2.7].map(|t_s| (since_s + t_s, at)).to_vec();
            let (track, _) = GpsTrack::of(timed, clock);
            track.positions.iter().map(|(t_s, _)| (10.0 * t_s).round()).collect::<Vec<_>>()
        };
        assert_eq!(times_s(0.0, GpsClock::Utc), [7.0, 17.0, 27.0]);
        assert_eq!(times_s(1.7e9, GpsClock::Utc), [0.0, 10.0, 20.0]);
    }

    #[test]
    fn times_of_day_count_from_the_first_at_any_hour() {
        let at = LatLon::new(48.0, 8.0).unwrap();
        for hour in 0..24 {
            let timed = [0.0, 1.0, 2.0].map(|t_s| (3600.0 * f64::from(hour) + t_s, at)).to_vec();
            let (mut track, _) = GpsTrack::of(timed, GpsClock::Midnight);
            let used = (0..3).filter(|&t_s| track.at(f64::from(t_s)).is_some()).count();
            assert_eq!(used, 3, "{hour} o'clock");
        }
    }

    #[test]
    fn a_track_that_is_stored_from_its_end_is_the_same_track() {
        let place = |t_s: f64| (1.7e9 + t_s, LatLon::new(48.0 + 0.001 * t_s, 8.0).unwrap());
        let drive: Vec<_> = (0..60).map(f64::from).map(place).collect();
        let (track, faults) = GpsTrack::of(drive.iter().rev().copied().collect(), GpsClock::Utc);
        assert_eq!(faults, TrackFaults { is_backwards: true, ..TrackFaults::default() });
        assert_eq!(track.positions, GpsTrack::of(drive.clone(), GpsClock::Utc).0.positions);
        // Of two halves that are exchanged the second one's beginning stays the first frame's, and the rest is said.
        let exchanged = [&drive[30..], &drive[..30]].concat();
        let (track, faults) = GpsTrack::of(exchanged, GpsClock::Utc);
        assert_eq!(faults, TrackFaults { before_first: 29, ..TrackFaults::default() });
        assert!(track.positions.iter().any(|(t_s, at)| *t_s == 0.0 && *at == drive[30].1));
    }

    #[test]
    fn of_several_places_at_one_time_the_first_counts() {
        let place = |north: f64| LatLon::new(48.0 + north, 8.0).unwrap();
        let of = |timed: Vec<(f64, LatLon)>| GpsTrack::of(timed, GpsClock::Utc);
        let (stuck, faults) = of((0..60).map(|i| (1.7e9, place(0.001 * f64::from(i)))).collect());
        assert_eq!((stuck.positions.len(), faults.at_one_time), (1, 59));
        let (still, faults) = of(vec![(1.7e9, place(0.0)); 60]);
        assert_eq!((still.positions.len(), faults.at_one_time), (1, 0), "one place said several times");
        let timed =
            [(0.0, 0.0), (1.0, 0.1), (1.0, 0.2), (2.0, 0.3)].map(|(t_s, north)| (1.7e9 + t_s, place(north)));
        let (track, _) = of(timed.to_vec());
        assert_eq!(track.positions.iter().map(|(_, at)| *at).collect::<Vec<_>>(), [0.0, 0.1, 0.3].map(place));
    }

    #[test]
    fn a_track_of_another_time_is_named() {
        let mut gps = track(&[7200.0, 7201.0]);
        assert!((0..50).all(|i| gps.at(0.1 * f64::from(i)).is_none()));
        assert!(gps.unused().is_some_and(|said| said.contains("7200 to 7201 s after the first frame")));
        let mut gps = track(&[0.0, 1.0]);
        assert!(gps.at(0.0).is_some() && gps.unused().is_none());
    }

    #[test]
    fn a_gap_gives_nothing() {
        let mut gps = track(&[0.0, 10.0]);
        assert!(gps.at(0.0).is_some());
        assert!(gps.at(5.0).is_none());
        assert!(gps.at(12.0).is_none());
    }
}
