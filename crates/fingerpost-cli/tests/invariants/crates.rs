//! The crates: each depends on what ARCHITECTURE.md's table says, and on nothing else of the workspace.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

use crate::page;
use crate::sources::workspace;

/// Words between the crates' names in the table's last column.
const BETWEEN: [&str; 5] = ["none", "all", "but", "with", "also"];

/// The workspace's crates, each with those of them that it is built from, features and other platforms included.
pub(crate) fn crates() -> BTreeMap<String, BTreeSet<String>> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(workspace())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let packages = metadata["packages"].as_array().unwrap();
    packages
        .iter()
        .map(|package| {
            let dependencies = package["dependencies"].as_array().unwrap().iter();
            let of_workspace = dependencies.filter(|of| of["path"].is_string() && of["kind"] != "dev");
            (text(&package["name"]), of_workspace.map(|of| text(&of["name"])).collect())
        })
        .collect()
}

/// A crate's name as the table's last column has it.
fn short(name: &str) -> &str {
    name.strip_prefix("fingerpost-").unwrap_or(name)
}

/// The crates that a cell of the table's last column names.
fn named(cell: &str, crates: &BTreeSet<String>, of: &str) -> BTreeSet<String> {
    // Names of features stand in backticks.
    let plain: String = cell.split('`').step_by(2).collect();
    let words: Vec<&str> =
        plain.split(|character: char| ",; ".contains(character)).filter(|word| !word.is_empty()).collect();
    let mut names = BTreeSet::new();
    for word in &words {
        match crates.iter().find(|name| short(name) == *word) {
            Some(name) => _ = names.insert(name.clone()),
            None => assert!(BETWEEN.contains(word), "{of} depends on \"{word}\", which is no crate"),
        }
    }
    assert!(!words.is_empty(), "{of} has an empty cell");
    if words[0] == "all" {
        names.insert(of.to_owned());
        return crates.difference(&names).cloned().collect();
    }
    names
}

/// The table: each crate with what it depends on.
fn table() -> BTreeMap<String, BTreeSet<String>> {
    let rows = page::table("Crates");
    let names: Vec<String> = rows.iter().map(|row| page::names(&row[0]).concat()).collect();
    let all: BTreeSet<String> = names.iter().cloned().collect();
    assert_eq!(all.len(), names.len(), "a crate stands in two rows");
    names.into_iter().zip(&rows).map(|(name, row)| (name.clone(), named(&row[2], &all, &name))).collect()
}

#[test]
fn crates_depend_on_what_the_table_says_and_on_nothing_else() {
    let (table, crates) = (table(), crates());
    assert_eq!(table.keys().collect::<Vec<_>>(), crates.keys().collect::<Vec<_>>(), "rows and crates");
    let mut wrong = Vec::new();
    for (name, there) in &crates {
        let listed = &table[name];
        wrong.extend(
            there.difference(listed).map(|other| format!("{name} depends on {other} against the table")),
        );
        wrong.extend(
            listed
                .difference(there)
                .map(|other| format!("{name} does not depend on {other}, which its row has")),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What a crate depends on, and what that depends on.
pub(crate) fn beneath(name: &str) -> BTreeSet<String> {
    let crates = crates();
    let (mut all, mut new) = (BTreeSet::new(), vec![name.to_owned()]);
    while let Some(next) = new.pop() {
        new.extend(crates[&next].iter().filter(|name| all.insert((*name).clone())).cloned());
    }
    all
}
