//! Texts as they may be shown: maps and file names are written by anybody.

/// Characters of a name that are kept: the longest street name of OpenStreetMap has about a hundred.
const MOST_CHARACTERS: usize = 200;
/// What stands in place of what was cut off.
pub(crate) const ELLIPSIS: char = '…';

/// A name on one line, without characters that steer a terminal or the direction of writing; cut where it is longer than 200
/// characters, with an ellipsis. White space of any kind is one space; none is left at the ends.
pub(crate) fn cleaned(name: &str) -> String {
    let spaced: String = name.chars().map(|c| if c.is_whitespace() { ' ' } else { c }).collect();
    let words = spaced.split(' ').map(|word| word.chars().filter(|c| !is_unseen(*c)).collect::<String>());
    let words: Vec<String> = words.filter(|word| !word.is_empty()).collect();
    let line = words.join(" ");
    match line.char_indices().nth(MOST_CHARACTERS) {
        Some(_) => {
            let cut: String = line.chars().take(MOST_CHARACTERS - 1).collect();
            format!("{}{ELLIPSIS}", cut.trim_end())
        }
        None => line,
    }
}

/// A text on one line, for a terminal: what would break the line, steer the terminal, turn the direction of writing or hide in it is
/// written as its code, so that it can be told from what it was. Tabs stay.
///
/// ```
/// assert_eq!(fingerpost_map::escaped("a\u{1b}[2J\nb"), "a\\u{1b}[2J\\u{a}b");
/// ```
pub fn escaped(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_unseen(c) && c != '\t' {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Whether a character shows nothing of itself: control characters (Unicode's category Cc), marks of direction, separators of lines and
/// paragraphs, joiners and fillers without width, annotations, and tags. The joiners U+200C and U+200D are letters' forms in Persian and
/// Indian names.
fn is_unseen(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180b}'..='\u{180f}'
            | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{3164}'
            | '\u{feff}' | '\u{ffa0}' | '\u{fff0}'..='\u{fffb}' | '\u{1d173}'..='\u{1d17a}' | '\u{e0000}'..='\u{e0fff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_control_character_is_left_wherever_it_stands() {
        let steering = (0..=char::MAX as u32).filter_map(char::from_u32).filter(|c| c.is_control());
        let directions = ['\u{202e}', '\u{2066}', '\u{200f}', '\u{feff}', '\u{61c}', '\u{2028}', '\u{85}'];
        for c in steering.chain(directions) {
            for name in [format!("{c}Main Street"), format!("Main {c} Street"), format!("Main Street{c}")] {
                assert_eq!(cleaned(&name), "Main Street", "U+{:04X}", c as u32);
            }
        }
        assert_eq!(cleaned("Main\u{1b}[31mStreet\r\n"), "Main[31mStreet");
    }

    #[test]
    fn a_name_that_was_cleaned_stays_wherever_it_was_cut() {
        for first in 1..300 {
            let once = cleaned(&format!("{} {}", "a".repeat(first), "b c ".repeat(60)));
            assert_eq!(cleaned(&once), once);
        }
    }

    #[test]
    fn names_of_all_scripts_stay() {
        let joined = "خیابان می\u{200c}خواهم";
        for name in
            ["Straße des 17. Juni", "東京都道", "Οδός Ερμού", "ул. Ленина", "شارع", "A 8 / E 52", joined]
        {
            assert_eq!((cleaned(name), escaped(name)), (name.to_owned(), name.to_owned()));
        }
        assert_eq!(cleaned(" a\t b  c "), "a b c");
    }

    #[test]
    fn what_is_cut_off_leaves_an_ellipsis() {
        for (name, expected) in [
            ("ö".repeat(200), "ö".repeat(200)),
            ("ö".repeat(201), format!("{}…", "ö".repeat(199))),
            ("ab ".repeat(200), format!("{}a…", "ab ".repeat(66))),
            (format!("{} b", "a".repeat(199)), format!("{}…", "a".repeat(199))),
        ] {
            assert_eq!(cleaned(&name), expected);
        }
    }

    #[test]
    fn both_ways_of_showing_agree_on_what_shows_nothing() {
        for c in (0..=char::MAX as u32).filter_map(char::from_u32) {
            let line = escaped(&format!("a{c}b"));
            assert!(line.chars().all(|c| !is_unseen(c) || c == '\t'), "U+{:04X}", c as u32);
            assert!(!line.contains('\n') && cleaned(&format!("a{c}b")).chars().all(|c| !is_unseen(c)));
            // What is replaced can be told from what it was, and all else stays.
            let is_replaced = is_unseen(c) && c != '\t';
            let expected = if is_replaced { format!("a\\u{{{:x}}}b", c as u32) } else { format!("a{c}b") };
            assert_eq!(line, expected);
        }
        for c in [
            '\u{2028}',
            '\u{2029}',
            '\u{feff}',
            '\u{e0001}',
            '\u{200b}',
            '\u{202e}',
            '\u{9b}',
            '\u{7f}',
            '\n',
            '\r',
        ] {
            assert!(escaped(&c.to_string()).is_ascii(), "U+{:04X}", c as u32);
        }
        assert_eq!(
            escaped("user\u{202e}gpj.exe\nfingerpost: done"),
            "user\\u{202e}gpj.exe\\u{a}fingerpost: done"
        );
    }
}
