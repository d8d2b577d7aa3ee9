//! The fix on the map: as a position on earth, and as where `odom` lies in `map`.

use fingerpost::fix::MapFix;
use fingerpost_locate::Status;
use fingerpost_map::{LatLon, TangentPlane};
use fingerpost_record::recording::position_covariance;
use nalgebra::Isometry2;

use crate::frames::{BASE_LINK, MAP, ODOM};
use crate::messages::{Header, NavSatFix, Pose, TfMessage, TransformStamped};

// Of `sensor_msgs/NavSatStatus` and `sensor_msgs/NavSatFix`.
const STATUS_FIX: i8 = 0;
const STATUS_NO_FIX: i8 = -1;
const COVARIANCE_TYPE_APPROXIMATED: u8 = 1;

/// Whether a fix is one place, and not one of several or none.
const fn is_one_place(fix: &MapFix) -> bool {
    matches!(fix.status, Status::Converged | Status::Coasting)
}

/// The fix as a message; one that may be several places says that it is none.
pub(crate) fn nav_sat_fix(stamp_ns: u64, fix: &MapFix) -> NavSatFix {
    NavSatFix {
        header: Header::new(stamp_ns, BASE_LINK),
        status: if is_one_place(fix) { STATUS_FIX } else { STATUS_NO_FIX },
        service: 0,
        latitude: fix.at.lat_deg,
        longitude: fix.at.lon_deg,
        // Nothing estimates it, which the message says so.
        altitude: f64::NAN,
        position_covariance: position_covariance(fix),
        position_covariance_type: COVARIANCE_TYPE_APPROXIMATED,
    }
}

/// The chain of frames from the map to the vehicle.
#[derive(Debug)]
pub(crate) struct FrameChain {
    plane: Option<TangentPlane>,
    map_from_odom: Option<Isometry2<f64>>,
}

impl FrameChain {
    /// With the origin of the map frame, where that is known.
    pub(crate) fn new(map_origin: Option<LatLon>) -> Self {
        Self { plane: map_origin.map(TangentPlane::new), map_from_odom: None }
    }

    /// The transforms of a frame: `odom` to `base_link`, and `map` to `odom` from the first fix on.
    pub(crate) fn transforms(
        &mut self,
        stamp_ns: u64,
        odom_from_vehicle: &Isometry2<f64>,
        fix: Option<&MapFix>,
    ) -> TfMessage {
        if let Some(fix) = fix.filter(|fix| is_one_place(fix)) {
            let plane = self.plane.get_or_insert_with(|| TangentPlane::new(fix.at));
            let map_from_vehicle = Isometry2::new(plane.map_from_wgs84(fix.at).coords, fix.heading_rad);
            self.map_from_odom = Some(map_from_vehicle * odom_from_vehicle.inverse());
        }
        let transform = |parent, child: &str, parent_from_child| TransformStamped {
            header: Header::new(stamp_ns, parent),
            child_frame_id: child.to_owned(),
            transform: Pose::from(parent_from_child),
        };
        let of_map = self.map_from_odom.iter().map(|map_from_odom| transform(MAP, ODOM, map_from_odom));
        let vehicle = transform(ODOM, BASE_LINK, odom_from_vehicle);
        TfMessage { transforms: of_map.chain(std::iter::once(vehicle)).collect() }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::Vector2;

    use super::*;

    fn fix(status: Status) -> MapFix {
        let at = LatLon::new(49.001, 8.4).unwrap();
        MapFix { at, heading_rad: FRAC_PI_2, sigma_m: 2.0, bound_m: None, status }
    }

    /// Expected: the vehicle is 111.2 m north of the origin and drives north; it has driven 10 m, so that odom lies 10 m south of it.
    #[test]
    fn odom_lies_behind_the_vehicle_in_the_map() {
        let mut chain = FrameChain::new(LatLon::new(49.0, 8.4).ok());
        let driven = Isometry2::new(Vector2::new(10.0, 0.0), 0.0);
        assert_eq!(chain.transforms(1, &driven, None).transforms.len(), 1);
        let sent = chain.transforms(2, &driven, Some(&fix(Status::Converged))).transforms;
        assert_eq!((sent[0].header.frame_id.as_str(), sent[0].child_frame_id.as_str()), ("map", "odom"));
        assert_eq!(
            (sent[1].header.frame_id.as_str(), sent[1].child_frame_id.as_str()),
            ("odom", "base_link")
        );
        let at = sent[0].transform.position;
        assert!(at.x.abs() < 0.01 && (at.y - 101.2).abs() < 0.1, "{at:?}");
        // What is lost says nothing, and the last transform stays.
        let later = chain.transforms(3, &driven, Some(&fix(Status::Lost))).transforms;
        assert_eq!(later[0].transform, sent[0].transform);
    }

    #[test]
    fn a_place_that_may_be_several_is_no_fix() {
        let sent = |status| nav_sat_fix(4, &fix(status));
        assert_eq!(sent(Status::Ambiguous).status, -1);
        let good = sent(Status::Converged);
        assert!(good.status == 0 && good.altitude.is_nan());
        assert!((good.position_covariance[0] - 4.0).abs() < 1e-12 && good.position_covariance[8] > 0.0);
    }
}
