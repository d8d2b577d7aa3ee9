//! What has come and waits to be used: pictures in their order, and the newest GPS position and twist before each.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use fingerpost_format::CameraInfo;
use fingerpost_io::bag::{AxesSource, Content, Frames, GpsPosition, Message, Picture, VehicleMotion};

use crate::health::{Input, TopicCount};

/// A position or twist older than this says nothing of the picture at hand, nanoseconds: receivers give one position a second.
const NEW_NS: u64 = 1_000_000_000;
/// Measurements that may wait for a picture: a second of the fastest inertial units' rate is 400, of wheels' 100.
const MOST_WAITING: usize = 512;

/// A picture with what was measured up to it.
#[derive(Debug)]
pub struct Arrival {
    /// Number of the picture, from zero; bad and dropped ones count.
    pub number: u64,
    /// The picture with its stamp, nanoseconds, or why it cannot be used.
    pub picture: Result<(u64, Picture), String>,
    /// The newest GPS position of the second before it, once.
    pub gps: Option<GpsPosition>,
    /// The newest twist of the second before it.
    pub twist: Option<VehicleMotion>,
    /// When it came.
    pub came: Instant,
}

/// Where the receiving thread puts what comes.
#[derive(Debug)]
pub(crate) struct Inbox {
    state: Mutex<State>,
    changed: Condvar,
    /// Pictures that may wait.
    depth: usize,
}

#[derive(Debug, Default)]
struct State {
    pictures: VecDeque<Arrival>,
    next_number: u64,
    last_stamp_ns: Option<u64>,
    dropped: u64,
    calibration: Option<CameraInfo>,
    gps: VecDeque<(u64, GpsPosition)>,
    twist: VecDeque<(u64, VehicleMotion)>,
    counts: [TopicCount; Input::ALL.len()],
}

impl Inbox {
    pub(crate) fn new(depth: usize) -> Self {
        Self { state: Mutex::default(), changed: Condvar::new(), depth: depth.max(1) }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes in a message of an input, or why it cannot be used.
    pub(crate) fn put(&self, input: Input, message: Result<Message, String>) {
        let mut state = self.lock();
        let count = &mut state.counts[input as usize];
        count.received += 1;
        count.last = Some(Instant::now());
        if input == Input::Pictures {
            let picture = message.and_then(|message| state.picture(message));
            state.add_picture(picture, self.depth);
            self.changed.notify_one();
        } else if let Err(cause) = message.and_then(|message| state.measurement(message)) {
            state.counts[input as usize].refuse(cause);
        }
    }

    /// The oldest picture that waits, or the next one if it comes within `longest`.
    pub(crate) fn next(&self, longest: Duration) -> Option<Arrival> {
        let state = self.lock();
        let waited = self.changed.wait_timeout_while(state, longest, |state| state.pictures.is_empty());
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        let mut arrival = state.pictures.pop_front()?;
        if let Ok((stamp_ns, _)) = arrival.picture {
            arrival.gps = newest(&mut state.gps, stamp_ns);
            arrival.twist = newest(&mut state.twist, stamp_ns);
        }
        Some(arrival)
    }

    /// The newest calibration that has come.
    pub(crate) fn calibration(&self) -> Option<CameraInfo> {
        self.lock().calibration.clone()
    }

    /// Pictures that waited too long and made room for later ones.
    pub(crate) fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    /// What has come of an input.
    pub(crate) fn count(&self, input: Input) -> TopicCount {
        self.lock().counts[input as usize].clone()
    }

    /// Says that a picture that was given out turned out to be none.
    pub(crate) fn refuse_picture(&self, cause: String) {
        self.lock().counts[Input::Pictures as usize].refuse(cause);
    }
}

impl State {
    fn picture(&mut self, message: Message) -> Result<(u64, Picture), String> {
        let stamp_ns = message.stamp_ns.ok_or_else(|| {
            "a picture has no stamp; have its driver set header.stamp to the time at which it was taken"
                .to_owned()
        })?;
        if let Some(last_ns) = self.last_stamp_ns.filter(|last_ns| stamp_ns <= *last_ns) {
            return Err(format!(
                "a picture's stamp lies {:.3} s behind that of the picture before it; start fingerpost again if the sender's clock was set \
                 or its bag begins anew",
                (last_ns - stamp_ns) as f64 * 1e-9
            ));
        }
        let Content::Picture(picture) = message.content else {
            return Err("a message of the topic of pictures is none".to_owned());
        };
        self.last_stamp_ns = Some(stamp_ns);
        Ok((stamp_ns, picture))
    }

    fn add_picture(&mut self, picture: Result<(u64, Picture), String>, depth: usize) {
        if let Err(cause) = &picture {
            self.counts[Input::Pictures as usize].refuse(cause.clone());
        }
        if self.pictures.len() >= depth {
            self.pictures.pop_front();
            self.dropped += 1;
        }
        let came = Instant::now();
        self.pictures.push_back(Arrival { number: self.next_number, picture, gps: None, twist: None, came });
        self.next_number += 1;
    }

    fn measurement(&mut self, message: Message) -> Result<(), String> {
        let stamp = |name: &str| {
            message.stamp_ns.ok_or_else(|| format!("a {name} has no stamp; have its sender set header.stamp"))
        };
        match message.content {
            Content::Calibration(calibration) => self.calibration = Some(calibration),
            Content::Gps(Some(position)) => keep(&mut self.gps, stamp("position")?, position),
            Content::Twist(twist) => {
                // Transforms are not listened to, so that the frame's name says all.
                let axes = Frames::default().axes(&twist.frame_id);
                let motion = twist.of_vehicle(&axes).map_err(|cause| cause.to_string())?;
                keep(&mut self.twist, stamp("twist")?, motion);
                if axes.source() == AxesSource::Guessed {
                    self.counts[Input::Twist as usize].guess(|| {
                        format!(
                            "it is in frame {:?}, {}; where it is not, have its sender give it in base_link",
                            twist.frame_id,
                            axes.source().words()
                        )
                    });
                }
            }
            Content::Gps(None) | Content::Picture(_) | Content::Inertial(_) | Content::Transforms(_) => {}
        }
        Ok(())
    }
}

/// Adds a measurement, in the order in which they come.
fn keep<T>(waiting: &mut VecDeque<(u64, T)>, stamp_ns: u64, value: T) {
    if waiting.len() == MOST_WAITING {
        waiting.pop_front();
    }
    waiting.push_back((stamp_ns, value));
}

/// The newest measurement up to a time, if it is new; those before it go.
fn newest<T>(waiting: &mut VecDeque<(u64, T)>, until_ns: u64) -> Option<T> {
    let mut newest = None;
    while waiting.front().is_some_and(|(stamp_ns, _)| *stamp_ns <= until_ns) {
        newest = waiting.pop_front();
    }
    newest.filter(|(stamp_ns, _)| until_ns - stamp_ns <= NEW_NS).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use fingerpost_io::bag::Twist;

    use super::*;

    const MS: u64 = 1_000_000;

    fn picture(stamp_ns: u64) -> Result<Message, String> {
        let content = Content::Picture(Picture::Jpeg(vec![0xFF, 0xD8]));
        Ok(Message { stamp_ns: (stamp_ns > 0).then_some(stamp_ns), content })
    }

    fn twist(stamp_ns: u64, speed_mps: f64) -> Result<Message, String> {
        twist_in("base_link", stamp_ns, speed_mps)
    }

    fn twist_in(frame_id: &str, stamp_ns: u64, speed_mps: f64) -> Result<Message, String> {
        let content = Content::Twist(Twist {
            frame_id: frame_id.into(),
            linear_mps: [speed_mps, 0.0, 0.0],
            angular_rps: [0.0; 3],
        });
        Ok(Message { stamp_ns: Some(stamp_ns), content })
    }

    fn all(inbox: &Inbox) -> Vec<Arrival> {
        std::iter::from_fn(|| inbox.next(Duration::ZERO)).collect()
    }

    #[test]
    fn a_picture_has_the_newest_twist_before_it_and_none_of_later() {
        let inbox = Inbox::new(5);
        for (at, speed_mps) in [(10, 1.0), (20, 2.0), (60, 3.0)] {
            inbox.put(Input::Twist, twist(at * MS, speed_mps));
        }
        inbox.put(Input::Pictures, picture(50 * MS));
        inbox.put(Input::Pictures, picture(100 * MS));
        inbox.put(Input::Pictures, picture(150 * MS));
        let speeds: Vec<Option<f64>> =
            all(&inbox).iter().map(|arrival| arrival.twist.map(|twist| twist.speed_mps)).collect();
        assert_eq!(speeds, [Some(2.0), Some(3.0), None]);
        inbox.put(Input::Twist, twist(200 * MS, 4.0));
        inbox.put(Input::Pictures, picture(1500 * MS));
        assert!(all(&inbox)[0].twist.is_none(), "a twist of more than a second ago");
    }

    #[test]
    fn a_twist_in_an_unknown_frame_is_used_and_said_to_be_a_guess() {
        for (frames, guessed) in [
            (vec!["base_link", "base_footprint", "front_optical"], None),
            (vec!["base_link", "gps_antenna", "other"], Some("\"gps_antenna\"")),
            (vec![""], Some("\"\"")),
        ] {
            let inbox = Inbox::new(5);
            for (at, frame_id) in (1..).zip(&frames) {
                inbox.put(Input::Twist, twist_in(frame_id, at * MS, 2.0));
            }
            inbox.put(Input::Pictures, picture(50 * MS));
            assert!(all(&inbox)[0].twist.is_some());
            let said = inbox.count(Input::Twist).guess;
            assert_eq!(said.is_some(), guessed.is_some(), "{said:?}");
            let said = said.unwrap_or_default();
            assert!(guessed.is_none_or(|name| said.contains(name) && said.contains("vehicle's")), "{said}");
        }
    }

    #[test]
    fn the_oldest_pictures_make_room_and_are_counted() {
        let inbox = Inbox::new(3);
        (1..=10).for_each(|n| inbox.put(Input::Pictures, picture(n * MS)));
        let numbers: Vec<u64> = all(&inbox).iter().map(|arrival| arrival.number).collect();
        assert_eq!((numbers, inbox.dropped()), (vec![7, 8, 9], 7));
        assert_eq!(inbox.count(Input::Pictures).received, 10);
    }

    #[test]
    fn pictures_without_a_time_or_out_of_order_are_refused_with_the_reason() {
        let inbox = Inbox::new(6);
        for stamp_ns in [0, 40 * MS, 40 * MS, 30 * MS, 50 * MS] {
            inbox.put(Input::Pictures, picture(stamp_ns));
        }
        inbox.put(Input::Pictures, Err("its rows are too short".to_owned()));
        let said: Vec<String> = all(&inbox)
            .into_iter()
            .map(|arrival| arrival.picture.map_or_else(|cause| cause, |(stamp_ns, _)| stamp_ns.to_string()))
            .collect();
        assert!(said[0].contains("header.stamp") && said[1] == "40000000", "{said:?}");
        assert!(said[2].contains("0.000 s behind") && said[3].contains("0.010 s behind"), "{said:?}");
        assert!(said[4] == "50000000" && said[5].contains("rows"), "{said:?}");
        let count = inbox.count(Input::Pictures);
        assert_eq!((count.received, count.refused), (6, 4));
        assert!(count.last_refusal.is_some_and(|cause| cause.contains("rows")));
    }
}
