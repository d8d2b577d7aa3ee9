//! The Common Data Representation that ROS 2 messages are stored in.
//!
//! Source: OMG, "Common Object Request Broker Architecture", 9.3 (CDR transfer syntax); the two bytes before the payload are
//! those of RTPS 2.2, 10.5. Numbers lie at multiples of their own size, counted from behind the four bytes of the head.

use thiserror::Error;

/// A message that is no CDR of its type.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CdrError {
    /// It ends early, or a length in it is beyond its end.
    #[error("it has {length} bytes, and {wanted} more are wanted at byte {at}")]
    Short {
        /// Bytes of the message.
        length: usize,
        /// Where they are wanted.
        at: usize,
        /// How many are wanted.
        wanted: usize,
    },
    /// It is encoded in another manner.
    #[error(
        "its first bytes {head:02x?} are not those of plain CDR (00 00 or 00 01); convert the bag with `ros2 bag convert`, uncompressed"
    )]
    Representation {
        /// The two bytes.
        head: [u8; 2],
    },
    /// A text is not UTF-8.
    #[error("the text at byte {at} is not UTF-8")]
    Text {
        /// Where it begins.
        at: usize,
    },
}

/// Bytes before the payload: the representation, and options that plain CDR does not have.
const HEAD_BYTES: usize = 4;

/// Reads a message from its start.
#[derive(Debug, Clone)]
pub(crate) struct Cdr<'a> {
    payload: &'a [u8],
    at: usize,
    little_endian: bool,
}

impl<'a> Cdr<'a> {
    /// Begins behind a message's head.
    pub(crate) fn new(message: &'a [u8]) -> Result<Self, CdrError> {
        let short = CdrError::Short { length: message.len(), at: 0, wanted: HEAD_BYTES };
        let (head, payload) = message.split_at_checked(HEAD_BYTES).ok_or(short)?;
        let little_endian = match head {
            [0, 0, ..] => false,
            [0, 1, ..] => true,
            [a, b, ..] => return Err(CdrError::Representation { head: [*a, *b] }),
            _ => return Err(CdrError::Representation { head: [0, 0] }),
        };
        Ok(Self { payload, at: 0, little_endian })
    }

    fn bytes(&mut self, count: usize) -> Result<&'a [u8], CdrError> {
        let rest = self.payload.get(self.at..).unwrap_or_default();
        let taken = rest.get(..count).ok_or(CdrError::Short {
            length: self.payload.len() + HEAD_BYTES,
            at: self.at + HEAD_BYTES,
            wanted: count,
        })?;
        self.at += count;
        Ok(taken)
    }

    /// A number's bytes, lowest first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        self.at = self.at.next_multiple_of(N);
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.bytes(N)?);
        if !self.little_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, CdrError> {
        Ok(u8::from_le_bytes(self.number()?))
    }

    pub(crate) fn i8(&mut self) -> Result<i8, CdrError> {
        Ok(i8::from_le_bytes(self.number()?))
    }

    pub(crate) fn u16(&mut self) -> Result<u16, CdrError> {
        Ok(u16::from_le_bytes(self.number()?))
    }

    pub(crate) fn u32(&mut self) -> Result<u32, CdrError> {
        Ok(u32::from_le_bytes(self.number()?))
    }

    pub(crate) fn i32(&mut self) -> Result<i32, CdrError> {
        Ok(i32::from_le_bytes(self.number()?))
    }

    pub(crate) fn f64(&mut self) -> Result<f64, CdrError> {
        Ok(f64::from_le_bytes(self.number()?))
    }

    /// So many numbers, as of a fixed array.
    pub(crate) fn array<const N: usize>(&mut self) -> Result<[f64; N], CdrError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    fn length(&mut self) -> Result<usize, CdrError> {
        Ok(self.u32()? as usize)
    }

    /// As many numbers as stands before them.
    pub(crate) fn numbers(&mut self) -> Result<Vec<f64>, CdrError> {
        let count = self.length()?;
        let left = self.payload.len().saturating_sub(self.at);
        if count > left / size_of::<f64>() {
            let length = self.payload.len() + HEAD_BYTES;
            let wanted = count.saturating_mul(size_of::<f64>());
            return Err(CdrError::Short { length, at: self.at + HEAD_BYTES, wanted });
        }
        (0..count).map(|_| self.f64()).collect()
    }

    /// As many bytes as stands before them.
    pub(crate) fn blob(&mut self) -> Result<&'a [u8], CdrError> {
        let count = self.length()?;
        self.bytes(count)
    }

    /// A text, which ends in a zero byte.
    pub(crate) fn text(&mut self) -> Result<&'a str, CdrError> {
        let at = self.at + HEAD_BYTES;
        let bytes = self.blob()?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        std::str::from_utf8(text).map_err(|_| CdrError::Text { at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lie_at_multiples_of_their_size() {
        // A byte, three of padding, a 32-bit number, a text of three bytes with its zero, four of padding to 16, a double.
        let mut message = vec![0, 1, 0, 0, 7, 0, 0, 0, 1, 2, 0, 0, 4, 0, 0, 0];
        message.extend_from_slice(b"abc\0");
        message.extend_from_slice(&2.5_f64.to_le_bytes());
        let mut cdr = Cdr::new(&message).expect("a head");
        assert_eq!(cdr.u8(), Ok(7));
        assert_eq!(cdr.u32(), Ok(513));
        assert_eq!(cdr.text(), Ok("abc"));
        assert_eq!(cdr.f64(), Ok(2.5));
        assert_eq!(cdr.u8(), Err(CdrError::Short { length: 28, at: 28, wanted: 1 }));
    }

    #[test]
    fn both_orders_of_bytes_are_read_and_others_named() {
        let big = [0, 0, 0, 0, 0, 0, 2, 1];
        assert_eq!(Cdr::new(&big).and_then(|mut cdr| cdr.u32()), Ok(513));
        let parameter_list = [0, 3, 0, 0];
        assert_eq!(Cdr::new(&parameter_list).err(), Some(CdrError::Representation { head: [0, 3] }));
        assert_eq!(Cdr::new(&[0, 1]).err(), Some(CdrError::Short { length: 2, at: 0, wanted: 4 }));
    }

    #[test]
    fn lengths_beyond_the_end_ask_for_no_memory() {
        let message = [0, 1, 0, 0, 255, 255, 255, 255, 1, 2, 3, 4];
        assert!(Cdr::new(&message).and_then(|mut cdr| cdr.numbers()).is_err());
        assert!(Cdr::new(&message).and_then(|mut cdr| cdr.blob().map(<[u8]>::to_vec)).is_err());
    }
}
