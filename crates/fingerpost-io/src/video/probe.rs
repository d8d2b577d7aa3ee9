//! What ffprobe says about a video.

use std::process::{Command, Stdio};

use serde::Deserialize;

use crate::ffmpeg::{FfmpegPrograms, VideoError, last_line, start_error};

/// Frame rate that is taken where a stream states none.
const FALLBACK_RATE: Rate = Rate { frames: 25, seconds: 1 };

/// Frames in a number of seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rate {
    pub(super) frames: u32,
    pub(super) seconds: u32,
}

impl Rate {
    /// From ffprobe's `30000/1001`; none where it says `0/0`.
    fn parse(text: &str) -> Option<Self> {
        let (frames, seconds) = text.split_once('/')?;
        let rate = Self { frames: frames.parse().ok()?, seconds: seconds.parse().ok()? };
        (rate.frames > 0 && rate.seconds > 0).then_some(rate)
    }

    pub(super) fn fps(self) -> f64 {
        f64::from(self.frames) / f64::from(self.seconds)
    }
}

#[derive(Deserialize)]
struct Probe {
    #[serde(default)]
    streams: Vec<Stream>,
}

/// The stream of moving pictures in a video.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Stream {
    avg_frame_rate: Option<String>,
    r_frame_rate: Option<String>,
    nb_frames: Option<String>,
}

impl Stream {
    /// Asks ffprobe about `input`, which is `argument` to it.
    pub(super) fn probe(input: &str, argument: &str, programs: &FfmpegPrograms) -> Result<Self, VideoError> {
        let mut command = Command::new(&programs.ffprobe);
        command
            .args(["-v", "error", "-select_streams", "v:0", "-of", "json"])
            .args(["-show_entries", "stream=avg_frame_rate,r_frame_rate,nb_frames", argument])
            .stdin(Stdio::null());
        let output = command.output().map_err(|cause| start_error(&command, cause))?;
        let unreadable =
            |cause: &str| VideoError::Unreadable { input: input.to_owned(), cause: cause.to_owned() };
        if !output.status.success() {
            let said = last_line(&output.stderr);
            return Err(unreadable(said.as_deref().unwrap_or("ffprobe failed without a message")));
        }
        let probe: Probe = serde_json::from_slice(&output.stdout)
            .map_err(|cause| unreadable(&format!("ffprobe's answer is not understood: {cause}")))?;
        probe.streams.into_iter().next().ok_or_else(|| unreadable("there are no moving pictures in it"))
    }

    /// Frames a second, on average.
    pub(super) fn rate(&self) -> Rate {
        let stated = [&self.avg_frame_rate, &self.r_frame_rate];
        stated.into_iter().flatten().find_map(|text| Rate::parse(text)).unwrap_or(FALLBACK_RATE)
    }

    /// Frames that the container says it holds.
    pub(super) fn length(&self) -> Option<u64> {
        self.nb_frames.as_ref()?.parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_fractions() {
        assert_eq!(Rate::parse("30000/1001"), Some(Rate { frames: 30_000, seconds: 1001 }));
        assert_eq!(Rate::parse("0/0"), None);
        assert_eq!(Rate::parse("25"), None);
    }
}
