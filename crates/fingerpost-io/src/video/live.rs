//! Inputs that go on whether their pictures are taken or not: cameras and streams.

use std::{path::Path, time::Instant};

use crate::sampling::Sampler;

/// Protocols that carry what is being filmed: nothing of it can be waited for or asked for again.
const LIVE_PROTOCOLS: [&str; 8] = ["rtsp", "rtsps", "rtmp", "rtmps", "rtp", "srtp", "udp", "srt"];

/// Whether an input is taken for one that is under way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Liveness {
    /// It is not: every picture is given, however late.
    #[default]
    Waits,
    /// Devices are, and addresses of protocols that stream: rtsp, rtmp, rtp, udp, srt.
    ByKind,
    /// It is, whatever its name says: a camera that is asked over http.
    Live,
}

impl Liveness {
    /// Whether `input` is under way.
    pub(crate) fn holds(self, input: &str) -> bool {
        let streams = || {
            let protocol = input.split_once("://").map(|(protocol, _)| protocol.to_ascii_lowercase());
            protocol.is_some_and(|protocol| LIVE_PROTOCOLS.contains(&protocol.as_str()))
        };
        match self {
            Self::Waits => false,
            Self::ByKind => streams() || is_device(Path::new(input)),
            Self::Live => true,
        }
    }
}

#[cfg(unix)]
fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_char_device())
}

#[cfg(not(unix))]
const fn is_device(_path: &Path) -> bool {
    false
}

/// When the frames of a live input were taken, and which of them are used.
#[derive(Debug)]
pub(super) struct LiveFrames {
    sampler: Sampler,
    /// When the first frame came, and the time that was stamped on it, microseconds.
    first: Option<(Instant, Option<i64>)>,
}

impl LiveFrames {
    pub(super) const fn new(sampler: Sampler) -> Self {
        Self { sampler, first: None }
    }

    /// When the frame was taken that has just come, seconds since the first: by the time that the input stamped on both, or
    /// else by when they came. None for a frame that is not used.
    pub(super) fn used_at_s(&mut self, index: u64, stamp_us: Option<i64>) -> Option<f64> {
        let now = Instant::now();
        let (first, first_us) = *self.first.get_or_insert((now, stamp_us));
        let stamped_us = stamp_us.zip(first_us).map(|(stamp_us, first_us)| stamp_us.saturating_sub(first_us));
        let stamped_s = stamped_us.map(|stamped_us| stamped_us as f64 * 1e-6);
        let t_s = stamped_s.unwrap_or_else(|| now.duration_since(first).as_secs_f64());
        self.sampler.wants(index, t_s).then_some(t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Sampling;

    #[test]
    fn devices_and_streams_are_live_and_files_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("drive.mp4");
        std::fs::write(&file, "").unwrap();
        let live = |input: &str| Liveness::ByKind.holds(input);
        assert!(live("rtsp://camera/1") && live("RTSP://camera/1") && live("udp://:5000"));
        assert!(!live(file.to_str().unwrap()) && !live("https://host/drive.mp4") && !live("file://rtsp"));
        #[cfg(unix)]
        assert!(live("/dev/null"));
        assert!(Liveness::Live.holds("http://camera/mjpeg"));
        assert!(!Liveness::Waits.holds("rtsp://camera/1"));
    }

    #[test]
    fn stamped_times_are_believed_and_others_measured() {
        let mut frames = LiveFrames::new(Sampler::new(Sampling::All));
        assert_eq!(frames.used_at_s(0, Some(100_000_000)), Some(0.0));
        assert_eq!(frames.used_at_s(1, Some(107_500_000)), Some(7.5));
        assert!(frames.used_at_s(2, None).is_some_and(|t_s| t_s < 5.0), "as it came");
        let mut frames = LiveFrames::new(Sampler::new(Sampling::Rate { hz: 1.0 }));
        let used = [0, 5, 10, 15, 20].map(|tenths| frames.used_at_s(0, Some(100_000 * tenths)).is_some());
        assert_eq!(used, [true, false, true, false, true]);
    }
}
