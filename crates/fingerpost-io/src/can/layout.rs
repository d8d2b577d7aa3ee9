//! What a signal's bits mean.

use std::ops::RangeInclusive;

use super::bits::BitField;
use super::frame::{CanFrame, CanId};
use super::j1939::{self, NoValue};

/// How a signal's bits are to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// Without sign.
    Unsigned,
    /// Two's complement.
    Signed,
    /// IEEE 754, 32 bits.
    Float32,
    /// IEEE 754, 64 bits.
    Float64,
}

impl Reading {
    /// The number of bits that it must have; none where any will do.
    pub(super) const fn bits(self) -> Option<usize> {
        match self {
            Self::Unsigned | Self::Signed => None,
            Self::Float32 => Some(32),
            Self::Float64 => Some(64),
        }
    }
}

/// A frame holds a multiplexed signal only while its multiplexer has one of some values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Condition {
    /// The multiplexer's bits.
    pub(super) multiplexer: BitField,
    /// Its values that select the signal.
    pub(super) selects: Vec<RangeInclusive<u64>>,
}

/// Where a signal stands in its message and what its bits mean.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalLayout {
    /// `MESSAGE.SIGNAL`.
    pub name: String,
    /// The message, with an address of its own where it is one of J1939.
    pub message: CanId,
    /// Bits of a 29-bit identifier that frames of the message have in common with it: all, or those of its group in J1939.
    pub(super) id_bits: u32,
    /// Unit as the DBC file has it, for people.
    pub unit: String,
    /// What single values of the bits are called.
    pub value_names: Vec<(i64, String)>,
    pub(super) bits: BitField,
    pub(super) reading: Reading,
    pub(super) factor: f64,
    pub(super) offset: f64,
    pub(super) conditions: Vec<Condition>,
}

/// What a frame says of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SignalReading {
    /// Its value, scaled as the DBC file says.
    Value(f64),
    /// That there is none.
    NoValue(NoValue),
}

impl SignalReading {
    /// The value, if there is one.
    pub const fn value(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::NoValue(_) => None,
        }
    }
}

impl SignalLayout {
    /// What a frame says of the signal; none where the frame is another message, is too short or holds other multiplexed signals.
    pub fn decode(&self, frame: &CanFrame) -> Option<SignalReading> {
        if !self.is_in(frame.id) {
            return None;
        }
        let data = frame.data();
        let selected = self.conditions.iter().all(|condition| {
            let value = condition.multiplexer.unsigned(data);
            value.is_some_and(|value| condition.selects.iter().any(|range| range.contains(&value)))
        });
        if !selected {
            return None;
        }
        let raw = match self.reading {
            Reading::Unsigned => {
                let raw = self.bits.unsigned(data)?;
                if let Some(no_value) = j1939::no_value(raw, self.bits.size).filter(|_| self.is_j1939()) {
                    return Some(SignalReading::NoValue(no_value));
                }
                raw as f64
            }
            Reading::Signed => self.bits.signed(data)? as f64,
            Reading::Float32 => f64::from(f32::from_bits(self.bits.unsigned(data)? as u32)),
            Reading::Float64 => f64::from_bits(self.bits.unsigned(data)?),
        };
        Some(SignalReading::Value(raw * self.factor + self.offset))
    }

    /// Whether its message is a parameter group of J1939.
    const fn is_j1939(&self) -> bool {
        self.id_bits != u32::MAX
    }

    /// Whether two identifiers of the signal's message are of one sender: of J1939, those of one source address.
    pub(super) const fn is_same_sender(&self, a: CanId, b: CanId) -> bool {
        match (a, b) {
            (CanId::Extended(a), CanId::Extended(b)) if self.is_j1939() => {
                j1939::source_address(a) == j1939::source_address(b)
            }
            // A message of another bus has one identifier.
            _ => true,
        }
    }

    /// Whether frames with that identifier are of the signal's message.
    pub fn is_in(&self, id: CanId) -> bool {
        match (id, self.message) {
            (CanId::Extended(id), CanId::Extended(message)) => (id ^ message) & self.id_bits == 0,
            (id, message) => id == message,
        }
    }

    /// The scaled value that is called `name` in the file's value table.
    pub fn value_named(&self, name: &str) -> Option<f64> {
        let (raw, _) = self.value_names.iter().find(|(_, known)| known.eq_ignore_ascii_case(name))?;
        Some(*raw as f64 * self.factor + self.offset)
    }
}
