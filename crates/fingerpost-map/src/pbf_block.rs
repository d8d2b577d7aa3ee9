//! A block of OSM PBF (the format's `osmformat.proto`): its nodes and highways.
//!
//! Nothing is taken for a number that the block states; texts are looked up where they lie. Relations are passed over.

use std::collections::BTreeMap;

use crate::LatLon;
use crate::access::BARRIER_KEYS;
use crate::elements::{Elements, Version};
use crate::osm::{OsmError, OsmWay};
use crate::osm_budget::Budget;
use crate::osm_pbf::broken;
use crate::pbf_fields::{Fields, Packed, Sums, Value, signed};

/// Billionths of a degree in a unit of a block that does not say it.
const GRANULARITY: i64 = 100;

/// Gives what a block holds to `elements`.
pub(crate) fn read_block(block: &[u8], elements: &mut Elements) -> Result<(), OsmError> {
    let reading = Block::of(block, &mut elements.budget)?;
    let taken = reading.texts.len().saturating_mul(size_of::<&[u8]>());
    let mut fields = Fields::of(block);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if number == 2 {
            reading.group(value.bytes().map_err(broken)?, elements)?;
        }
    }
    drop(reading);
    elements.budget.give_back(taken);
    Ok(())
}

/// What the elements of a block refer to.
struct Block<'a> {
    texts: Vec<&'a [u8]>,
    granularity: i64,
    lat_offset: i64,
    lon_offset: i64,
}

impl<'a> Block<'a> {
    fn of(block: &'a [u8], budget: &mut Budget) -> Result<Self, OsmError> {
        let mut made = Self { texts: Vec::new(), granularity: GRANULARITY, lat_offset: 0, lon_offset: 0 };
        let mut table: &[u8] = &[];
        let mut fields = Fields::of(block);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Bytes(bytes)) => table = bytes,
                (17, Value::Number(number)) => made.granularity = i64::from(number as i32),
                (19, Value::Number(number)) => made.lat_offset = number as i64,
                (20, Value::Number(number)) => made.lon_offset = number as i64,
                _ => {}
            }
        }
        let mut count = 0_usize;
        each_text(table, |_| count += 1)?;
        budget.take(count.saturating_mul(size_of::<&[u8]>()))?;
        made.texts.reserve_exact(count);
        each_text(table, |text| made.texts.push(text))?;
        Ok(made)
    }

    fn group(&self, group: &[u8], elements: &mut Elements) -> Result<(), OsmError> {
        let mut fields = Fields::of(group);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Bytes(node)) => self.node(node, elements)?,
                (2, Value::Bytes(nodes)) => self.dense_nodes(nodes, elements)?,
                (3, Value::Bytes(way)) => self.way(way, elements)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn node(&self, node: &[u8], elements: &mut Elements) -> Result<(), OsmError> {
        let (mut id, mut lat, mut lon, mut version) = (None, None, None, Version::default());
        let mut fields = Fields::of(node);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Number(number)) => id = Some(signed(number)),
                (4, Value::Bytes(info)) => version = version_of(info)?,
                (8, Value::Number(number)) => lat = Some(signed(number)),
                (9, Value::Number(number)) => lon = Some(signed(number)),
                _ => {}
            }
        }
        let (Some(id), Some(lat), Some(lon)) = (id, lat, lon) else {
            return Err(broken("a node without number or place"));
        };
        self.place(id, version, lat, lon, elements)?;
        let [keys, values] = columns(node, [2, 3])?;
        let (mut keys, mut values) = (Packed::of(keys), Packed::of(values));
        self.barrier(version, elements, || Ok(keys.next()?.zip(values.next()?)))
    }

    fn dense_nodes(&self, nodes: &[u8], elements: &mut Elements) -> Result<(), OsmError> {
        let [ids, info, lats, lons, tags] = columns(nodes, [1, 5, 8, 9, 10])?;
        let [versions, visible] = columns(info, [1, 6])?;
        let (mut ids, mut lats, mut lons) = (Sums::of(ids), Sums::of(lats), Sums::of(lons));
        let (mut versions, mut visible, mut tags) =
            (Packed::of(versions), Packed::of(visible), Packed::of(tags));
        loop {
            let (id, lat, lon) = match [&mut ids, &mut lats, &mut lons].map(Sums::next) {
                [Ok(None), Ok(None), Ok(None)] => return Ok(()),
                [Ok(Some(id)), Ok(Some(lat)), Ok(Some(lon))] => (id, lat, lon),
                [Err(cause), ..] | [_, Err(cause), _] | [.., Err(cause)] => return Err(broken(cause)),
                _ => return Err(broken("nodes have not as many places as numbers")),
            };
            let version = Version {
                number: versions.next().map_err(broken)?.map_or(0, |number| i64::from(number as i32)),
                is_deleted: visible.next().map_err(broken)? == Some(0),
            };
            self.place(id, version, lat, lon, elements)?;
            // The tags of all nodes stand in one list, those of each before a zero.
            self.barrier(version, elements, || match tags.next()? {
                None | Some(0) => Ok(None),
                Some(key) => Ok(Some(key).zip(tags.next()?)),
            })?;
        }
    }

    /// Takes a node at a place in the block's units.
    fn place(
        &self,
        id: i64,
        version: Version,
        lat: i64,
        lon: i64,
        elements: &mut Elements,
    ) -> Result<(), OsmError> {
        // The place of a deleted node means nothing.
        let at = if version.is_deleted { None } else { Some(self.at(id, lat, lon)?) };
        elements.node(id, version, at)
    }

    /// A node's place in the block's units.
    fn at(&self, id: i64, lat: i64, lon: i64) -> Result<LatLon, OsmError> {
        let degrees = |at: i64, offset: i64| {
            let nano_degrees = at.checked_mul(self.granularity).and_then(|at| at.checked_add(offset));
            // The division rounds to the f64 that the decimal number in OSM XML reads as.
            nano_degrees.map(|nano_degrees| nano_degrees as f64 / 1e9)
        };
        let at = degrees(lat, self.lat_offset).zip(degrees(lon, self.lon_offset));
        let (lat_deg, lon_deg) = at.ok_or_else(|| broken(format!("node {id} has a place beyond 64 bits")))?;
        LatLon::new(lat_deg, lon_deg).map_err(|error| broken(format!("node {id}: {error}")))
    }

    /// Takes the tags of the last node where they name a barrier; `next` gives the numbers of a tag's key and value.
    fn barrier(
        &self,
        version: Version,
        elements: &mut Elements,
        mut next: impl FnMut() -> Result<Option<(u64, u64)>, String>,
    ) -> Result<(), OsmError> {
        let mut tags = BTreeMap::new();
        let mut taken_bytes = 0;
        while let Some((key, value)) = next().map_err(broken)? {
            let key = self.text(key)?;
            let Some(key) = BARRIER_KEYS.into_iter().find(|known| known.as_bytes() == key) else { continue };
            let value = str::from_utf8(self.text(value)?);
            let value = value.map_err(|_| broken(format!("{key} of a node is not UTF-8 text")))?;
            taken_bytes += elements.budget.take_tag(key, value)?;
            tags.insert(key.to_owned(), value.to_owned());
        }
        if tags.contains_key("barrier") && !version.is_deleted && elements.are_taken() {
            return elements.barrier(tags);
        }
        elements.budget.give_back(taken_bytes);
        Ok(())
    }

    fn way(&self, way: &[u8], elements: &mut Elements) -> Result<(), OsmError> {
        let (mut id, mut version) = (None, Version::default());
        let mut fields = Fields::of(way);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Number(number)) => id = Some(number as i64),
                (4, Value::Bytes(info)) => version = version_of(info)?,
                _ => {}
            }
        }
        let id = id.ok_or_else(|| broken("a way without a number"))?;
        let [keys, values, references, lats, lons] = columns(way, [2, 3, 8, 9, 10])?;
        let mut is_highway = false;
        self.each_tag(keys, values, |key, _| {
            is_highway |= key == b"highway";
            Ok(())
        })?;
        if !is_highway || version.is_deleted {
            elements.way(id, version, None);
            return Ok(());
        }
        let mut way = OsmWay { id, nodes: Vec::new(), tags: BTreeMap::new() };
        if elements.are_taken() {
            elements.budget.take_way()?;
            self.each_tag(keys, values, |key, value| {
                let [key, value] = [key, value].map(str::from_utf8);
                let (Ok(key), Ok(value)) = (key, value) else {
                    return Err(broken(format!("a tag of way {id} is not UTF-8 text")));
                };
                elements.budget.take_tag(key, value)?;
                way.tags.insert(key.to_owned(), value.to_owned());
                Ok(())
            })?;
            self.references([references, lats, lons], &mut way.nodes, elements)?;
        }
        elements.way(id, version, Some(way));
        Ok(())
    }

    /// Takes the numbers of a way's nodes, and their places where the way has them.
    fn references(
        &self,
        [ids, lats, lons]: [&[u8]; 3],
        nodes: &mut Vec<i64>,
        elements: &mut Elements,
    ) -> Result<(), OsmError> {
        let (mut ids, mut lats, mut lons) = (Sums::of(ids), Sums::of(lats), Sums::of(lons));
        while let Some(id) = ids.next().map_err(broken)? {
            elements.budget.take_reference()?;
            nodes.push(id);
            if let (Some(lat), Some(lon)) = (lats.next().map_err(broken)?, lons.next().map_err(broken)?) {
                elements.place_on_way(id, self.at(id, lat, lon)?)?;
            }
        }
        Ok(())
    }

    fn each_tag(
        &self,
        keys: &[u8],
        values: &[u8],
        mut each: impl FnMut(&'a [u8], &'a [u8]) -> Result<(), OsmError>,
    ) -> Result<(), OsmError> {
        let (mut keys, mut values) = (Packed::of(keys), Packed::of(values));
        loop {
            let (key, value) = (keys.next().map_err(broken)?, values.next().map_err(broken)?);
            match (key, value) {
                (None, None) => return Ok(()),
                (Some(key), Some(value)) => each(self.text(key)?, self.text(value)?)?,
                _ => return Err(broken("a way has not as many values as keys")),
            }
        }
    }

    fn text(&self, number: u64) -> Result<&'a [u8], OsmError> {
        let text = usize::try_from(number).ok().and_then(|number| self.texts.get(number));
        text.copied().ok_or_else(|| broken(format!("a tag has text {number} of {}", self.texts.len())))
    }
}

/// The packed numbers of the fields of these numbers; none where a field is missing.
fn columns<const N: usize>(message: &[u8], wanted: [u32; N]) -> Result<[&[u8]; N], OsmError> {
    let mut found: [&[u8]; N] = [&[]; N];
    let mut fields = Fields::of(message);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if let Some(place) = wanted.iter().position(|wanted| *wanted == number) {
            let bytes = value.bytes().map_err(broken)?;
            if !found[place].is_empty() {
                return Err(broken("numbers that belong together stand in two fields"));
            }
            found[place] = bytes;
        }
    }
    Ok(found)
}

fn each_text<'a>(table: &'a [u8], mut each: impl FnMut(&'a [u8])) -> Result<(), OsmError> {
    let mut fields = Fields::of(table);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if number == 1 {
            each(value.bytes().map_err(broken)?);
        }
    }
    Ok(())
}

/// The version that an element's information says.
fn version_of(info: &[u8]) -> Result<Version, OsmError> {
    let mut version = Version::default();
    let mut fields = Fields::of(info);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        match (number, value) {
            (1, Value::Number(number)) => version.number = i64::from(number as i32),
            (6, Value::Number(visible)) => version.is_deleted = visible == 0,
            _ => {}
        }
    }
    Ok(version)
}
