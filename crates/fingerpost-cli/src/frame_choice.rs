//! What of an input is used: which frames, and at which resolution (paper 1, section VII; paper 2, section 2.1).

use std::num::NonZeroU64;

use clap::Args;
use fingerpost_format::SamplingRecord;
use fingerpost_io::{Liveness, Sampling};

/// Arguments that say so.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct FrameChoice {
    /// Use the pictures at so many pixels across, made smaller by area averaging, and the calibration with them; 64 to 16384. As many
    /// as they have by default. Results stay in pixels of the input; settings in pixels count those that are used.
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(64..=16384))]
    width: Option<u32>,
    /// Use every n-th frame. Frames keep their numbers and times.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    every: Option<u64>,
    /// Use at most so many frames a second, by their times; 0.01 to 1000. Frames keep their numbers and times.
    #[arg(long, value_name = "HZ", conflicts_with = "every", value_parser = crate::arguments::frame_rate)]
    rate: Option<f64>,
    /// The input is under way, so that its latest frame is used and those that came in between are passed over, counted and said.
    /// Taken for granted of devices and of rtsp, rtmp, rtp, udp and srt addresses; a camera asked over http needs it.
    #[arg(long)]
    live: bool,
}

impl FrameChoice {
    /// Pixels across, where they are not to be those of the input.
    pub(crate) fn width(self) -> Option<usize> {
        self.width.map(|width| width as usize)
    }

    /// Which frames are used.
    pub(crate) fn sampling(self) -> Sampling {
        match (self.every.and_then(NonZeroU64::new), self.rate) {
            (Some(nth), _) => Sampling::Every(nth),
            (None, Some(hz)) => Sampling::Rate { hz },
            (None, None) => Sampling::All,
        }
    }

    /// Whether the input is taken for one that is under way.
    pub(crate) fn liveness(self) -> Liveness {
        if self.live { Liveness::Live } else { Liveness::ByKind }
    }

    /// What the summary says of it, for pictures that are used at `picture_px`; none where all is used as it comes.
    pub(crate) fn record(self, picture_px: [u32; 2]) -> Option<SamplingRecord> {
        let Self { width, every, rate, .. } = self;
        let chosen = width.is_some() || every.is_some() || rate.is_some();
        chosen.then_some(SamplingRecord { picture_px, every, rate_hz: rate })
    }
}
