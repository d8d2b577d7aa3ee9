//! The attributes of an XML element, in bounds.

use std::borrow::Cow;
use std::str::FromStr;

use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

/// Attributes of an element at the most: those of OpenStreetMap and GPX have about ten.
const MOST_ATTRIBUTES: usize = 64;
/// Elements within each other at the most: OpenStreetMap's have two above them, a track's points five, extensions of receivers
/// a few more.
pub(crate) const MOST_DEPTH: usize = 64;

/// The attributes of one element; values are copied where they hold references alone.
pub(crate) struct Attributes<'a> {
    element: &'a BytesStart<'a>,
}

impl<'a> Attributes<'a> {
    /// Those of an element.
    ///
    /// # Errors
    /// More than 64, one twice, or what is no attribute.
    pub(crate) fn of(element: &'a BytesStart<'a>) -> Result<Self, String> {
        for (count, attribute) in element.attributes().enumerate() {
            attribute.map_err(|error| error.to_string())?;
            if count == MOST_ATTRIBUTES {
                let name = element.name();
                return Err(format!("<{}> has more than {MOST_ATTRIBUTES} attributes", name.as_ref()));
            }
        }
        Ok(Self { element })
    }

    /// The value of an attribute, if the element has it.
    pub(crate) fn find(&self, key: &str) -> Result<Option<Cow<'a, str>>, String> {
        let found = self.element.try_get_attribute(key).map_err(|error| error.to_string())?;
        let value = found.map(|found| found.normalized_value(XmlVersion::Implicit1_0)).transpose();
        value.map_err(|error| error.to_string())
    }

    /// The value of an attribute that must be there.
    pub(crate) fn text(&self, key: &str) -> Result<Cow<'a, str>, String> {
        let name = self.element.name();
        self.find(key)?.ok_or_else(|| format!("<{}> lacks the attribute {key}", name.as_ref()))
    }

    /// The number that an attribute holds, which must be there.
    pub(crate) fn number<T: FromStr>(&self, key: &str) -> Result<T, String> {
        self.text(key).and_then(|text| self.parsed(key, &text))
    }

    /// The number that an attribute holds, if the element has it.
    pub(crate) fn optional_number<T: FromStr>(&self, key: &str) -> Result<Option<T>, String> {
        self.find(key)?.map(|text| self.parsed(key, &text)).transpose()
    }

    fn parsed<T: FromStr>(&self, key: &str, text: &str) -> Result<T, String> {
        let name = self.element.name();
        text.trim().parse().map_err(|_| format!("{key}=\"{text}\" of <{}> is no number", name.as_ref()))
    }
}
