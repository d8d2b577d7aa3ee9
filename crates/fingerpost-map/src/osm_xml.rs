//! OSM XML, as editors, osmium and Overpass write it: `<osm>` with `<node>`, `<way>` and what servers say in a `<remark>`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesRef, BytesStart, Event};
use quick_xml::reader::Reader;

use crate::access::BARRIER_KEYS;
use crate::elements::{Elements, Version};
use crate::label::ELLIPSIS;
use crate::osm::{OsmError, OsmWay};
use crate::text_encoding::DecodedText;
use crate::xml_attributes::{Attributes, MOST_DEPTH};
use crate::{LatLon, MapNoticeKind};

/// Elements that may stand in a document beside nodes and ways, and from which no road comes.
const PASSED_OVER: [&str; 9] =
    ["note", "meta", "bounds", "bound", "relation", "changeset", "user", "count", "area"];
/// Bytes of a remark that are kept.
const MOST_REMARK_BYTES: usize = 1000;

/// Gives nodes and highways to `elements`, in the document's order.
pub(crate) fn read(document: &DecodedText<'_>, elements: &mut Elements) -> Result<(), OsmError> {
    let DecodedText { text, replaced } = document;
    let copied_bytes = if let Cow::Owned(text) = text { text.capacity() } else { 0 };
    elements.budget.take(copied_bytes)?;
    if *replaced > 0 && elements.are_taken() {
        let first = || format!("byte {}", text.find(char::REPLACEMENT_CHARACTER).unwrap_or_default());
        elements.notices.add_many(MapNoticeKind::Letter, *replaced, first);
    }
    let mut reader = Reader::from_str(text);
    let mut document = Document { elements, depth: 0, is_osm: false, open: Open::Nothing, taken_bytes: 0 };
    loop {
        let at_byte = reader.buffer_position();
        let step = match reader.read_event() {
            Ok(Event::Start(element)) => document.open(&element, at_byte),
            Ok(Event::Empty(element)) => document.open(&element, at_byte).and_then(|()| document.close()),
            Ok(Event::End(_)) => document.close(),
            Ok(Event::Text(text)) => document.text(&text),
            Ok(Event::CData(text)) => document.text(&text),
            // A reference stands between two texts, as in &quot;.
            Ok(Event::GeneralRef(reference)) => document.text(&referred(&reference)),
            Ok(Event::Eof) => break,
            Ok(_) => Ok(()),
            Err(error) => Err(error.to_string().into()),
        };
        step.map_err(|fault| fault.at(at_byte))?;
    }
    document.finish().map_err(|fault| fault.at(text.len() as u64))?;
    elements.budget.give_back(copied_bytes);
    Ok(())
}

/// What a reference stands for: a letter by its number or by its name in XML; itself, where it is neither.
fn referred(reference: &BytesRef<'_>) -> String {
    if let Ok(Some(letter)) = reference.resolve_char_ref() {
        return letter.to_string();
    }
    let known = resolve_predefined_entity(reference);
    known.map_or_else(|| format!("&{};", &**reference), str::to_owned)
}

/// Why reading ends.
enum Fault {
    /// What is wrong with the document.
    Broken(String),
    /// It is too large.
    TooLarge(OsmError),
}

impl Fault {
    fn at(self, at_byte: u64) -> OsmError {
        match self {
            Self::Broken(cause) => OsmError::Xml { at_byte, cause },
            Self::TooLarge(error) => error,
        }
    }
}

impl From<String> for Fault {
    fn from(cause: String) -> Self {
        Self::Broken(cause)
    }
}

impl From<OsmError> for Fault {
    fn from(error: OsmError) -> Self {
        Self::TooLarge(error)
    }
}

/// The element below `<osm>` that is open.
enum Open {
    Nothing,
    /// A node that is there, with those of its tags that speak of barriers.
    Node(BTreeMap<String, String>),
    /// A way; deleted ones too.
    Way(OsmWay, Version),
    Remark(String),
}

/// A document that is read.
struct Document<'a> {
    elements: &'a mut Elements,
    depth: usize,
    is_osm: bool,
    open: Open,
    /// What the open element has taken of the memory for nodes and tags.
    taken_bytes: usize,
}

impl Document<'_> {
    fn open(&mut self, element: &BytesStart<'_>, at_byte: u64) -> Result<(), Fault> {
        if self.depth == MOST_DEPTH {
            return Err(format!("more than {MOST_DEPTH} elements stand within each other").into());
        }
        self.depth += 1;
        match (self.depth, element.name().as_ref()) {
            (1, "osm") => self.is_osm = true,
            (1, other) => return Err(format!("the document is <{other}>, not <osm>").into()),
            (2, "node") => self.open_node(&Attributes::of(element)?)?,
            (2, "way") => {
                let attributes = Attributes::of(element)?;
                let way = OsmWay { id: attributes.number("id")?, nodes: Vec::new(), tags: BTreeMap::new() };
                self.open = Open::Way(way, version(&attributes)?);
            }
            (2, "remark") => self.open = Open::Remark(String::new()),
            (2, other) if !PASSED_OVER.contains(&other) && self.elements.are_taken() => {
                let first = || format!("<{other}> at byte {at_byte}");
                self.elements.notices.add(MapNoticeKind::UnknownElement, first);
            }
            (3, "nd") => self.add_reference(&Attributes::of(element)?)?,
            (3, "tag") => self.add_tag(&Attributes::of(element)?)?,
            _ => {}
        }
        Ok(())
    }

    fn open_node(&mut self, attributes: &Attributes<'_>) -> Result<(), Fault> {
        let version = version(attributes)?;
        let id = attributes.number("id")?;
        // The place of a deleted node may be missing.
        let at = if version.is_deleted { None } else { Some(place(attributes)?) };
        self.elements.node(id, version, at)?;
        if at.is_some() && self.elements.are_taken() {
            self.open = Open::Node(BTreeMap::new());
        }
        Ok(())
    }

    fn add_reference(&mut self, attributes: &Attributes<'_>) -> Result<(), Fault> {
        let Open::Way(way, _) = &mut self.open else { return Ok(()) };
        let id = attributes.number("ref")?;
        self.taken_bytes += self.elements.budget.take_reference()?;
        way.nodes.push(id);
        // osmium and Overpass (`out geom`) can give the node's place here.
        if attributes.find("lat")?.is_some() && self.elements.are_taken() {
            self.elements.place_on_way(id, place(attributes)?)?;
        }
        Ok(())
    }

    fn add_tag(&mut self, attributes: &Attributes<'_>) -> Result<(), Fault> {
        let (key, value) = (attributes.text("k")?, attributes.text("v")?);
        let tags = match &mut self.open {
            Open::Way(way, _) => &mut way.tags,
            Open::Node(tags) if BARRIER_KEYS.contains(&&*key) => tags,
            _ => return Ok(()),
        };
        self.taken_bytes += self.elements.budget.take_tag(&key, &value)?;
        tags.insert(key.into_owned(), value.into_owned());
        Ok(())
    }

    /// Takes text between tags, as much of a remark as is kept; an ellipsis stands for the rest.
    fn text(&mut self, text: &str) -> Result<(), Fault> {
        if let Open::Remark(remark) = &mut self.open
            && remark.len() < MOST_REMARK_BYTES
        {
            let kept = text.floor_char_boundary(MOST_REMARK_BYTES - remark.len());
            remark.push_str(&text[..kept]);
            if kept < text.len() {
                remark.truncate(remark.floor_char_boundary(MOST_REMARK_BYTES - ELLIPSIS.len_utf8()));
                remark.push(ELLIPSIS);
            }
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), Fault> {
        self.depth = self.depth.saturating_sub(1);
        if self.depth != 1 {
            return Ok(());
        }
        let taken_bytes = std::mem::take(&mut self.taken_bytes);
        let are_taken = self.elements.are_taken();
        match std::mem::replace(&mut self.open, Open::Nothing) {
            Open::Node(tags) if tags.contains_key("barrier") => self.elements.barrier(tags)?,
            Open::Way(way, version) => {
                let is_kept = !version.is_deleted && way.tags.contains_key("highway");
                if is_kept && are_taken {
                    self.elements.budget.take_way()?;
                } else {
                    self.elements.budget.give_back(taken_bytes);
                }
                self.elements.way(way.id, version, is_kept.then_some(way));
            }
            Open::Remark(remark) if are_taken => self.elements.notices.add(MapNoticeKind::Remark, || remark),
            _ => self.elements.budget.give_back(taken_bytes),
        }
        Ok(())
    }

    fn finish(self) -> Result<(), Fault> {
        if !self.is_osm {
            Err("there is no <osm> element".to_owned().into())
        } else if self.depth > 0 {
            Err("the document ends in the middle; it is cut short".to_owned().into())
        } else {
            Ok(())
        }
    }
}

/// The place that an element's attributes say.
fn place(attributes: &Attributes<'_>) -> Result<LatLon, String> {
    LatLon::new(attributes.number("lat")?, attributes.number("lon")?).map_err(|error| error.to_string())
}

/// An element's version; editors mark what they have deleted, histories what was.
fn version(attributes: &Attributes<'_>) -> Result<Version, String> {
    let is = |key: &str, value: &str| attributes.find(key).map(|found| found.as_deref() == Some(value));
    Ok(Version {
        number: attributes.optional_number("version")?.unwrap_or_default(),
        is_deleted: is("visible", "false")? || is("action", "delete")?,
    })
}
