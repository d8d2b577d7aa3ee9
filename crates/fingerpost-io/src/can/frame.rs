//! A frame of the bus.

use std::fmt;

/// Most bytes in a frame: CAN FD's.
const MAX_LENGTH: usize = 64;

/// What a frame is about; also its rank on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CanId {
    /// 11 bits.
    Standard(u16),
    /// 29 bits.
    Extended(u32),
}

impl CanId {
    /// Whether it has no more bits than it can have.
    pub(super) const fn is_possible(self) -> bool {
        match self {
            Self::Standard(id) => id < 1 << 11,
            Self::Extended(id) => id < 1 << 29,
        }
    }
}

impl fmt::Display for CanId {
    /// As candump writes it: three or eight hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Standard(id) => write!(f, "{id:03X}"),
            Self::Extended(id) => write!(f, "{id:08X}"),
        }
    }
}

/// A data frame, CAN 2.0 or CAN FD.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    /// What it is about.
    pub id: CanId,
    data: [u8; MAX_LENGTH],
    length: usize,
}

impl CanFrame {
    /// A frame with these bytes; none where they are more than a frame can hold, 64.
    pub fn new(id: CanId, bytes: &[u8]) -> Option<Self> {
        let mut data = [0; MAX_LENGTH];
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(Self { id, data, length: bytes.len() })
    }

    /// The bytes.
    pub fn data(&self) -> &[u8] {
        &self.data[..self.length]
    }
}

/// A frame of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogFrame<'a> {
    /// When it came, seconds of the log's clock.
    pub t_s: f64,
    /// The interface on which it came, such as `can0`.
    pub interface: &'a str,
    /// The frame.
    pub frame: CanFrame,
}
