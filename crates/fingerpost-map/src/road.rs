//! Which ways a vehicle may drive on, and what is known about them: class, direction, width, surface.
//!
//! Tags mean what the OpenStreetMap wiki says they mean (pages Key:highway, Key:access, Key:oneway, Key:width,
//! Key:lanes, Key:width:carriageway). What decides something and is not understood is told.

use std::collections::BTreeMap;

use crate::access::{ACCESS_KEYS, Unread, is_open};
use crate::label::cleaned;
use crate::width::parse_width_m;
use crate::{MapNoticeKind, Parking, Roadside};

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
/// Lane counts beyond this are typing errors.
const MOST_LANES: f64 = 16.0;
/// Width that a row of cars takes and that of a lane for bicycles, metres: German practice again (2.0 m and 1.5 m).
const PARKED_CAR_M: f64 = 2.0;
const CYCLE_LANE_M: f64 = 1.5;
/// Values of `highway` on ways that are no roads for cars (the wiki's page Key:highway), or none yet or any more.
const NOT_FOR_CARS: [&str; 31] = [
    "footway",
    "cycleway",
    "path",
    "pedestrian",
    "steps",
    "bridleway",
    "corridor",
    "via_ferrata",
    "ladder",
    "elevator",
    "escape",
    "emergency_bay",
    "emergency_access_point",
    "raceway",
    "bus_guideway",
    "busway",
    "bus_stop",
    "platform",
    "crossing",
    "traffic_island",
    "rest_area",
    "services",
    "construction",
    "proposed",
    "planned",
    "no",
    "disused",
    "abandoned",
    "razed",
    "demolished",
    "historic",
];

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
    /// Now this way, now that, or nobody can tell: both may be met, and routes rely on neither.
    Unsure,
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
        Self::read(tags, &mut |_, _, _| {})
    }

    /// As [`Self::from_tags`]; `unread` is told what decides something and is not understood.
    pub(crate) fn read(tags: &BTreeMap<String, String>, unread: &mut Unread<'_>) -> Option<Self> {
        let tag = |key: &str| tags.get(key).map(String::as_str);
        let highway = tag("highway")?;
        let Some(class) = RoadClass::from_highway(highway) else {
            if !NOT_FOR_CARS.contains(&highway) {
                unread(MapNoticeKind::Highway, "highway", highway);
            }
            return None;
        };
        if tag("area") == Some("yes") || is_open(tags, "", unread) == Some(false) {
            return None;
        }
        let travel = travel(tags, class, unread)?;
        let beside = Roadside::read(tags, travel, unread);
        for (key, value) in tags.iter().filter(|(key, _)| is_conditional(key)) {
            unread(MapNoticeKind::Conditional, key, value);
        }
        let named = |key| tag(key).map(cleaned).filter(|name| !name.is_empty());
        Some(Self {
            class,
            name: named("name").or_else(|| named("ref")),
            surface: named("surface"),
            width_m: width_m(tags, class, travel, &beside, unread),
            travel,
            beside,
        })
    }
}

/// Whether a key restricts cars at some times or under some conditions (the wiki's page Conditional restrictions).
fn is_conditional(key: &str) -> bool {
    let Some(key) = key.strip_suffix(":conditional") else { return false };
    let key = key.strip_suffix(":forward").or_else(|| key.strip_suffix(":backward")).unwrap_or(key);
    ACCESS_KEYS.contains(&key) || ONEWAY_KEYS.contains(&key)
}

/// One-way tags that hold for cars, the most special first.
const ONEWAY_KEYS: [&str; 4] = ["oneway:motorcar", "oneway:motor_vehicle", "oneway:vehicle", "oneway"];

/// The permitted direction; `None` where access tags forbid both.
fn travel(tags: &BTreeMap<String, String>, class: RoadClass, unread: &mut Unread<'_>) -> Option<Travel> {
    let oneway = ONEWAY_KEYS.iter().find_map(|key| tags.get(*key).map(|value| (*key, value.as_str())));
    let travel = match oneway {
        Some((_, "yes" | "true" | "1")) => Travel::Forward,
        Some((_, "-1" | "reverse")) => Travel::Backward,
        Some((_, "no" | "false" | "0")) => Travel::Both,
        Some((key, value @ "alternating")) => {
            unread(MapNoticeKind::Alternating, key, value);
            Travel::Both
        }
        Some((key, value)) => {
            unread(MapNoticeKind::Oneway, key, value);
            Travel::Unsure
        }
        None => {
            let is_circle =
                matches!(tags.get("junction").map(String::as_str), Some("roundabout" | "circular"));
            if is_circle || class == RoadClass::Motorway { Travel::Forward } else { Travel::Both }
        }
    };
    let [forward, backward] =
        [":forward", ":backward"].map(|suffix| is_open(tags, suffix, unread) != Some(false));
    match (travel, forward, backward) {
        (travel, true, true) | (travel @ Travel::Forward, true, _) | (travel @ Travel::Backward, _, true) => {
            Some(travel)
        }
        (Travel::Both, true, false) => Some(Travel::Forward),
        (Travel::Both, false, true) => Some(Travel::Backward),
        (Travel::Unsure, true, _) | (Travel::Unsure, _, true) => Some(Travel::Unsure),
        _ => None,
    }
}

fn width_m(
    tags: &BTreeMap<String, String>,
    class: RoadClass,
    travel: Travel,
    beside: &[Roadside; 2],
    unread: &mut Unread<'_>,
) -> f64 {
    let defaults = class.defaults();
    // The first one says which width it means; the last is a guess.
    for key in ["width:carriageway", "width", "est_width"] {
        let Some(text) = tags.get(key) else { continue };
        match parse_width_m(text) {
            Some(width_m) => return width_m,
            None => unread(MapNoticeKind::Width, key, text),
        }
    }
    if let Some(text) = tags.get("lanes") {
        match text.trim().parse::<f64>().ok().filter(|lanes| (1.0..=MOST_LANES).contains(lanes)) {
            Some(lanes) => return lanes * defaults.lane_width_m + beside_lanes_m(beside),
            None => unread(MapNoticeKind::Lanes, "lanes", text),
        }
    }
    match (travel, class) {
        (Travel::Both | Travel::Unsure, _) | (_, RoadClass::Motorway | RoadClass::Link) => defaults.width_m,
        _ => (defaults.width_m / 2.0).max(NARROWEST_ONE_WAY_M.min(defaults.width_m)),
    }
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
