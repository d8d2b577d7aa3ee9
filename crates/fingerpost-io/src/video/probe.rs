//! What ffprobe says about a video.

use std::{io::ErrorKind, process::Stdio};

use fingerpost_vision::colour::{YuvCoding, YuvMatrix, YuvRange};
use serde::Deserialize;

use super::stamps::Timing;
use crate::address::without_credentials;
use crate::ffmpeg::{FfmpegPrograms, VideoError, answer, start_error};

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

/// What of a stream ffprobe is asked to show.
const SHOWN: &str = "stream=avg_frame_rate,r_frame_rate,time_base,start_time,nb_frames,duration,pix_fmt,color_space,color_range:stream_tags=DURATION:format=format_name";

/// A rate that ffprobe is told to take where a bare stream states none: any but 25, which it takes by itself.
const OTHER_GUESS: &str = "7";

/// The container that may count frames which are not shown, as ffprobe calls it.
pub(super) const HIDING_CONTAINER: &str = "mov";

/// Most that ffprobe answers, bytes; what is asked of one stream has some hundred.
const MAX_ANSWER_BYTES: u64 = 1 << 20;

#[derive(Deserialize)]
struct Probe {
    #[serde(default)]
    streams: Vec<Stream>,
    #[serde(default)]
    format: Container,
}

/// What holds the streams.
#[derive(Debug, Default, Deserialize)]
struct Container {
    /// All names of its kind: "mov,mp4,m4a,3gp,3g2,mj2".
    #[serde(default)]
    format_name: String,
}

/// The stream of moving pictures in a video.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Stream {
    pub(super) avg_frame_rate: Option<String>,
    pub(super) r_frame_rate: Option<String>,
    /// Seconds of a tick of the stamps, as a fraction.
    pub(super) time_base: Option<String>,
    /// The first stamp, seconds; none where frames have none.
    pub(super) start_time: Option<String>,
    /// Whether the rate is the stream's own, which matters where frames have no stamps.
    #[serde(skip)]
    pub(super) states_rate: bool,
    pub(super) nb_frames: Option<String>,
    pub(super) duration: Option<String>,
    #[serde(default)]
    pub(super) tags: Tags,
    /// Whether the container may count frames that are not shown, as a cut without coding anew leaves them in front.
    #[serde(skip)]
    pub(super) hides_frames: bool,
    pub(super) pix_fmt: Option<String>,
    pub(super) color_space: Option<String>,
    pub(super) color_range: Option<String>,
}

/// Frames that there should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Expected {
    /// The container counts them.
    Counted(u64),
    /// They fill the duration that it states; whether that reaches to the beginning of the last frame or to its end differs.
    Estimated(u64),
    /// Nothing is stated.
    Unknown,
}

impl Expected {
    /// How many.
    pub(super) const fn frames(self) -> Option<u64> {
        match self {
            Self::Counted(frames) | Self::Estimated(frames) => Some(frames),
            Self::Unknown => None,
        }
    }

    /// Whether `frames` are fewer.
    pub(super) const fn is_short(self, frames: u64) -> bool {
        match self {
            Self::Counted(counted) => frames < counted,
            Self::Estimated(estimated) => frames.saturating_add(1) < estimated,
            Self::Unknown => true,
        }
    }
}

/// What Matroska says of a stream.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Tags {
    #[serde(rename = "DURATION")]
    pub(super) duration: Option<String>,
}

impl Stream {
    /// Asks ffprobe about `input`, which is `argument` to it.
    pub(super) fn probe(input: &str, argument: &str, programs: &FfmpegPrograms) -> Result<Self, VideoError> {
        Self::ask(input, &[argument], programs)
    }

    /// The same of an input that can be read more than once, and whether it states its rate where its frames have no stamps: ffprobe
    /// does not say what it guesses, but a guess is another one when it is told to guess otherwise.
    pub(super) fn probe_recording(
        input: &str,
        argument: &str,
        programs: &FfmpegPrograms,
    ) -> Result<Self, VideoError> {
        let stream = Self::probe(input, argument, programs)?;
        if stream.start_time.is_some() {
            return Ok(stream);
        }
        let stated = |stream: &Self| stream.avg_frame_rate.as_deref().and_then(Rate::parse);
        let told = Self::ask(input, &["-framerate", OTHER_GUESS, argument], programs).ok();
        let states_rate =
            stated(&stream).is_some() && told.is_some_and(|told| stated(&told) == stated(&stream));
        Ok(Self { states_rate, ..stream })
    }

    fn ask(input: &str, about: &[&str], programs: &FfmpegPrograms) -> Result<Self, VideoError> {
        let question = ["-v", "error", "-select_streams", "v:0", "-of", "json", "-show_entries", SHOWN];
        let arguments = question.into_iter().chain(about.iter().copied());
        let mut ffprobe =
            programs.start(&programs.ffprobe, arguments, Stdio::null(), programs.patience())?.listened_to();
        let input = || without_credentials(input);
        let (status, answer) =
            answer(&mut ffprobe, MAX_ANSWER_BYTES).map_err(|cause| match cause.kind() {
                ErrorKind::TimedOut => VideoError::Stalled { input: input(), frames: 0, cause },
                _ if programs.patience().is_stopped() => VideoError::Stopped { input: input() },
                _ => start_error(&programs.ffprobe, cause),
            })?;
        let unreadable = |cause: &str| VideoError::Unreadable { input: input(), cause: cause.to_owned() };
        if !status.success() {
            let said = ffprobe.last_line();
            return Err(unreadable(said.as_deref().unwrap_or("ffprobe failed without a message")));
        }
        let probe: Probe = serde_json::from_slice(&answer)
            .map_err(|cause| unreadable(&format!("ffprobe's answer is not understood: {cause}")))?;
        let hides_frames = probe.format.format_name.split(',').any(|name| name == HIDING_CONTAINER);
        let stream = probe.streams.into_iter().next().map(|stream| Self { hides_frames, ..stream });
        stream.ok_or_else(|| unreadable("there are no moving pictures in it"))
    }

    /// Frames a second, on average.
    pub(super) fn rate(&self) -> Rate {
        let stated = [&self.avg_frame_rate, &self.r_frame_rate];
        stated.into_iter().flatten().find_map(|text| Rate::parse(text)).unwrap_or(FALLBACK_RATE)
    }

    /// What the times of its frames are from.
    pub(super) fn timing(&self) -> Timing {
        let tick = self.time_base.as_deref().and_then(Rate::parse);
        match (&self.start_time, tick) {
            (Some(_), Some(tick)) => Timing::Stamps { tick_s: tick.fps() },
            _ if self.states_rate => Timing::StatedRate,
            _ => Timing::GuessedRate,
        }
    }

    /// How pixels are coded, where that is 8 bits with colour at half the size, and what ffmpeg calls it. What is not
    /// stated is taken as ffmpeg takes it.
    pub(super) fn yuv420_coding(&self) -> Option<(&'static str, YuvCoding)> {
        let (pixels, range) = match (self.pix_fmt.as_deref()?, self.color_range.as_deref()) {
            ("yuv420p", Some("pc")) => ("yuv420p", YuvRange::Full),
            ("yuv420p", _) => ("yuv420p", YuvRange::Limited),
            ("yuvj420p", _) => ("yuvj420p", YuvRange::Full),
            _ => return None,
        };
        let matrix = match self.color_space.as_deref() {
            None | Some("unknown" | "smpte170m" | "bt470bg") => YuvMatrix::Bt601,
            Some("bt709") => YuvMatrix::Bt709,
            Some(_) => return None,
        };
        Some((pixels, YuvCoding { matrix, range }))
    }

    /// Frames that the container says it holds.
    pub(super) fn length(&self) -> Option<u64> {
        self.nb_frames.as_ref()?.parse().ok()
    }

    /// Frames that there should be: as many as the container counts, or else as fill the duration that it states.
    pub(super) fn expected_length(&self) -> Expected {
        match (self.length(), self.estimated_length()) {
            (Some(counted), Some(shown)) if self.hides_frames && shown < counted => {
                Expected::Estimated(shown)
            }
            (Some(counted), _) => Expected::Counted(counted),
            (None, Some(shown)) => Expected::Estimated(shown),
            (None, None) => Expected::Unknown,
        }
    }

    fn estimated_length(&self) -> Option<u64> {
        let stated_s = self.duration.as_ref().and_then(|text| text.parse().ok());
        let duration_s: f64 = stated_s.or_else(|| clock_s(self.tags.duration.as_ref()?))?;
        let frames = duration_s * self.rate().fps();
        // As a float of that size it is a whole number still.
        (0.0..2_f64.powi(53)).contains(&frames).then(|| frames.round() as u64)
    }
}

/// Seconds of `00:01:02.500`.
fn clock_s(text: &str) -> Option<f64> {
    let mut parts = text.split(':').map(|part| part.parse::<f64>().ok());
    let (hours, minutes, seconds) = (parts.next()??, parts.next()??, parts.next()??);
    Some((hours * 60.0 + minutes) * 60.0 + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duration_gives_a_number_of_frames() {
        let frames = |duration: Option<&str>, tag: Option<&str>| {
            let [rate, duration, tag] =
                [Some("30000/1001"), duration, tag].map(|text| text.map(str::to_owned));
            let tags = Tags { duration: tag };
            Stream { avg_frame_rate: rate, duration, tags, ..Stream::default() }.estimated_length()
        };
        assert_eq!(frames(Some("10.010000"), None), Some(300));
        assert_eq!(frames(None, Some("01:00:10.010000000")), Some(108_192));
        for none in [None, Some("N/A"), Some("-1"), Some("1e300"), Some("NaN")] {
            assert_eq!(frames(none, Some("what?")), None, "{none:?}");
        }
    }

    #[test]
    fn pixels_that_need_no_ffmpeg_to_be_turned_into_colours() {
        let coding = |pix_fmt: &str, space: Option<&str>, range: Option<&str>| {
            let [pix_fmt, color_space, color_range] =
                [Some(pix_fmt), space, range].map(|text| text.map(str::to_owned));
            let stream = Stream { pix_fmt, color_space, color_range, ..Stream::default() };
            stream.yuv420_coding().map(|(_, YuvCoding { matrix, range })| (matrix, range))
        };
        let usual = Some((YuvMatrix::Bt601, YuvRange::Limited));
        assert_eq!(coding("yuv420p", None, None), usual);
        assert_eq!(coding("yuv420p", Some("unknown"), Some("unknown")), usual);
        assert_eq!(coding("yuv420p", Some("smpte170m"), Some("tv")), usual);
        assert_eq!(coding("yuv420p", Some("bt709"), Some("pc")), Some((YuvMatrix::Bt709, YuvRange::Full)));
        assert_eq!(coding("yuvj420p", None, None), Some((YuvMatrix::Bt601, YuvRange::Full)));
        for (pix_fmt, space) in [("yuv420p10le", None), ("yuv422p", None), ("yuv420p", Some("bt2020nc"))] {
            assert_eq!(coding(pix_fmt, space, None), None, "{pix_fmt} {space:?}");
        }
    }

    #[test]
    fn rates_are_fractions() {
        assert_eq!(Rate::parse("30000/1001"), Some(Rate { frames: 30_000, seconds: 1001 }));
        assert_eq!(Rate::parse("0/0"), None);
        assert_eq!(Rate::parse("25"), None);
    }
}
