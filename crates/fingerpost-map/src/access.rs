//! Whether cars may use a road or pass a place (the wiki's pages Key:access, Key:barrier and its values, Key:locked).
//!
//! Private roads are kept: farms, mines and works are where this is driven. So what an access tag says closes a road only
//! where it keeps every car out.

use std::collections::BTreeMap;

use crate::MapNoticeKind;

/// Access tags that speak of cars, the most special first: the first one that is there decides.
pub(crate) const ACCESS_KEYS: [&str; 4] = ["motorcar", "motor_vehicle", "vehicle", "access"];
/// Values that keep every car out, or all but those of a service.
const CLOSED: [&str; 5] = ["no", "emergency", "psv", "bus", "military"];
/// Values that let some car in: everybody's, the owner's, or somebody's with a reason.
const OPEN: [&str; 17] = [
    "yes",
    "permissive",
    "designated",
    "official",
    "private",
    "permit",
    "destination",
    "delivery",
    "customers",
    "residents",
    "employees",
    "agricultural",
    "forestry",
    "discouraged",
    "variable",
    "unknown",
    "license",
];

/// Kinds of barriers that cars pass or that are opened for them: what is written on access there decides, else they are open.
const PASSED_BARRIERS: [&str; 19] = [
    "no",
    "entrance",
    "cattle_grid",
    "toll_booth",
    "border_control",
    "checkpoint",
    "sally_port",
    "gate",
    "lift_gate",
    "swing_gate",
    "sliding_gate",
    "sliding_beam",
    "hampshire_gate",
    "bump_gate",
    "portcullis",
    "height_restrictor",
    "arch",
    "coupure",
    "kerb",
];
/// Kinds that keep cars out where no access tag says otherwise.
const CLOSED_BARRIERS: [&str; 37] = [
    "bar",
    "barrier_board",
    "block",
    "bollard",
    "boulder",
    "bus_trap",
    "cable_barrier",
    "chain",
    "city_wall",
    "cycle_barrier",
    "debris",
    "delineators",
    "ditch",
    "fence",
    "full-height_turnstile",
    "guard_rail",
    "handrail",
    "hedge",
    "horse_stile",
    "jersey_barrier",
    "kissing_gate",
    "log",
    "motorcycle_barrier",
    "planter",
    "retaining_wall",
    "rock",
    "rope",
    "spikes",
    "step",
    "stile",
    "sump_buster",
    "tank_trap",
    "turnstile",
    "tyres",
    "wall",
    "wedge",
    "wicket_gate",
];

/// The keys of a node that say whether cars pass its barrier.
pub(crate) const BARRIER_KEYS: [&str; 11] = [
    "barrier",
    "locked",
    "motorcar",
    "motor_vehicle",
    "vehicle",
    "access",
    "locked:conditional",
    "motorcar:conditional",
    "motor_vehicle:conditional",
    "vehicle:conditional",
    "access:conditional",
];

type Tags = BTreeMap<String, String>;

/// Takes what is not understood: its kind, key and value.
pub(crate) type Unread<'a> = dyn FnMut(MapNoticeKind, &str, &str) + 'a;

/// What access tags say of cars; `suffix` is empty, or `:forward` or `:backward`. `None` where they say nothing.
pub(crate) fn is_open(tags: &Tags, suffix: &str, unread: &mut Unread<'_>) -> Option<bool> {
    let (key, value) = ACCESS_KEYS.iter().find_map(|key| {
        let key = format!("{key}{suffix}");
        tags.get(&key).map(|value| (key, value))
    })?;
    let mut is_open = false;
    // Several values are alternatives: one that lets a car in is enough.
    for value in value.split(';').map(str::trim) {
        if !CLOSED.contains(&value) {
            is_open = true;
            if !OPEN.contains(&value) {
                unread(MapNoticeKind::Access, &key, value);
            }
        }
    }
    Some(is_open)
}

/// Whether a node with these tags lets no car through.
///
/// A lock closes any, else an access tag decides, else the kind: gates, lift gates, toll booths, cattle grids and the like are
/// passed; bollards, blocks and whatever else is named a barrier are not.
pub(crate) fn closes(tags: &Tags, unread: &mut Unread<'_>) -> bool {
    let tag = |key: &str| tags.get(key).map(String::as_str);
    let Some(barrier) = tag("barrier") else { return false };
    for (key, value) in tags.iter().filter(|(key, _)| key.ends_with(":conditional")) {
        unread(MapNoticeKind::Conditional, key, value);
    }
    if tag("locked").is_some_and(|locked| is_locked(locked, unread)) {
        return true;
    }
    if let Some(is_open) = is_open(tags, "", unread) {
        return !is_open;
    }
    if !PASSED_BARRIERS.contains(&barrier) && !CLOSED_BARRIERS.contains(&barrier) {
        unread(MapNoticeKind::Barrier, "barrier", barrier);
    }
    !PASSED_BARRIERS.contains(&barrier)
}

/// What a value of `locked` says; mappers write the wiki's yes and no in other ways too.
fn is_locked(locked: &str, unread: &mut Unread<'_>) -> bool {
    match locked.trim().to_ascii_lowercase().as_str() {
        "yes" | "true" | "1" => true,
        "no" | "false" | "0" => false,
        _ => {
            unread(MapNoticeKind::Locked, "locked", locked);
            false
        }
    }
}
