//! The fixes that are worth following, as tracks that other programs read.

use anyhow::Result;
use fingerpost_format::{FixLine, FixStatus, TrackPoint, track_geojson, track_gpx, track_kitti, track_tum};
use fingerpost_io::{OutputFolder, write_private_file};
use fingerpost_locate::Fix;

/// Points of the track so far.
#[derive(Debug, Default)]
pub(super) struct Tracks {
    points: Vec<TrackPoint>,
    /// Whether the row before is in it.
    joins: bool,
}

impl Tracks {
    pub(super) fn add(&mut self, fix: &Fix, line: &FixLine) {
        let is_worth = matches!(line.status, FixStatus::Converged | FixStatus::Coasting);
        if is_worth {
            self.points.push(TrackPoint {
                t_s: line.t_s,
                lat_lon: [line.lat, line.lon],
                place_m: [fix.place_m.x, fix.place_m.y],
                heading_rad: line.heading_rad,
                status: line.status,
                joins: self.joins,
            });
        }
        self.joins = is_worth;
    }

    pub(super) fn write(&self, folder: &OutputFolder) -> Result<()> {
        let texts = [
            ("track.geojson", track_geojson(&self.points)),
            ("track.gpx", track_gpx(&self.points)),
            ("poses_tum.txt", track_tum(&self.points)),
            ("poses_kitti.txt", track_kitti(&self.points)),
        ];
        for (name, text) in texts {
            write_private_file(&folder.path().join(name), text)?;
        }
        Ok(())
    }
}
