//! GPS positions for frames: of a track, or of a receiver as they come.

use std::path::Path;

use anyhow::Result;
use fingerpost_map::LatLon;

use crate::arguments::InputLimit;
use crate::gps_track::GpsTrack;
use crate::live_gps::LiveGps;

/// Positions for frames: of a track, or of a receiver that is listened to.
#[derive(Debug)]
pub(crate) enum GpsFeed {
    /// Of a file.
    Track(GpsTrack),
    /// As they come.
    Live(LiveGps),
}

impl GpsFeed {
    /// Opens what `--gps` names.
    pub(crate) fn open(name: &Path, limit: InputLimit) -> Result<Self> {
        match LiveGps::open(name)? {
            Some(live) => Ok(Self::Live(live)),
            None => GpsTrack::read(name, limit).map(Self::Track),
        }
    }

    /// That none of a track's positions belonged to a frame, where that is so: a sentence.
    pub(crate) fn unused(&self) -> Option<String> {
        if let Self::Track(track) = self { track.unused() } else { None }
    }

    /// All positions that are known beforehand.
    pub(crate) fn positions(&self) -> impl Iterator<Item = LatLon> {
        let track = if let Self::Track(track) = self { Some(track) } else { None };
        track.into_iter().flat_map(GpsTrack::positions)
    }

    /// The position for a frame, by its time since the first frame, seconds; of a receiver the one that has just come.
    pub(crate) fn at(&mut self, t_s: f64) -> Option<LatLon> {
        match self {
            Self::Track(track) => track.at(t_s),
            Self::Live(live) => live.newest(),
        }
    }
}
