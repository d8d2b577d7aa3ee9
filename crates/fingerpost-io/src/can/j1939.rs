//! Which frames of 29-bit identifiers are one message of J1939 (SAE J1939-21): those of a parameter group, whoever sends them.
//!
//! An identifier is a priority of 3 bits, two bits of data page, a format and a specific byte, and the sender's address. From format 240 on
//! the specific byte belongs to the group; below it is the receiver's address. Priority and addresses are set up in each vehicle, so that
//! a database, which has some of its own, does not say them.
//!
//! And which values of a parameter say that it has none (SAE J1939-71, transmitted signal ranges). Parameters of other sizes than one,
//! two and four bytes and two bits have no such values there, and are taken as they are.

use can_dbc::{AttributeDefinition, AttributeValue, AttributeValueType, Dbc, Message, MessageId};

/// Bits of an identifier that name the group, with the specific byte.
const GROUP_WITH_SPECIFIC: u32 = 0x03FF_FF00;
/// The same without it.
const GROUP: u32 = 0x03FF_0000;
/// Formats from here on have no receiver.
const FIRST_BROADCAST_FORMAT: u32 = 240;
/// The address of nobody, by which databases say that any sender is meant.
const NULL_ADDRESS: u32 = 0xFE;

/// Attribute of messages, and its value for those of J1939; then that of a whole database (Vector's DBC attributes).
const FRAME_FORMAT: &str = "VFrameFormat";
const J1939_FORMAT: &str = "J1939PG";
const PROTOCOL: &str = "ProtocolType";
const J1939: &str = "J1939";

/// Why a parameter has no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoValue {
    /// Its sender does not have it.
    NotAvailable,
    /// What its sender measures it with is at fault.
    Error,
}

/// Whether the bits of a parameter say that it has no value: of bytes the highest one, of two bits both.
pub(super) const fn no_value(raw: u64, size: usize) -> Option<NoValue> {
    /// Highest bytes of a parameter that is not available, and of an error.
    const NOT_AVAILABLE: u64 = 0xFF;
    const ERROR: u64 = 0xFE;
    let highest = match size {
        // Two bits are the lowest of such a byte.
        2 => raw | 0xFC,
        8 | 16 | 32 => raw >> (size - 8),
        _ => return None,
    };
    match highest {
        NOT_AVAILABLE => Some(NoValue::NotAvailable),
        ERROR => Some(NoValue::Error),
        _ => None,
    }
}

/// The sender's address in a 29-bit identifier.
pub(super) const fn source_address(id: u32) -> u32 {
    id & 0xFF
}

/// The bits of a 29-bit identifier that name its parameter group.
pub(super) const fn group_bits(id: u32) -> u32 {
    if id >> 16 & 0xFF >= FIRST_BROADCAST_FORMAT { GROUP_WITH_SPECIFIC } else { GROUP }
}

/// Whether a message is one of J1939: its format says so, or else the protocol of the database, or else nobody's address.
pub(super) fn is_j1939(dbc: &Dbc, message: &Message) -> bool {
    let MessageId::Extended(id) = message.id else { return false };
    if let Some(format) =
        dbc.resolved_message_attribute(message.id, FRAME_FORMAT).and_then(|value| text(dbc, value))
    {
        return format == J1939_FORMAT;
    }
    let protocol = dbc.attribute_values_database.iter().find(|value| value.name == PROTOCOL);
    match protocol.map(|protocol| &protocol.value).or_else(|| dbc.attribute_default(PROTOCOL)) {
        Some(AttributeValue::String(protocol)) if !protocol.is_empty() => protocol == J1939,
        _ => source_address(id) == NULL_ADDRESS,
    }
}

/// What a value of the format's enumeration is called: it is written as its name or its place.
fn text<'a>(dbc: &'a Dbc, value: &'a AttributeValue) -> Option<&'a str> {
    let place = match value {
        AttributeValue::String(name) => return Some(name),
        AttributeValue::Uint(place) => usize::try_from(*place).ok()?,
        AttributeValue::Int(place) => usize::try_from(*place).ok()?,
        AttributeValue::Double(_) => return None,
    };
    let names = dbc.attribute_definitions.iter().find_map(|definition| match definition {
        AttributeDefinition::Message(name, AttributeValueType::Enum(names)) if name == FRAME_FORMAT => {
            Some(names)
        }
        _ => None,
    });
    names?.get(place).map(String::as_str)
}
