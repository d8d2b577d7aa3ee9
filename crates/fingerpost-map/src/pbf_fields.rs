//! Fields of protocol buffers, without copies: a message is looked through where it lies.
//!
//! Format: Protocol Buffers' "Encoding" page. Field kinds 0 (number), 1 and 5 (of 8 and 4 bytes) and 2 (bytes) are read.

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
    rest: &'a [u8],
}

impl<'a> Fields<'a> {
    /// Those of a message.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next field's number and value; none behind the last.
    pub(crate) fn next(&mut self) -> Result<Option<(u32, Value<'a>)>, String> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let tag = u32::try_from(take_number(&mut self.rest)?).map_err(|_| "a field's number is too large")?;
        let value = match tag & 7 {
            0 => Value::Number(take_number(&mut self.rest)?),
            1 => self.take(8).map(|_| Value::Fixed)?,
            2 => {
                let length = take_number(&mut self.rest)?;
                Value::Bytes(self.take(length)?)
            }
            5 => self.take(4).map(|_| Value::Fixed)?,
            // Groups, which the format does not have and which could be nested without end.
            other => return Err(format!("a field of kind {other}")),
        };
        Ok(Some((tag >> 3, value)))
    }

    fn take(&mut self, length: u64) -> Result<&'a [u8], String> {
        let cut = usize::try_from(length).ok().and_then(|length| self.rest.split_at_checked(length));
        let (taken, rest) = cut.ok_or("a field is longer than the message that it is in")?;
        self.rest = rest;
        Ok(taken)
    }
}

/// Takes a number in base 128 off: seven bits a byte, the lowest first, each byte but the last marked by its highest bit.
fn take_number(bytes: &mut &[u8]) -> Result<u64, String> {
    let mut number = 0;
    for (shift, (at, &byte)) in (0..u64::BITS).step_by(7).zip(bytes.iter().enumerate()) {
        let bits = u64::from(byte & 0x7f);
        number |= bits << shift;
        if number >> shift != bits {
            break;
        }
        if byte < 0x80 {
            *bytes = &bytes[at + 1..];
            return Ok(number);
        }
    }
    Err("a number is cut short or has more than 64 bits".to_owned())
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
    rest: &'a [u8],
}

impl<'a> Packed<'a> {
    /// The numbers of a field.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next number as it is written; none behind the last.
    pub(crate) fn next(&mut self) -> Result<Option<u64>, String> {
        if self.rest.is_empty() { Ok(None) } else { take_number(&mut self.rest).map(Some) }
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
