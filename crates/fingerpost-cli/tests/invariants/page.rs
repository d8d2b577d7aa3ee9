//! ARCHITECTURE.md: its tables and its list of what must not happen.

use std::fs;

use crate::sources::workspace;

fn page() -> String {
    fs::read_to_string(workspace().join("ARCHITECTURE.md")).unwrap()
}

/// The rows of the first table of a section, each as its cells.
pub(crate) fn table(section: &str) -> Vec<Vec<String>> {
    let page = page();
    let heading = format!("## {section}");
    let of_section =
        page.lines().skip_while(|line| *line != heading).skip(1).take_while(|line| !line.starts_with("## "));
    // Beneath the head and its rule.
    let rows: Vec<Vec<String>> =
        of_section.skip_while(|line| cells(line).is_none()).skip(2).map_while(cells).collect();
    assert!(!rows.is_empty(), "ARCHITECTURE.md has no table under \"{heading}\"");
    rows
}

fn cells(line: &str) -> Option<Vec<String>> {
    let row = line.strip_prefix('|')?.strip_suffix('|')?;
    Some(row.split('|').map(|cell| cell.trim().to_owned()).collect())
}

/// What stands in backticks, in its order.
pub(crate) fn names(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The point of a list that begins with these words, in one line.
pub(crate) fn point(begins: &str) -> String {
    let page = page();
    let begins = format!("- {begins}");
    let mut lines = page.lines().skip_while(|line| !line.starts_with(&begins));
    let first = lines.next().unwrap_or_else(|| panic!("ARCHITECTURE.md has no point \"{begins}\""));
    let rest = lines.map_while(|line| line.strip_prefix("  "));
    [first].into_iter().chain(rest).collect::<Vec<_>>().join(" ")
}
