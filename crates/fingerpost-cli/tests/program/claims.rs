//! `fingerpost papers`: the papers' claims measured again.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::call_line;

/// So short that hardly a claim can be decided, and everything is measured.
fn small(out: &Path, more: &str) -> String {
    format!("papers --drives 1 --seconds 0.5 --out {} {more}", out.display())
}

/// What was measured without times, by kind.
fn measured(folder: &Path) -> BTreeMap<String, Value> {
    let text = fs::read_to_string(folder.join("measured.jsonl")).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines
        .map(|mut line| {
            line["values"].as_object_mut().unwrap().retain(|name, _| !name.ends_with(".ms"));
            (line["kind"].as_str().unwrap().to_owned(), line)
        })
        .collect()
}

#[test]
fn every_claim_has_a_plot_and_a_verdict_and_a_second_call_measures_nothing_again() {
    let out = TempDir::new().unwrap();
    call_line(&small(out.path(), "--threads 2")).done();
    let lines = fs::read_to_string(out.path().join("measured.jsonl")).unwrap();
    let page = fs::read_to_string(out.path().join("papers.md")).unwrap();
    let sections: Vec<&str> = page.split("\n## ").skip(1).collect();
    assert_eq!(sections.len(), 12, "{page}");
    for section in sections {
        let verdicts = ["**Holds", "**Does not hold**", "**Cannot be told from these drives**"];
        assert!(verdicts.iter().any(|verdict| section.contains(verdict)), "{section}");
        let plots = section.split("](papers/").skip(1).map(|rest| rest.split(')').next().unwrap());
        let plots: Vec<&str> = plots.collect();
        assert!(!plots.is_empty(), "{section}");
        for plot in plots {
            let svg = fs::read_to_string(out.path().join("papers").join(plot)).unwrap();
            assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{plot}");
        }
    }
    // One drive of a kind has no interval, so that its comparisons stay open; those of all kinds together have three.
    let rows = page.lines().map(|line| line.split(" | ").collect::<Vec<_>>());
    let of_one_drive: Vec<_> = rows.filter(|row| row.len() == 6 && row[4] == "1").collect();
    assert!(!of_one_drive.is_empty(), "{page}");
    for row in of_one_drive {
        assert_eq!(row[5], "open |", "{row:?}");
    }

    fs::remove_file(out.path().join("papers.md")).unwrap();
    call_line(&small(out.path(), "--threads 1")).done();
    assert_eq!(fs::read_to_string(out.path().join("measured.jsonl")).unwrap(), lines);
    assert_eq!(fs::read_to_string(out.path().join("papers.md")).unwrap(), page);

    // A drive that is missing is measured again, to the same figures on one thread as on two.
    let before = measured(out.path());
    let kept: Vec<&str> = lines.lines().filter(|line| !line.contains("two_way")).collect();
    fs::write(out.path().join("measured.jsonl"), kept.join("\n") + "\n").unwrap();
    call_line(&small(out.path(), "--threads 1")).done();
    assert_eq!(measured(out.path()), before);
}

#[test]
fn figures_of_other_drives_are_not_mixed() {
    let out = TempDir::new().unwrap();
    call_line(&format!("papers --drives 0 --out {}", out.path().display())).refused(2, &["--drives"]);
    let line = r#"{"kind":"two_way","seed":1,"frames":9,"written_by":"another","values":{}}"#;
    fs::write(out.path().join("notes.txt"), "mine").unwrap();
    call_line(&small(out.path(), "")).refused(1, &["notes.txt"]);
    fs::remove_file(out.path().join("notes.txt")).unwrap();
    let folder = out.path().join("measured");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join(".fingerpost.json"), r#"{"version":1,"kind":"papers","written_by":"another"}"#)
        .unwrap();
    fs::write(folder.join("measured.jsonl"), line.to_owned() + "\n").unwrap();
    call_line(&small(&folder, "")).refused(1, &["another version", "measured.jsonl"]);
}
