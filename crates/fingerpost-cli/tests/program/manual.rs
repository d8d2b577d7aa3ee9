//! What shells complete, and pages of the manual.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use tempfile::TempDir;

use crate::program::call_line;

/// What bash offers where `line` ends, with the completions loaded as bash loads them.
fn offered(completions: &str, line: &str) -> BTreeSet<String> {
    let words: Vec<&str> = line.split(' ').collect();
    let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    let (current, before) = (words[words.len() - 1], words[words.len() - 2]);
    let script = format!(
        "{completions}\nCOMP_WORDS=({}); COMP_CWORD={}; _fingerpost fingerpost '{current}' '{before}'; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        quoted.join(" "),
        words.len() - 1
    );
    let output = Command::new("bash").args(["--norc", "--noprofile", "-c", &script]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_options_and_values() {
    let completions = call_line("completions bash").done().stdout;
    let all = offered(&completions, "fingerpost ");
    for command in ["demo", "run", "calibrate", "completions", "man"] {
        assert!(all.contains(command), "{command}: {all:?}");
    }
    assert_eq!(offered(&completions, "fingerpost calibrate ch"), BTreeSet::from(["chessboard".to_owned()]));
    assert_eq!(offered(&completions, "fingerpost route --fr"), BTreeSet::from(["--from".to_owned()]));
    let sides = offered(&completions, "fingerpost simulate --traffic ");
    assert_eq!(sides, ["left", "right", "centre"].map(str::to_owned).into());
}

#[test]
fn every_shell_gets_completions() {
    for (shell, begins) in [
        ("bash", "_fingerpost() {"),
        ("zsh", "#compdef fingerpost"),
        ("fish", "# Print an optspec"),
        ("elvish", "\nuse builtin;"),
        ("powershell", "\nusing namespace"),
    ] {
        let text = call_line(&format!("completions {shell}")).done().stdout;
        assert!(text.starts_with(begins) && text.contains("chessboard"), "{shell}: {}", &text[..200]);
        assert!(!text.contains("tether"), "{shell}: what is hidden is not offered");
    }
    call_line("completions tcsh").refused(2, &["tcsh", "zsh"]);
}

#[test]
fn every_command_has_a_page_with_its_examples_and_options() {
    let folder = TempDir::new().unwrap();
    call_line(&format!("man --out {}", folder.path().join("man1").display())).done();
    let mut pages = BTreeSet::new();
    for entry in fs::read_dir(folder.path().join("man1")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let command = name.strip_suffix(".1").unwrap();
        let titled = format!(".TH {command} 1 {} Fingerpost Fingerpost", env!("CARGO_PKG_VERSION"));
        assert!(text.lines().any(|line| line == titled), "{name}: {}", &text[..200]);
        for section in ["NAME", "SYNOPSIS", "DESCRIPTION", "EXAMPLES", "OPTIONS"] {
            assert_eq!(text.matches(&format!(".SH {section}\n")).count(), 1, "{name}: {section}");
        }
        pages.insert(name);
    }
    for page in ["fingerpost.1", "fingerpost-run.1", "fingerpost-calibrate.1", "fingerpost-calibrate-mount.1"]
    {
        assert!(pages.contains(page), "{page}: {pages:?}");
    }
    let (whole, written) = (
        call_line("man").done().stdout,
        fs::read_to_string(folder.path().join("man1/fingerpost.1")).unwrap(),
    );
    assert_eq!(whole.trim_end(), written.trim_end());
    // Pages are replaced, and nothing that may be the user's is, nor any page beside it.
    let page = |name: &str| folder.path().join("man1").join(name);
    fs::write(page("fingerpost.1"), written.replacen(".SH NAME", ".SH OLD", 1)).unwrap();
    let again = format!("man --out {}", folder.path().join("man1").display());
    call_line(&again).done();
    assert_eq!(fs::read_to_string(page("fingerpost.1")).unwrap(), written);
    fs::write(page("fingerpost-run.1"), "my own notes").unwrap();
    fs::write(page("fingerpost.1"), "").unwrap();
    call_line(&again).refused(1, &["fingerpost-run.1", "no page of the manual"]);
    assert_eq!(fs::read_to_string(page("fingerpost-run.1")).unwrap(), "my own notes");
    assert_eq!(fs::read_to_string(page("fingerpost.1")).unwrap(), "");
}
