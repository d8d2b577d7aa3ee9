//! Fields of protocol buffers, without copies: a message is looked through where it lies.

use protobuf::CodedInputStream;

/// What a field holds.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Value<'a> {
    /// A number in base 128, as it is written.
    Number(u64),
    /// Bytes: a text, a message or packed numbers.
    Bytes(&'a [u8]),
    /// A number of a fixed width, which no field that is read here has.
    Fixed,
}

/// The fields of a message, one after the other.
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
    stream: CodedInputStream<'a>,
}

impl<'a> Fields<'a> {
    /// Those of a message.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, stream: CodedInputStream::from_bytes(bytes) }
    }

    /// The next field's number and value; none behind the last.
    pub(crate) fn next(&mut self) -> Result<Option<(u32, Value<'a>)>, String> {
        let cause = |error: protobuf::Error| error.to_string();
        let Some(tag) = self.stream.read_raw_tag_or_eof().map_err(cause)? else { return Ok(None) };
        let value = match tag & 7 {
            0 => Value::Number(self.stream.read_raw_varint64().map_err(cause)?),
            1 => self.stream.read_fixed64().map(|_| Value::Fixed).map_err(cause)?,
            2 => {
                let length = self.stream.read_raw_varint32().map_err(cause)?;
                let rest = usize::try_from(self.stream.pos()).ok().and_then(|at| self.bytes.get(at..));
                let value = rest.and_then(|rest| rest.get(..length as usize));
                let value = value.ok_or("a field is longer than the message that it is in")?;
                self.stream.skip_raw_bytes(length).map_err(cause)?;
                Value::Bytes(value)
            }
            5 => self.stream.read_fixed32().map(|_| Value::Fixed).map_err(cause)?,
            // Groups, which the format does not have and which could be nested without end.
            other => return Err(format!("a field of kind {other}")),
        };
        Ok(Some((tag >> 3, value)))
    }
}

impl<'a> Value<'a> {
    /// The bytes of a field that has some.
    pub(crate) fn bytes(self) -> Result<&'a [u8], String> {
        match self {
            Self::Bytes(bytes) => Ok(bytes),
            _ => Err("a number stands where bytes belong".to_owned()),
        }
    }

    /// The number of a field that has one.
    pub(crate) fn number(self) -> Result<u64, String> {
        match self {
            Self::Number(number) => Ok(number),
            _ => Err("something else stands where a number belongs".to_owned()),
        }
    }
}

/// Packed numbers, read one by one.
pub(crate) struct Packed<'a> {
    stream: CodedInputStream<'a>,
}

impl<'a> Packed<'a> {
    /// The numbers of a field.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        Self { stream: CodedInputStream::from_bytes(bytes) }
    }

    /// The next number as it is written; none behind the last.
    pub(crate) fn next(&mut self) -> Result<Option<u64>, String> {
        if self.stream.eof().map_err(|error| error.to_string())? {
            return Ok(None);
        }
        self.stream.read_raw_varint64().map(Some).map_err(|error| error.to_string())
    }
}

/// Packed numbers that are differences to the one before.
pub(crate) struct Sums<'a> {
    differences: Packed<'a>,
    sum: i64,
}

impl<'a> Sums<'a> {
    /// The sums of a field's differences.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        Self { differences: Packed::of(bytes), sum: 0 }
    }

    /// The next sum; none behind the last.
    pub(crate) fn next(&mut self) -> Result<Option<i64>, String> {
        let Some(difference) = self.differences.next()? else { return Ok(None) };
        let sum = self.sum.checked_add(signed(difference)).ok_or("a sum of differences is beyond 64 bits")?;
        self.sum = sum;
        Ok(Some(sum))
    }
}

/// A number with a sign, which is written with its sign in the lowest bit.
pub(crate) const fn signed(written: u64) -> i64 {
    (written >> 1) as i64 ^ -((written & 1) as i64)
}
