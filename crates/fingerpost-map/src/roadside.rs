//! What the map says lies beside a road's carriageway: pavement, kerb, parked cars, a lane for bicycles.
//!
//! Tags mean what the OpenStreetMap wiki says they mean (pages Key:sidewalk, Key:kerb, Key:parking, Key:parking:lane,
//! Key:cycleway); left and right are those of somebody who goes along the way's direction.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Travel;

/// What the map says lies on one side of a road. It is silent about most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(default)]
pub struct Roadside {
    /// Whether there is a pavement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pavement: Option<bool>,
    /// What the kerb is like.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kerb: Option<Kerb>,
    /// Where cars are parked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parking: Option<Parking>,
    /// Whether a lane for bicycles is marked on the road.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle_lane: Option<bool>,
}

/// The border between carriageway and pavement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kerb {
    /// A step of more than 3 cm.
    Raised,
    /// A step of about 3 cm, or a slope that wheels roll over.
    Lowered,
    /// A kerb without a step.
    Flush,
    /// No kerb at all.
    None,
}

/// Where cars are parked beside a road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parking {
    /// On the carriageway.
    OnRoad,
    /// Half on the carriageway, half on the pavement.
    HalfOnKerb,
    /// On the pavement.
    OnKerb,
    /// In bays beside the carriageway.
    Bays,
    /// Nowhere.
    None,
}

/// Left and right of a way, in its direction.
const SIDES: [&str; 2] = ["left", "right"];

type Tags = BTreeMap<String, String>;

impl Roadside {
    /// Left and right side of a way with these tags.
    pub(crate) fn from_tags(tags: &Tags, travel: Travel) -> [Self; 2] {
        SIDES.map(|side| Self {
            pavement: pavement(tags, side),
            kerb: on_side(tags, "kerb", side).or_else(|| value(tags, "kerb")).and_then(kerb),
            parking: parking(tags, side),
            cycle_lane: cycle_lane(tags, side, travel),
        })
    }

    /// Whether the map says nothing of this side.
    pub fn is_silent(&self) -> bool {
        *self == Self::default()
    }
}

fn value<'a>(tags: &'a Tags, key: &str) -> Option<&'a str> {
    tags.get(key).map(String::as_str)
}

/// `KEY:left` or `KEY:right`, else `KEY:both`.
fn on_side<'a>(tags: &'a Tags, key: &str, side: &str) -> Option<&'a str> {
    value(tags, &format!("{key}:{side}")).or_else(|| value(tags, &format!("{key}:both")))
}

/// `sidewalk:SIDE=yes` and its kin; else `sidewalk=both|left|right|no`, and `footway` of ways tagged long ago.
fn pavement(tags: &Tags, side: &str) -> Option<bool> {
    if let Some(on_side) = on_side(tags, "sidewalk", side) {
        return match on_side {
            "yes" | "separate" => Some(true),
            "no" | "none" => Some(false),
            _ => None,
        };
    }
    match value(tags, "sidewalk").or_else(|| value(tags, "footway"))? {
        "both" | "yes" => Some(true),
        "no" | "none" => Some(false),
        // The pavements are ways of their own, on which sides is not said.
        "separate" => None,
        one if SIDES.contains(&one) => Some(one == side),
        _ => None,
    }
}

/// `cycleway:SIDE`; `cycleway` means both sides, but on a one-way road it does not say which it means.
fn cycle_lane(tags: &Tags, side: &str, travel: Travel) -> Option<bool> {
    let of_both = || value(tags, "cycleway").filter(|_| travel == Travel::Both);
    match on_side(tags, "cycleway", side).or_else(of_both)? {
        "lane" | "opposite_lane" => Some(true),
        // Bicycles share a lane of the road, or have their own way.
        "shared_lane" | "no" | "none" | "track" | "separate" | "opposite_track" => Some(false),
        _ => None,
    }
}

fn kerb(kerb: &str) -> Option<Kerb> {
    match kerb {
        "raised" | "regular" | "yes" => Some(Kerb::Raised),
        "lowered" | "rolled" => Some(Kerb::Lowered),
        "flush" => Some(Kerb::Flush),
        "no" => Some(Kerb::None),
        _ => None,
    }
}

/// `parking:SIDE` as it is tagged since 2022, else `parking:lane:SIDE` of before.
fn parking(tags: &Tags, side: &str) -> Option<Parking> {
    if let Some(parking) = on_side(tags, "parking", side) {
        return parked(parking);
    }
    match on_side(tags, "parking:lane", side)? {
        "no_parking" | "no_stopping" | "fire_lane" => Some(Parking::None),
        angle @ ("parallel" | "diagonal" | "perpendicular" | "marked") => {
            let place =
                [side, "both"].iter().find_map(|side| value(tags, &format!("parking:lane:{side}:{angle}")));
            Some(place.and_then(parked).unwrap_or(Parking::OnRoad))
        }
        other => parked(other),
    }
}

fn parked(place: &str) -> Option<Parking> {
    match place {
        "lane" | "on_street" => Some(Parking::OnRoad),
        "half_on_kerb" => Some(Parking::HalfOnKerb),
        "on_kerb" => Some(Parking::OnKerb),
        "street_side" | "lay_by" | "shoulder" => Some(Parking::Bays),
        "no" | "none" => Some(Parking::None),
        // "yes" and "separate" leave open where.
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(tags: &[(&str, &str)]) -> [Roadside; 2] {
        sides_of(tags, Travel::Both)
    }

    fn sides_of(tags: &[(&str, &str)], travel: Travel) -> [Roadside; 2] {
        Roadside::from_tags(
            &tags.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect(),
            travel,
        )
    }

    fn pavements(tags: &[(&str, &str)]) -> [Option<bool>; 2] {
        sides(tags).map(|side| side.pavement)
    }

    #[test]
    fn pavements_in_every_usual_spelling() {
        assert_eq!(pavements(&[("sidewalk", "both")]), [Some(true), Some(true)]);
        assert_eq!(pavements(&[("sidewalk", "right")]), [Some(false), Some(true)]);
        assert_eq!(pavements(&[("sidewalk", "no")]), [Some(false), Some(false)]);
        assert_eq!(pavements(&[("footway", "left")]), [Some(true), Some(false)]);
        assert_eq!(
            pavements(&[("sidewalk:left", "separate"), ("sidewalk:right", "no")]),
            [Some(true), Some(false)]
        );
        assert_eq!(pavements(&[("sidewalk:both", "yes"), ("sidewalk", "no")]), [Some(true), Some(true)]);
        assert_eq!(pavements(&[("sidewalk", "separate")]), [None, None]);
        assert_eq!(pavements(&[("sidewalk", "maybe")]), [None, None]);
        assert!(sides(&[("highway", "residential")]).iter().all(Roadside::is_silent));
    }

    #[test]
    fn parking_old_and_new() {
        let parking = |tags: &[(&str, &str)]| sides(tags).map(|side| side.parking);
        assert_eq!(parking(&[("parking:both", "half_on_kerb")]), [Some(Parking::HalfOnKerb); 2]);
        assert_eq!(parking(&[("parking:left", "street_side")]), [Some(Parking::Bays), None]);
        assert_eq!(parking(&[("parking:right", "no")]), [None, Some(Parking::None)]);
        assert_eq!(parking(&[("parking:left", "yes"), ("parking:right", "separate")]), [None, None]);
        assert_eq!(parking(&[("parking:lane:right", "no_stopping")]), [None, Some(Parking::None)]);
        assert_eq!(parking(&[("parking:lane:left", "parallel")]), [Some(Parking::OnRoad), None]);
        let on_kerb = [("parking:lane:both", "parallel"), ("parking:lane:both:parallel", "on_kerb")];
        assert_eq!(parking(&on_kerb), [Some(Parking::OnKerb); 2]);
    }

    #[test]
    fn kerbs_and_lanes_for_bicycles() {
        let [left, right] = sides(&[("kerb:left", "flush"), ("kerb", "raised"), ("cycleway:right", "lane")]);
        assert_eq!((left.kerb, right.kerb), (Some(Kerb::Flush), Some(Kerb::Raised)));
        assert_eq!((left.cycle_lane, right.cycle_lane), (None, Some(true)));
        let cycle_lanes =
            |value, travel| sides_of(&[("cycleway", value)], travel).map(|side| side.cycle_lane);
        assert_eq!(cycle_lanes("lane", Travel::Both), [Some(true); 2]);
        assert_eq!(cycle_lanes("lane", Travel::Forward), [None; 2]);
        assert_eq!(cycle_lanes("shared_lane", Travel::Both), [Some(false); 2]);
        assert_eq!(sides(&[("cycleway", "track")]).map(|side| side.cycle_lane), [Some(false); 2]);
    }
}
