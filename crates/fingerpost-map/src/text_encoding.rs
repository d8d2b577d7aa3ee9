//! Texts of other encodings than UTF-8, as far as positions and times need them.

use std::borrow::Cow;

/// Marks of UTF-8 and of both orders of UTF-16 at a text's beginning (Unicode, "byte order mark").
const UTF_8_MARK: &[u8] = b"\xEF\xBB\xBF";
const LITTLE_ENDIAN_MARK: &[u8] = b"\xFF\xFE";
const BIG_ENDIAN_MARK: &[u8] = b"\xFE\xFF";

/// A file's text.
pub(crate) struct DecodedText<'a> {
    /// In UTF-8.
    pub(crate) text: Cow<'a, str>,
    /// Letters that could not be read and are replaced.
    pub(crate) replaced: usize,
}

/// The text of a file in UTF-8, UTF-16 or an encoding that has ASCII within: letters of names that are not UTF-8 are replaced, which
/// numbers do not have.
pub(crate) fn text_of(bytes: &[u8]) -> DecodedText<'_> {
    let (pairs, _) = bytes.as_chunks::<2>();
    // Without a mark, a first letter of ASCII shows the order.
    match bytes {
        _ if bytes.starts_with(LITTLE_ENDIAN_MARK) => utf_16(pairs, u16::from_le_bytes),
        _ if bytes.starts_with(BIG_ENDIAN_MARK) => utf_16(pairs, u16::from_be_bytes),
        [first, 0, second, 0, ..] if first.is_ascii() && second.is_ascii() && *first > 0 => {
            utf_16(pairs, u16::from_le_bytes)
        }
        [0, first, 0, second, ..] if first.is_ascii() && second.is_ascii() && *first > 0 => {
            utf_16(pairs, u16::from_be_bytes)
        }
        _ => {
            let bytes = bytes.strip_prefix(UTF_8_MARK).unwrap_or(bytes);
            let replaced = bytes.utf8_chunks().filter(|chunk| !chunk.invalid().is_empty()).count();
            DecodedText { text: String::from_utf8_lossy(bytes), replaced }
        }
    }
}

fn utf_16(pairs: &[[u8; 2]], unit: fn([u8; 2]) -> u16) -> DecodedText<'static> {
    let units = pairs.iter().map(|pair| unit(*pair)).skip_while(|unit| *unit == 0xFEFF);
    let (mut text, mut replaced) = (String::new(), 0);
    for letter in char::decode_utf16(units) {
        replaced += usize::from(letter.is_err());
        text.push(letter.unwrap_or(char::REPLACEMENT_CHARACTER));
    }
    DecodedText { text: Cow::Owned(text), replaced }
}

/// The first letter of a text in any of these encodings that is no white space, where it is one of ASCII.
pub(crate) fn first_letter(bytes: &[u8]) -> Option<u8> {
    let is_before =
        |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, 0 | 0xEF | 0xBB | 0xBF | 0xFE | 0xFF);
    bytes.iter().copied().find(|byte| !is_before(byte)).filter(u8::is_ascii)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> (String, usize) {
        let DecodedText { text, replaced } = text_of(bytes);
        (text.into_owned(), replaced)
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "<gpx>\u{e9}\u{1f697}</gpx>";
        let units: Vec<u16> = text.encode_utf16().collect();
        for is_marked in [false, true] {
            let units = || is_marked.then_some(0xFEFF).into_iter().chain(units.iter().copied());
            let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
            let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
            for bytes in [little, big] {
                assert_eq!(read(&bytes), (text.to_owned(), 0), "{is_marked}");
                assert_eq!(first_letter(&bytes), Some(b'<'), "{is_marked}");
            }
        }
        for marked in [text.as_bytes(), &[UTF_8_MARK, text.as_bytes()].concat()] {
            assert_eq!((read(marked), first_letter(marked)), ((text.to_owned(), 0), Some(b'<')));
        }
        assert_eq!(read(b"<a>\xe9\xe8</a>"), ("<a>\u{fffd}\u{fffd}</a>".to_owned(), 2));
        assert_eq!(read(b"\xff\xfea\0\0\xd8b\0"), ("a\u{fffd}b".to_owned(), 1), "half of a pair");
        assert_eq!(read("<a>\u{fffd}</a>".as_bytes()).1, 0, "what the file has itself");
        for short in [&b""[..], b"\xff", b"\xff\xfe", b"\0", b"a\0b"] {
            assert!(read(short).0.len() < 4, "{short:?}");
        }
    }
}
