//! Names as they may be shown: maps are written by anybody.

/// Characters of a name that are kept: the longest street name of OpenStreetMap has about a hundred.
const MOST_CHARACTERS: usize = 200;

/// A name on one line, without characters that steer a terminal or the direction of writing; cut where it is longer than 200
/// characters. White space of any kind is one space; none is left at the ends.
pub(crate) fn cleaned(name: &str) -> String {
    let spaced: String = name.chars().map(|c| if c.is_whitespace() { ' ' } else { c }).collect();
    let words = spaced.split(' ').map(|word| word.chars().filter(|c| !is_steering(*c)).collect::<String>());
    let words: Vec<String> = words.filter(|word| !word.is_empty()).collect();
    let cut: String = words.join(" ").chars().take(MOST_CHARACTERS).collect();
    cut.trim_end().to_owned()
}

/// Control characters (Unicode's category Cc), the marks, embeddings, overrides and isolates of writing directions, and the
/// tags and marks that nothing is drawn of.
fn is_steering(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
        || matches!(c, '\u{61c}' | '\u{e0000}'..='\u{e007f}')
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
        for name in ["Straße des 17. Juni", "東京都道", "Οδός Ερμού", "ул. Ленина", "شارع", "A 8 / E 52"]
        {
            assert_eq!(cleaned(name), name);
        }
        assert_eq!(cleaned(" a\t b  c "), "a b c");
        assert_eq!(cleaned(&"ab ".repeat(200)).chars().count(), 200);
    }
}
