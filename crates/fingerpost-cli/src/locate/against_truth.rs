//! True poses at the times of fixes.

use anyhow::Result;
use fingerpost_eval::FixSample;
use fingerpost_format::{FixLine, PoseLogRow};
use fingerpost_locate::Fix;
use fingerpost_map::{LatLon, RoadGraph};
use nalgebra::Point2;

/// A pose as far as this from a fix in time does not belong to it, seconds: half of a row at 10 Hz.
const NEAR_S: f64 = 0.051;

/// True poses in the plane of the map's graph.
pub(super) struct Truth {
    poses: Vec<TruePose>,
}

/// Where the vehicle truly was at a time.
pub(super) struct TruePose {
    t_s: f64,
    /// Place, metres in the plane of the map's graph.
    pub(super) place_m: Point2<f64>,
    heading_rad: f64,
    driven_m: f64,
}

impl Truth {
    /// Poses in the order of time.
    pub(super) fn of(graph: &RoadGraph, rows: Vec<PoseLogRow>) -> Result<Self> {
        let mut poses: Vec<TruePose> = Vec::with_capacity(rows.len());
        for row in rows {
            let place_m = graph.plane().map_from_wgs84(LatLon::new(row.lat, row.lon)?);
            let driven_m = poses.last().map_or(0.0, |last| last.driven_m + (place_m - last.place_m).norm());
            poses.push(TruePose { t_s: row.t_s, place_m, heading_rad: row.heading_rad, driven_m });
        }
        Ok(Self { poses })
    }

    /// The pose at a time, seconds; none where there is none.
    pub(super) fn at(&self, t_s: f64) -> Option<&TruePose> {
        let after = self.poses.partition_point(|pose| pose.t_s < t_s);
        let near =
            [after.checked_sub(1), Some(after)].into_iter().flatten().filter_map(|i| self.poses.get(i));
        let off_s = |pose: &TruePose| (pose.t_s - t_s).abs();
        near.min_by(|a, b| off_s(a).total_cmp(&off_s(b))).filter(|pose| off_s(pose) <= NEAR_S)
    }
}

impl TruePose {
    /// A fix of its time beside it.
    pub(super) fn beside(&self, fix: &Fix, line: &FixLine) -> FixSample {
        let off = fix.place_m - self.place_m;
        FixSample {
            t_s: fix.t_s,
            driven_m: self.driven_m,
            off_m: [off.x, off.y],
            true_heading_rad: self.heading_rad,
            covariance_m2: line.covariance_m2,
            bound_m: line.bound_m,
            status: line.status,
        }
    }
}
