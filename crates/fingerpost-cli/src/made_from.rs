//! What a run was made from, as its report says it.

use std::ffi::OsString;
use std::path::Path;

use fingerpost_io::without_credentials;

/// The command line as a shell takes it, without the folder that is written: the page lies in it, and its name changes no result.
pub(crate) fn command_line(arguments: impl IntoIterator<Item = OsString>) -> String {
    let mut words = vec!["fingerpost".to_owned()];
    let mut arguments = arguments.into_iter().skip(1);
    while let Some(argument) = arguments.next() {
        let word = argument.to_string_lossy();
        if word == "--out" {
            arguments.next();
        } else if !word.starts_with("--out=") {
            words.push(quoted(&without_credentials(&word)));
        }
    }
    words.join(" ")
}

/// A message about a command line without the credentials of its addresses. A shell splits an address at its spaces, and a message may
/// quote a piece that shows no address any more.
pub(crate) fn without_credentials_of(arguments: impl IntoIterator<Item = OsString>, message: &str) -> String {
    let arguments: Vec<_> =
        arguments.into_iter().map(|argument| argument.to_string_lossy().into_owned()).collect();
    let line = arguments.join(" ");
    let shown_line = without_credentials(&line);
    line.split(' ').map(without_credentials).fold(without_credentials(message), |message, word| {
        let is_shown = shown_line.split(' ').any(|shown| shown == word);
        if is_shown { message } else { message.replace(&format!("'{word}'"), "'hidden'") }
    })
}

/// A word that a shell takes as it is.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// A file and what it holds.
pub(crate) fn file(path: &Path, facts: &str) -> String {
    format!("{}: {facts}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_can_be_given_to_a_shell_and_names_no_output() {
        let line = |words: &[&str]| command_line(words.iter().map(OsString::from));
        assert_eq!(
            line(&["/usr/bin/fingerpost", "run", "a b.mp4", "--out", "run"]),
            "fingerpost run 'a b.mp4'"
        );
        assert_eq!(
            line(&["fp", "run", "--out=x", "it's", "", "$HOME"]),
            "fingerpost run 'it'\\''s' '' '$HOME'"
        );
        let camera = line(&["fp", "run", "rtsp://me:p@ss@10.0.0.4:554/a@b", "--map=m@p.osm"]);
        assert_eq!(camera, "fingerpost run rtsp://10.0.0.4:554/a@b --map=m@p.osm");
        let whole = line(&["fp", "run", "rtsp://me:p/ss@camera/1?key=1"]);
        assert_eq!(whole, "fingerpost run 'rtsp://camera/1?key=hidden'");
        let same = |out: &str| line(&["fp", "run", "drive", "--out", out, "--start-m", "-5"]);
        assert_eq!(same("a"), same("another"));
        assert_eq!(same("a"), "fingerpost run drive --start-m -5");
    }

    #[test]
    fn a_piece_of_an_address_is_quoted_in_no_message() {
        let words = ["fp", "run", "rtsp://me:a/", "b", "c@camera/1", "d.mp4"];
        for (word, shown) in [
            ("b", "hidden"),
            ("c@camera/1", "hidden"),
            ("rtsp://me:a/", "hidden"),
            ("d.mp4", "d.mp4"),
            ("run", "run"),
            ("rtsp://me:x@camera/1", "rtsp://camera/1"),
        ] {
            let said =
                without_credentials_of(words.map(OsString::from), &format!("unexpected '{word}' found"));
            assert_eq!(said, format!("unexpected '{shown}' found"));
        }
    }
}
