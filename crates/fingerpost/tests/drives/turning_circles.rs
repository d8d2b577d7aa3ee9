//! Turning circles of 6, 9, 12 and 25 m at corners of all angles, widths and sides: the driving line keeps them, or it is impossible
//! there and said to be.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, route};
use fingerpost::driving_line::{CornerSetting, DrivingLine, DrivingLineConfig};
use fingerpost::feature_model::FeatureModel;
use fingerpost::vehicle::{Traffic, VehicleConfig};
use fingerpost_map::{FeatureKind, TangentPlane};
use nalgebra::{Point2, Vector2};

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const KERB_M: f64 = 4.0;

struct Case {
    turn_deg: f64,
    side: f64,
    width_m: f64,
    vehicle: VehicleConfig,
}

fn cases() -> impl Iterator<Item = Case> {
    let radii = [6.0, 9.0, 12.0, 25.0];
    let turns = (2..=13).map(|ten| 10.0 * f64::from(ten));
    radii.into_iter().flat_map(move |turning_radius_m| {
        turns.clone().flat_map(move |turn_deg| {
            [1.0, -1.0].into_iter().flat_map(move |side| {
                [4.0, 6.0, 8.0, 12.0].into_iter().flat_map(move |width_m| {
                    [Traffic::Left, Traffic::Right, Traffic::Centre].into_iter().map(move |traffic| {
                        let vehicle = VehicleConfig { turning_radius_m, traffic, ..VehicleConfig::default() };
                        Case { turn_deg, side, width_m, vehicle }
                    })
                })
            })
        })
    })
}

impl Case {
    fn line(&self) -> DrivingLine {
        let (sine, cosine) = libm::sincos(self.turn_deg.to_radians());
        let exit: &[Place] = &[(0.0, 0.0), (60.0 * self.side * sine, 60.0 * cosine)];
        let junction = Junction {
            kind: FeatureKind::Junction,
            approach: SOUTH,
            exit,
            sides: &[],
            width_m: self.width_m,
        };
        let (route, _) = route(&junction);
        let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
        let config = DrivingLineConfig::default();
        let corner = CornerSetting { kerb_radius_m: KERB_M, ..CornerSetting::default() };
        DrivingLine::new(&config, &self.vehicle, &model, &corner).unwrap().unwrap()
    }

    /// Radius of the widest arc in the corner whose inner side, with the margin, touches the kerb, from the lanes' middles.
    fn widest_m(&self) -> f64 {
        let cos = libm::cos(0.5 * self.turn_deg.to_radians());
        let lane_left_m = self.vehicle.traffic.lane_left_m(self.width_m);
        let to_edge_m = 0.5 * self.width_m + self.side * lane_left_m;
        let room_m =
            to_edge_m / cos + KERB_M * (1.0 / cos - 1.0) - 0.5 * self.vehicle.width_m - self.vehicle.margin_m;
        room_m / (1.0 / cos - 1.0)
    }

    fn describe(&self) -> String {
        let Self { turn_deg, side, width_m, vehicle } = self;
        format!(
            "{turn_deg} degrees to {side}, {width_m} m, {:?}, circle {}",
            vehicle.traffic, vehicle.turning_radius_m
        )
    }
}

/// Largest curvature of a line of points, by circles through points a metre apart, 1/m.
fn measured_per_m(points: &[Point2<f64>]) -> f64 {
    let circle = |three: &[Point2<f64>]| {
        let (a, b, c) = (three[0], three[2], three[4]);
        2.0 * (b - a).perp(&(c - b)).abs() / ((b - a).norm() * (c - b).norm() * (c - a).norm())
    };
    points.windows(5).map(circle).fold(0.0, f64::max)
}

#[test]
fn a_turning_circle_is_kept_or_said_to_be_impossible() {
    let mut counts = [0; 2];
    for case in cases() {
        let (line, asked_m) = (case.line(), case.vehicle.turning_radius_m);
        let kept = line.within_turning_circle();
        counts[usize::from(kept)] += 1;
        let measured_m = 1.0 / measured_per_m(&line.points);
        if kept {
            assert!(measured_m >= 0.98 * asked_m, "{}: {measured_m} m", case.describe());
            let most_per_m = line.curvature_per_m.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
            assert!(most_per_m <= 1.0 / asked_m + 1e-9, "{}: {most_per_m}", case.describe());
        } else {
            assert!(line.tightest_radius_m < asked_m, "{}", case.describe());
            // What is said of it is true.
            assert!(
                (measured_m / line.tightest_radius_m - 1.0).abs() < 0.1,
                "{}: {measured_m}",
                case.describe()
            );
            // Nor is it said where the road has room and the curve's ends reach far enough for the arc.
            let ends_m = asked_m * libm::tan(0.5 * case.turn_deg.to_radians()) + 0.25 * case.width_m;
            let has_room =
                case.widest_m() > 1.02 * asked_m && ends_m < DrivingLineConfig::default().max_setback_m;
            assert!(
                !has_room,
                "{}: {} m, room for {}",
                case.describe(),
                line.tightest_radius_m,
                case.widest_m()
            );
        }
    }
    assert!(counts.iter().all(|count| *count > 200), "both happen: {counts:?}");
}

#[test]
fn a_line_that_keeps_the_turning_circle_stays_on_the_road() {
    for case in cases() {
        let line = case.line();
        // A road of 4 m has no room for two lanes and a margin.
        if !line.within_turning_circle() || case.width_m < 5.0 {
            continue;
        }
        // Inside the turn both roads' edges are this far from the middle of the corner, and the kerb cuts it off.
        let half_rad = 0.5 * case.turn_deg.to_radians();
        let apex = line.curve.at(0.5 * line.curve.length_m()).0;
        let bisector = Vector2::new(-libm::sin(half_rad), -case.side * libm::cos(half_rad));
        let kerb_m = 0.5 * case.width_m / libm::cos(half_rad) + KERB_M * (1.0 / libm::cos(half_rad) - 1.0);
        let (apex_m, beside_m) = (apex.coords.dot(&bisector), 0.5 * case.vehicle.width_m);
        assert!(apex_m < kerb_m - beside_m, "{}: {apex_m} of {kerb_m}", case.describe());
        assert!(apex_m > -0.5 * case.width_m / libm::cos(half_rad), "{}: {apex_m}", case.describe());
    }
}
