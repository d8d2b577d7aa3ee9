//! What the map says lies beside a road's carriageway: pavement, kerb, parked cars, a lane for bicycles.
//!
//! Tags mean what the OpenStreetMap wiki says they mean (pages Key:sidewalk, Key:kerb, Key:parking, Key:parking:lane,
//! Key:cycleway); left and right are those of somebody who goes along the way's direction.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::access::Unread;
use crate::{MapNoticeKind, Travel};

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
    /// Left and right side of a way with these tags; `unread` is told of values that say nothing known.
    pub(crate) fn read(tags: &Tags, travel: Travel, unread: &mut Unread<'_>) -> [Self; 2] {
        SIDES.map(|side| {
            // A tag of both sides is told of once.
            let mut unread = |key: &str, value: &str| {
                if side == SIDES[0] || key.contains(side) {
                    unread(MapNoticeKind::Roadside, key, value);
                }
            };
            Self {
                pavement: pavement(tags, side, &mut unread),
                kerb: kerb(tags, side, &mut unread),
                parking: parking(tags, side, &mut unread),
                cycle_lane: cycle_lane(tags, side, travel, &mut unread),
            }
        })
    }

    /// Whether the map says nothing of this side.
    pub fn is_silent(&self) -> bool {
        *self == Self::default()
    }
}

/// A tag that was found: its key and value.
type Found<'a> = (String, &'a str);
/// Takes the key and value of what says nothing known.
type UnreadTag<'a> = dyn FnMut(&str, &str) + 'a;

fn value<'a>(tags: &'a Tags, key: &str) -> Option<Found<'a>> {
    tags.get(key).map(|value| (key.to_owned(), value.as_str()))
}

/// `KEY:left` or `KEY:right`, else `KEY:both`.
fn on_side<'a>(tags: &'a Tags, key: &str, side: &str) -> Option<Found<'a>> {
    value(tags, &format!("{key}:{side}")).or_else(|| value(tags, &format!("{key}:both")))
}

/// `sidewalk:SIDE=yes` and its kin; else `sidewalk=both|left|right|no`, and `footway` of ways tagged long ago.
fn pavement(tags: &Tags, side: &str, unread: &mut UnreadTag<'_>) -> Option<bool> {
    if let Some((key, on_side)) = on_side(tags, "sidewalk", side) {
        return match on_side {
            "yes" | "separate" => Some(true),
            "no" | "none" => Some(false),
            other => {
                unread(&key, other);
                None
            }
        };
    }
    let (key, value) = value(tags, "sidewalk").or_else(|| value(tags, "footway"))?;
    match value {
        "both" | "yes" => Some(true),
        "no" | "none" => Some(false),
        // The pavements are ways of their own, on which sides is not said.
        "separate" => None,
        one if SIDES.contains(&one) => Some(one == side),
        other => {
            unread(&key, other);
            None
        }
    }
}

/// `cycleway:SIDE`; `cycleway` means both sides, but on a one-way road it does not say which it means.
fn cycle_lane(tags: &Tags, side: &str, travel: Travel, unread: &mut UnreadTag<'_>) -> Option<bool> {
    let of_both = || value(tags, "cycleway").filter(|_| travel == Travel::Both);
    let (key, value) = on_side(tags, "cycleway", side).or_else(of_both)?;
    match value {
        "lane" | "opposite_lane" => Some(true),
        // Bicycles share a lane of the road, or have their own way.
        "shared_lane" | "no" | "none" | "track" | "separate" | "opposite_track" => Some(false),
        // They share a bus lane or the whole road, or what there is is not said.
        "share_busway" | "opposite_share_busway" | "opposite" | "shared" | "crossing" | "yes" => None,
        other => {
            unread(&key, other);
            None
        }
    }
}

fn kerb(tags: &Tags, side: &str, unread: &mut UnreadTag<'_>) -> Option<Kerb> {
    let (key, value) = on_side(tags, "kerb", side).or_else(|| value(tags, "kerb"))?;
    match value {
        "raised" | "regular" | "yes" => Some(Kerb::Raised),
        "lowered" | "rolled" => Some(Kerb::Lowered),
        "flush" => Some(Kerb::Flush),
        "no" => Some(Kerb::None),
        other => {
            unread(&key, other);
            None
        }
    }
}

/// `parking:SIDE` as it is tagged since 2022, else `parking:lane:SIDE` of before.
fn parking(tags: &Tags, side: &str, unread: &mut UnreadTag<'_>) -> Option<Parking> {
    if let Some((key, parking)) = on_side(tags, "parking", side) {
        return parked(&key, parking, unread);
    }
    let (key, lane) = on_side(tags, "parking:lane", side)?;
    match lane {
        "no_parking" | "no_stopping" | "fire_lane" => Some(Parking::None),
        angle @ ("parallel" | "diagonal" | "perpendicular" | "marked") => {
            let place =
                [side, "both"].iter().find_map(|side| value(tags, &format!("parking:lane:{side}:{angle}")));
            let place = place.and_then(|(key, place)| parked(&key, place, unread));
            Some(place.unwrap_or(Parking::OnRoad))
        }
        other => parked(&key, other, unread),
    }
}

fn parked(key: &str, place: &str, unread: &mut UnreadTag<'_>) -> Option<Parking> {
    match place {
        "lane" | "on_street" => Some(Parking::OnRoad),
        "half_on_kerb" => Some(Parking::HalfOnKerb),
        "on_kerb" => Some(Parking::OnKerb),
        "street_side" | "lay_by" | "shoulder" => Some(Parking::Bays),
        "no" | "none" => Some(Parking::None),
        // These leave open where.
        "yes" | "separate" => None,
        other => {
            unread(key, other);
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(tags: &[(&str, &str)]) -> [Roadside; 2] {
        sides_of(tags, Travel::Both)
    }

    fn sides_of(tags: &[(&str, &str)], travel: Travel) -> [Roadside; 2] {
        Roadside::read(
            &tags.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect(),
            travel,
            &mut |_, _, _| {},
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
