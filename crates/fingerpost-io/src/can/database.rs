//! DBC files: the layouts of all signals by their names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use can_dbc::{Dbc, Message, MessageId, MultiplexIndicator, Signal, SignalExtendedValueType, ValueType};
use thiserror::Error;

use super::bits::{BitField, ByteOrder};
use super::frame::CanId;
use super::j1939::{group_bits, is_j1939};
use super::layout::{Condition, Reading, SignalLayout};
use crate::file::{FileError, read_bytes};

/// Multiplexers that stand behind one another at the most; a file whose multiplexers select each other in a ring must end.
const MAX_MULTIPLEXERS: usize = 8;
/// Bit of a message's number in a DBC file that marks an identifier of 29 bits.
const EXTENDED_MARK: u64 = 1 << 31;
/// Names that a message about an unknown one lists.
const NEAR_NAMES: usize = 5;

/// A DBC file that cannot be used.
#[derive(Debug, Error)]
pub enum CanDatabaseError {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its text is no DBC file.
    #[error("{} is no DBC file that can be read; give the database of this vehicle's bus: {cause}", .path.display())]
    Contents {
        /// The file.
        path: PathBuf,
        /// What the reader says.
        cause: String,
    },
}

/// A name that no signal has, or whose signal cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UnknownSignal {
    /// There is none of that name.
    #[error("the DBC file has no signal {name:?}; names are MESSAGE.SIGNAL, and near to it are {}", .near.join(", "))]
    Name {
        /// What was asked for.
        name: String,
        /// Names that look like it.
        near: Vec<String>,
    },
    /// Its bits cannot be where the file says.
    #[error("the DBC file gives signal {name:?} {size} bits, and 1 to 64 can be read; correct the file")]
    Size {
        /// What was asked for.
        name: String,
        /// Its number of bits.
        size: u64,
    },
    /// Its bits are said to be a floating-point number, and are not as many as one has.
    #[error(
        "the DBC file says that signal {name:?} is an IEEE number and gives it {size} bits; correct the file"
    )]
    Float {
        /// What was asked for.
        name: String,
        /// Its number of bits.
        size: usize,
    },
    /// No frame can have the identifier of its message.
    #[error(
        "the DBC file gives the message of signal {name:?} the identifier {identifier}, which has more than 11 bits; a 29-bit \
         one is written with 2147483648 added: correct the file"
    )]
    Identifier {
        /// What was asked for.
        name: String,
        /// The identifier as the file has it.
        identifier: u64,
    },
    /// What selects it is not in the file.
    #[error(
        "signal {name:?} is multiplexed, and the DBC file does not say by which signal of its message; correct the file"
    )]
    Multiplexer {
        /// What was asked for.
        name: String,
    },
}

/// The signals of a DBC file.
#[derive(Debug, Clone)]
pub struct CanDatabase {
    dbc: Dbc,
    /// Identifiers too wide for messages that are not marked as extended, by the messages' names: the reader cuts them to 16
    /// bits, and the signals would be looked for in another message's frames.
    wide: BTreeMap<String, u64>,
}

impl CanDatabase {
    /// Reads a DBC file, UTF-8 or Latin-1.
    ///
    /// # Errors
    /// [`CanDatabaseError`] when it cannot be read or is no DBC file.
    pub fn read(path: &Path) -> Result<Self, CanDatabaseError> {
        let bytes = read_bytes(path)?;
        let text = String::from_utf8(bytes);
        let text =
            text.unwrap_or_else(|cause| cause.as_bytes().iter().map(|byte| char::from(*byte)).collect());
        let contents = |cause: String| CanDatabaseError::Contents { path: path.to_owned(), cause };
        let dbc = Dbc::try_from(text.trim_start_matches('\u{feff}'));
        let dbc = dbc.map_err(|cause| contents(cause.to_string().replace('\n', " ")))?;
        if dbc.messages.is_empty() {
            return Err(contents("it describes no message".to_owned()));
        }
        Ok(Self { wide: wide_identifiers(&text), dbc })
    }

    /// The layout of the signal `MESSAGE.SIGNAL`.
    ///
    /// # Errors
    /// [`UnknownSignal`] when the file has none of that name, with names near to it, or describes it in a way that cannot be
    /// read.
    pub fn signal(&self, name: &str) -> Result<SignalLayout, UnknownSignal> {
        let found = name.split_once('.').and_then(|(message, signal)| {
            let message = self.dbc.messages.iter().find(|known| known.name == message)?;
            Some((message, message.signals.iter().find(|known| known.name == signal)?))
        });
        let Some((message, signal)) = found else {
            return Err(UnknownSignal::Name { name: name.to_owned(), near: self.near(name) });
        };
        if let Some(&identifier) = self.wide.get(&message.name) {
            return Err(UnknownSignal::Identifier { name: name.to_owned(), identifier });
        }
        let bits = bit_field(signal)
            .ok_or_else(|| UnknownSignal::Size { name: name.to_owned(), size: signal.size })?;
        let reading = self.reading(message, signal);
        if reading.bits().is_some_and(|size| size != bits.size) {
            return Err(UnknownSignal::Float { name: name.to_owned(), size: bits.size });
        }
        let conditions = self
            .conditions(message, signal)
            .ok_or_else(|| UnknownSignal::Multiplexer { name: name.to_owned() })?;
        let values = self.dbc.value_descriptions_for_signal(message.id, &signal.name).unwrap_or_default();
        Ok(SignalLayout {
            name: name.to_owned(),
            message: can_id(message.id),
            id_bits: match message.id {
                MessageId::Extended(id) if is_j1939(&self.dbc, message) => group_bits(id),
                _ => u32::MAX,
            },
            unit: signal.unit.clone(),
            value_names: values.iter().map(|value| (value.id, value.description.clone())).collect(),
            bits,
            reading,
            factor: signal.factor,
            offset: signal.offset,
            conditions,
        })
    }

    /// The names most like `name`, the likest first.
    fn near(&self, name: &str) -> Vec<String> {
        let wanted = name.to_lowercase();
        let wanted_signal = wanted.rsplit('.').next().unwrap_or_default().to_owned();
        let likeness = |message: &Message, signal: &Signal| {
            let whole = format!("{}.{}", message.name, signal.name).to_lowercase();
            let signal = signal.name.to_lowercase();
            strsim::jaro_winkler(&wanted, &whole).max(strsim::jaro_winkler(&wanted_signal, &signal))
        };
        let messages = self.dbc.messages.iter();
        let mut ranked: Vec<(f64, String)> = messages
            .flat_map(|message| message.signals.iter().map(move |signal| (message, signal)))
            .map(|(message, signal)| (likeness(message, signal), format!("{}.{}", message.name, signal.name)))
            .collect();
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        ranked.into_iter().take(NEAR_NAMES).map(|(_, name)| name).collect()
    }

    fn reading(&self, message: &Message, signal: &Signal) -> Reading {
        let extended = self.dbc.extended_value_type_for_signal(message.id, &signal.name);
        match (extended, signal.value_type) {
            (Some(SignalExtendedValueType::IEEEfloat32Bit), _) => Reading::Float32,
            (Some(SignalExtendedValueType::IEEEdouble64bit), _) => Reading::Float64,
            (_, ValueType::Signed) => Reading::Signed,
            (_, ValueType::Unsigned) => Reading::Unsigned,
        }
    }

    /// What must hold for a frame to have the signal; none where the file does not say.
    fn conditions(&self, message: &Message, signal: &Signal) -> Option<Vec<Condition>> {
        let mut conditions = Vec::new();
        let mut selected = signal;
        while let MultiplexIndicator::MultiplexedSignal(value)
        | MultiplexIndicator::MultiplexorAndMultiplexedSignal(value) = selected.multiplexer_indicator
        {
            if conditions.len() == MAX_MULTIPLEXERS {
                return None;
            }
            let extended = self
                .dbc
                .extended_multiplex
                .iter()
                .find(|known| known.message_id == message.id && known.signal_name == selected.name);
            let (multiplexer, selects) = match extended {
                Some(extended) => (
                    message.signals.iter().find(|known| known.name == extended.multiplexor_signal_name)?,
                    extended.mappings.iter().map(|range| range.min_value..=range.max_value).collect(),
                ),
                None => (
                    message
                        .signals
                        .iter()
                        .find(|known| known.multiplexer_indicator == MultiplexIndicator::Multiplexor)?,
                    vec![value..=value],
                ),
            };
            conditions.push(Condition { multiplexer: bit_field(multiplexer)?, selects });
            selected = multiplexer;
        }
        Some(conditions)
    }
}

fn bit_field(signal: &Signal) -> Option<BitField> {
    let size = usize::try_from(signal.size).ok().filter(|size| (1..=64).contains(size))?;
    // No frame has more bits; this also keeps sums of places within their type.
    let start = usize::try_from(signal.start_bit).ok().filter(|start| *start < 8 * 2048)?;
    let order = match signal.byte_order {
        can_dbc::ByteOrder::LittleEndian => ByteOrder::LittleEndian,
        can_dbc::ByteOrder::BigEndian => ByteOrder::BigEndian,
    };
    Some(BitField { start, size, order })
}

/// The messages of a DBC file's text whose identifiers have more than 11 bits and no mark of an extended one.
fn wide_identifiers(text: &str) -> BTreeMap<String, u64> {
    let message = |line: &str| {
        let mut words =
            line.trim_start().strip_prefix("BO_")?.split([' ', '\t', ':']).filter(|word| !word.is_empty());
        let identifier: u64 = words.next()?.parse().ok()?;
        Some((words.next()?.to_owned(), identifier))
    };
    let is_wide = |identifier: u64| identifier & EXTENDED_MARK == 0 && identifier >= 1 << 11;
    text.lines().filter_map(message).filter(|(_, identifier)| is_wide(*identifier)).collect()
}

const fn can_id(id: MessageId) -> CanId {
    match id {
        MessageId::Standard(id) => CanId::Standard(id),
        MessageId::Extended(id) => CanId::Extended(id),
    }
}
