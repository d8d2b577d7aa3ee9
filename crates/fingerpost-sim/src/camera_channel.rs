//! What can become of pictures between the camera and who looks at them.

use fingerpost_vision::picture::RgbImage;
use serde::{Deserialize, Serialize};

use crate::noise::Stream;

/// A fault of a camera or of its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraFault {
    /// One picture in five does not arrive.
    Dropped,
    /// Once in eight seconds the same picture comes for a second.
    Frozen,
    /// Once in eight seconds all pictures of a second are black.
    Black,
    /// From the tenth second on all pictures are black.
    Blind,
    /// Every picture arrives two frames late.
    Late,
    /// Two pictures in a row arrive in the wrong order, one time in five.
    Reordered,
}

/// Share of the pictures that are dropped, and of those that are passed by the next one.
const SHARE: f64 = 0.2;
/// Every so often a fault begins, and so long it lasts, seconds.
const EVERY_S: f64 = 8.0;
const LASTS_S: f64 = 1.0;
/// From then on the camera is blind, seconds.
const BLIND_FROM_S: f64 = 10.0;
/// A late picture is so many frames late.
const LATE_FRAMES: usize = 2;

/// A line from a camera.
#[derive(Debug, Clone)]
pub struct CameraChannel {
    fault: Option<CameraFault>,
    stream: Stream,
    /// Pictures under way, or the one that is shown again.
    held: Vec<Arrival>,
}

/// A picture that arrives.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrival {
    /// Number of the frame in which it was taken.
    pub frame: u64,
    /// When it was taken, seconds.
    pub t_s: f64,
    /// What it shows.
    pub picture: RgbImage,
}

impl CameraChannel {
    /// A line with a fault, or a sound one; when a fault strikes follows from the seed.
    pub fn new(fault: Option<CameraFault>, seed: u64) -> Self {
        Self { fault, stream: Stream::new(seed, 0x4348_414e), held: Vec::new() }
    }

    /// What arrives after this picture was taken, in the order in which it arrives.
    pub fn send(&mut self, taken: Arrival) -> Vec<Arrival> {
        let faulty = taken.t_s >= EVERY_S && taken.t_s % EVERY_S < LASTS_S;
        match self.fault {
            None => vec![taken],
            Some(CameraFault::Dropped) => {
                if self.stream.unit() < SHARE {
                    Vec::new()
                } else {
                    vec![taken]
                }
            }
            Some(CameraFault::Frozen) => match self.held.first() {
                Some(shown) if faulty => vec![Arrival { picture: shown.picture.clone(), ..taken }],
                _ => {
                    self.held = vec![taken.clone()];
                    vec![taken]
                }
            },
            Some(CameraFault::Black) if faulty => vec![blackened(taken)],
            Some(CameraFault::Blind) if taken.t_s >= BLIND_FROM_S => vec![blackened(taken)],
            Some(CameraFault::Black | CameraFault::Blind) => vec![taken],
            Some(CameraFault::Late) => {
                self.held.push(taken);
                if self.held.len() > LATE_FRAMES { vec![self.held.remove(0)] } else { Vec::new() }
            }
            Some(CameraFault::Reordered) => {
                if self.held.is_empty() && self.stream.unit() < SHARE {
                    self.held.push(taken);
                    return Vec::new();
                }
                let passed = self.held.drain(..);
                [taken].into_iter().chain(passed).collect()
            }
        }
    }
}

fn blackened(mut taken: Arrival) -> Arrival {
    taken.picture.as_mut_slice().fill(0);
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(fault: CameraFault, frames: u64) -> Vec<Vec<Arrival>> {
        let mut channel = CameraChannel::new(Some(fault), 5);
        (0..frames)
            .map(|frame| {
                let mut picture = RgbImage::new(2, 1);
                picture.as_mut_slice().fill(1 + (frame % 250) as u8);
                channel.send(Arrival { frame, t_s: 0.1 * frame as f64, picture })
            })
            .collect()
    }

    fn is_its_own(arrival: &Arrival) -> bool {
        arrival.picture.as_slice()[0] == 1 + (arrival.frame % 250) as u8
    }

    #[test]
    fn a_fifth_is_dropped() {
        let arrived = sent(CameraFault::Dropped, 1000).concat();
        assert!((750..850).contains(&arrived.len()), "{}", arrived.len());
        assert!(arrived.iter().all(is_its_own));
    }

    #[test]
    fn a_second_is_frozen_or_black() {
        let frozen = sent(CameraFault::Frozen, 170).concat();
        assert!(frozen[80..90].iter().all(|shown| shown.picture == frozen[79].picture));
        assert!(frozen[..80].iter().chain(&frozen[90..160]).all(is_its_own));
        let black = sent(CameraFault::Black, 170).concat();
        let dark = |shown: &Arrival| shown.picture.as_slice().iter().all(|&level| level == 0);
        assert_eq!(black.iter().filter(|shown| dark(shown)).count(), 20);
        let blind = sent(CameraFault::Blind, 170).concat();
        assert!(blind[100..].iter().all(dark) && blind[..100].iter().all(is_its_own));
    }

    #[test]
    fn late_and_reordered_pictures_are_all_there() {
        let late = sent(CameraFault::Late, 50);
        assert!(late[0].is_empty() && late[1].is_empty() && late[2][0].frame == 0 && late[49][0].frame == 47);
        let reordered = sent(CameraFault::Reordered, 501).concat();
        let mut numbers: Vec<u64> = reordered.iter().map(|arrival| arrival.frame).collect();
        let backwards = numbers.windows(2).filter(|pair| pair[1] < pair[0]).count();
        assert!((50..150).contains(&backwards), "{backwards}");
        numbers.sort_unstable();
        assert!(numbers.iter().copied().eq(0..numbers.len() as u64));
        assert!(reordered.iter().all(is_its_own));
    }
}
