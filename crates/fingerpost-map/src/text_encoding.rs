//! Texts of other encodings than UTF-8, as far as positions and times need them.

use std::borrow::Cow;

/// Marks of UTF-8 and of both orders of UTF-16 at a text's beginning (Unicode, "byte order mark").
const UTF_8_MARK: &[u8] = b"\xEF\xBB\xBF";
const LITTLE_ENDIAN_MARK: &[u8] = b"\xFF\xFE";
const BIG_ENDIAN_MARK: &[u8] = b"\xFE\xFF";

/// The text of a file in UTF-8, UTF-16 or an encoding that has ASCII within: letters of names that are not UTF-8 are replaced, which
/// numbers do not have.
pub(crate) fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    if let Some(rest) = bytes.strip_prefix(UTF_8_MARK) {
        return String::from_utf8_lossy(rest);
    }
    let (pairs, _) = bytes.as_chunks::<2>();
    let utf_16 = |unit: fn([u8; 2]) -> u16| {
        let units = pairs.iter().map(|pair| unit(*pair)).skip_while(|unit| *unit == 0xFEFF);
        Cow::Owned(
            char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).collect(),
        )
    };
    // Without a mark, a first letter of ASCII shows the order.
    match bytes {
        _ if bytes.starts_with(LITTLE_ENDIAN_MARK) => utf_16(u16::from_le_bytes),
        _ if bytes.starts_with(BIG_ENDIAN_MARK) => utf_16(u16::from_be_bytes),
        [first, 0, second, 0, ..] if first.is_ascii() && second.is_ascii() && *first > 0 => {
            utf_16(u16::from_le_bytes)
        }
        [0, first, 0, second, ..] if first.is_ascii() && second.is_ascii() && *first > 0 => {
            utf_16(u16::from_be_bytes)
        }
        _ => String::from_utf8_lossy(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "<gpx>\u{e9}\u{1f697}</gpx>";
        let units: Vec<u16> = text.encode_utf16().collect();
        for is_marked in [false, true] {
            let units = || is_marked.then_some(0xFEFF).into_iter().chain(units.iter().copied());
            let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
            let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
            assert_eq!((text_of(&little).as_ref(), text_of(&big).as_ref()), (text, text), "{is_marked}");
        }
        assert_eq!(text_of(text.as_bytes()), text);
        assert_eq!(text_of(&[UTF_8_MARK, text.as_bytes()].concat()), text);
        assert_eq!(text_of(b"<a>\xe9</a>"), "<a>\u{fffd}</a>");
        for short in [&b""[..], b"\xff", b"\xff\xfe", b"\0", b"a\0b"] {
            assert!(text_of(short).len() < 4, "{short:?}");
        }
    }
}
