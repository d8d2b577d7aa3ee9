//! Which ways a vehicle may drive on, and what is known about them: class, direction, width, surface.
//!
//! Tags mean what the OpenStreetMap wiki says they mean (pages Key:highway, Key:access, Key:oneway, Key:width,
//! Key:lanes, Key:width:carriageway). Private roads are kept: farms, mines and works are where this is driven.

use std::collections::BTreeMap;

use crate::label::cleaned;
use crate::{Parking, Roadside};

/// Class of a drivable road: OSM's `highway` values, links with the road they lead to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RoadClass {
    /// `motorway`: one carriageway of a divided, grade-separated road.
    Motorway,
    /// `trunk`.
    Trunk,
    /// `primary`.
    Primary,
    /// `secondary`.
    Secondary,
    /// `tertiary`.
    Tertiary,
    /// `unclassified`: minor public road; and `road`, whose class nobody has noted.
    Unclassified,
    /// `residential`.
    Residential,
    /// `living_street`.
    LivingStreet,
    /// `service`: driveways, parking aisles, roads within works.
    Service,
    /// `track`: field and forest roads.
    Track,
    /// Any `*_link`: ramps and slip roads.
    Link,
}

/// What is taken for a class where the map is silent.
struct ClassDefaults {
    class: RoadClass,
    highway: &'static str,
    /// Width of one lane, metres.
    lane_width_m: f64,
    /// Width of the whole carriageway, both directions (motorway: one direction), metres.
    width_m: f64,
}

/// Lane and carriageway widths by class.
///
/// Order of magnitude after German practice, where the method's first streets lie: motorway lanes 3.75 m, main-road
/// lanes 3.5 m down to 3.25 m where buses meet at 6.5 m; a car and a lorry pass each other at 5.5 m, which is what
/// residential roads are laid out for; two cars at 4.75 m. Ramps are one lane with its margins; service roads and
/// tracks are one vehicle wide.
const CLASS_DEFAULTS: [ClassDefaults; 11] = [
    ClassDefaults { class: RoadClass::Motorway, highway: "motorway", lane_width_m: 3.75, width_m: 7.5 },
    ClassDefaults { class: RoadClass::Trunk, highway: "trunk", lane_width_m: 3.5, width_m: 7.5 },
    ClassDefaults { class: RoadClass::Primary, highway: "primary", lane_width_m: 3.5, width_m: 7.0 },
    ClassDefaults { class: RoadClass::Secondary, highway: "secondary", lane_width_m: 3.25, width_m: 6.5 },
    ClassDefaults { class: RoadClass::Tertiary, highway: "tertiary", lane_width_m: 3.0, width_m: 6.0 },
    ClassDefaults {
        class: RoadClass::Unclassified,
        highway: "unclassified",
        lane_width_m: 2.75,
        width_m: 5.5,
    },
    ClassDefaults { class: RoadClass::Residential, highway: "residential", lane_width_m: 2.75, width_m: 5.5 },
    ClassDefaults {
        class: RoadClass::LivingStreet,
        highway: "living_street",
        lane_width_m: 2.5,
        width_m: 4.75,
    },
    ClassDefaults { class: RoadClass::Service, highway: "service", lane_width_m: 3.0, width_m: 3.5 },
    ClassDefaults { class: RoadClass::Track, highway: "track", lane_width_m: 3.0, width_m: 3.0 },
    ClassDefaults { class: RoadClass::Link, highway: "link", lane_width_m: 3.5, width_m: 4.5 },
];
/// A one-way street without a width is half the two-way road but no narrower than this, metres: a lorry must pass.
const NARROWEST_ONE_WAY_M: f64 = 3.5;
/// Widths beyond these are typing errors (a way's length, millimetres), metres: a cart track and a twelve-lane toll plaza.
pub(crate) const PLAUSIBLE_WIDTH_M: std::ops::RangeInclusive<f64> = 1.5..=60.0;
/// Lane counts beyond this are typing errors.
const MOST_LANES: f64 = 16.0;
/// Width that a row of cars takes and that of a lane for bicycles, metres: German practice again (2.0 m and 1.5 m).
const PARKED_CAR_M: f64 = 2.0;
const CYCLE_LANE_M: f64 = 1.5;
/// Metres in a foot (international foot).
const FOOT_M: f64 = 0.3048;
/// Inches in a foot.
const INCHES_PER_FOOT: f64 = 12.0;

impl RoadClass {
    /// The class of a `highway` value; `None` for values that are not for motor vehicles.
    pub fn from_highway(highway: &str) -> Option<Self> {
        if highway == "road" {
            return Some(Self::Unclassified);
        }
        if let Some(main) = highway.strip_suffix("_link") {
            return matches!(main, "motorway" | "trunk" | "primary" | "secondary" | "tertiary")
                .then_some(Self::Link);
        }
        CLASS_DEFAULTS
            .iter()
            .find(|row| row.highway == highway && row.class != Self::Link)
            .map(|row| row.class)
    }

    /// The `highway` value of the class (`link` for links), as in files and configuration.
    pub fn as_str(self) -> &'static str {
        self.defaults().highway
    }

    fn defaults(self) -> &'static ClassDefaults {
        &CLASS_DEFAULTS[self as usize]
    }
}

/// Which way a road may be driven, against the direction of its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Travel {
    /// Both ways.
    Both,
    /// Only along the way's direction.
    Forward,
    /// Only against the way's direction.
    Backward,
}

/// What the map says about a road, its gaps filled by class.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadAttributes {
    /// Class.
    pub class: RoadClass,
    /// Name, or its reference number where it has no name; `None` for neither.
    pub name: Option<String>,
    /// Surface as tagged (`asphalt`, `gravel`, ...).
    pub surface: Option<String>,
    /// Width of the carriageway, metres: as tagged, else from lanes, else by class.
    pub width_m: f64,
    /// Permitted direction.
    pub travel: Travel,
    /// What lies on its left and right, in the way's direction.
    pub beside: [Roadside; 2],
}

impl RoadAttributes {
    /// The attributes of a way with these tags; `None` when it is not for motor vehicles.
    pub fn from_tags(tags: &BTreeMap<String, String>) -> Option<Self> {
        let tag = |key: &str| tags.get(key).map(String::as_str);
        let class = RoadClass::from_highway(tag("highway")?)?;
        if tag("area") == Some("yes") || !is_open(tags) {
            return None;
        }
        let travel = travel(tags, class);
        let beside = Roadside::from_tags(tags, travel);
        let named = |key| tag(key).map(cleaned).filter(|name| !name.is_empty());
        Some(Self {
            class,
            name: named("name").or_else(|| named("ref")),
            surface: named("surface"),
            width_m: width_m(tags, class, travel, &beside),
            travel,
            beside,
        })
    }
}

/// Whether motor vehicles may use the way: the most special access tag decides, and only an outright no closes it.
fn is_open(tags: &BTreeMap<String, String>) -> bool {
    let special = ["motorcar", "motor_vehicle", "vehicle", "access"].iter().find_map(|key| tags.get(*key));
    special.is_none_or(|value| value != "no")
}

fn travel(tags: &BTreeMap<String, String>, class: RoadClass) -> Travel {
    match tags.get("oneway").map(String::as_str) {
        Some("yes" | "true" | "1") => Travel::Forward,
        Some("-1" | "reverse") => Travel::Backward,
        Some("no" | "false" | "0") => Travel::Both,
        _ => {
            let is_circle =
                matches!(tags.get("junction").map(String::as_str), Some("roundabout" | "circular"));
            if is_circle || class == RoadClass::Motorway { Travel::Forward } else { Travel::Both }
        }
    }
}

fn width_m(tags: &BTreeMap<String, String>, class: RoadClass, travel: Travel, beside: &[Roadside; 2]) -> f64 {
    let defaults = class.defaults();
    // The first one says which width it means; the last is a guess.
    let tagged = ["width:carriageway", "width", "est_width"]
        .iter()
        .find_map(|key| tags.get(*key).and_then(|text| parse_width_m(text)));
    let lanes = tags.get("lanes").and_then(|text| text.trim().parse::<f64>().ok());
    let by_lanes = lanes
        .filter(|n| *n >= 1.0 && *n <= MOST_LANES)
        .map(|n| n * defaults.lane_width_m + beside_lanes_m(beside));
    tagged.or(by_lanes).unwrap_or(match (travel, class) {
        (Travel::Both, _) | (_, RoadClass::Motorway | RoadClass::Link) => defaults.width_m,
        _ => (defaults.width_m / 2.0).max(NARROWEST_ONE_WAY_M.min(defaults.width_m)),
    })
}

/// What `lanes` leaves out of a carriageway: lanes for bicycles and parked cars, metres.
fn beside_lanes_m(beside: &[Roadside; 2]) -> f64 {
    let side_m = |side: &Roadside| {
        let parked_m = match side.parking {
            Some(Parking::OnRoad) => PARKED_CAR_M,
            Some(Parking::HalfOnKerb) => 0.5 * PARKED_CAR_M,
            _ => 0.0,
        };
        parked_m + if side.cycle_lane == Some(true) { CYCLE_LANE_M } else { 0.0 }
    };
    beside.iter().map(side_m).sum()
}

/// A `width` tag in metres: "5.5", "5,5 m", "16'", "16'3\"", "16 ft"; `None` for what is no plausible width.
pub fn parse_width_m(text: &str) -> Option<f64> {
    let text = text.trim().trim_start_matches('~').replace(',', ".");
    let width_m = if let Some((feet, inches)) = text.split_once('\'') {
        let inches = inches.trim().trim_end_matches('"').trim();
        let inches = if inches.is_empty() { 0.0 } else { inches.parse::<f64>().ok()? };
        (feet.trim().parse::<f64>().ok()? + inches / INCHES_PER_FOOT) * FOOT_M
    } else if let Some(feet) = text.strip_suffix("ft") {
        feet.trim().parse::<f64>().ok()? * FOOT_M
    } else {
        let metres = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic()).trim();
        let unit = text[metres.len()..].trim();
        if !matches!(unit, "" | "m" | "metre" | "metres" | "meter" | "meters") {
            return None;
        }
        metres.parse::<f64>().ok()?
    };
    PLAUSIBLE_WIDTH_M.contains(&width_m).then_some(width_m)
}
