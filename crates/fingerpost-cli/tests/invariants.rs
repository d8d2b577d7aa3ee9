//! What must be absent: invariants of the whole workspace that no compiler checks.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

/// Crates whose results follow from their arguments alone.
const PURE: [&str; 15] = [
    "fingerpost",
    "fingerpost-calibration",
    "fingerpost-control",
    "fingerpost-eval",
    "fingerpost-format",
    "fingerpost-geometry",
    "fingerpost-lanes",
    "fingerpost-locate",
    "fingerpost-map",
    "fingerpost-papers",
    "fingerpost-record",
    "fingerpost-report",
    "fingerpost-search",
    "fingerpost-sim",
    "fingerpost-vision",
];

/// Modules of other crates of which the same holds.
const PURE_MODULES: [&str; 1] = ["fingerpost-io/src/bag"];

/// Modules in these crates of which that does not hold: what talks to others has sockets and clocks.
const IMPURE_MODULES: [&str; 1] = ["fingerpost-record/src/live"];

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// The sources under a folder, with their texts.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| match path.extension() {
            _ if path.is_dir() => sources(&path),
            Some(ending) if ending == "rs" => vec![(path.clone(), fs::read_to_string(&path).unwrap())],
            _ => Vec::new(),
        })
        .collect()
}

/// The sources of a module: its file, and what is in the folder beside it.
fn module_sources(module: &str) -> Vec<(PathBuf, String)> {
    let folder = crates().join(module);
    let file = folder.with_extension("rs");
    let text = fs::read_to_string(&file).unwrap();
    let mut found = sources(&folder);
    found.push((file, text));
    found
}

/// The sources of a crate without those of its impure modules.
fn pure_sources(name: &str) -> Vec<(PathBuf, String)> {
    let mut found = sources(&crates().join(name).join("src"));
    for module in IMPURE_MODULES {
        // Its file, and what is in the folder beside it.
        found.retain(|(path, _)| !path.with_extension("").starts_with(crates().join(module)));
    }
    assert!(!found.is_empty(), "{name} has sources");
    found
}

/// Names of the workspace's crates in the table `[dependencies]`.
fn dependencies(name: &str) -> Vec<String> {
    let text = fs::read_to_string(crates().join(name).join("Cargo.toml")).unwrap();
    let manifest: toml::Table = toml::from_str(&text).unwrap();
    let table = manifest["dependencies"].as_table().unwrap();
    table.keys().filter(|key| key.starts_with("fingerpost")).cloned().collect()
}

#[test]
fn pure_crates_read_no_file_clock_environment_or_global_randomness() {
    let impure = [
        "std::fs",
        "std::env",
        "std::net",
        "std::process",
        "Instant",
        "SystemTime",
        "thread_rng",
        "rand::",
        "HashMap",
        "HashSet",
        "static mut",
        "println!",
        "eprintln!",
    ];
    let of_crates = PURE.into_iter().flat_map(pure_sources);
    for (path, text) in of_crates.chain(PURE_MODULES.into_iter().flat_map(module_sources)) {
        // A module's own tests, at its end, may do as they like.
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        for word in impure {
            assert!(!code.contains(word), "{} has {word}", path.display());
        }
    }
}

#[test]
fn what_is_pure_uses_no_impure_module() {
    for module in IMPURE_MODULES {
        let (name, last) = (module.split('/').next().unwrap(), module.rsplit('/').next().unwrap());
        for (path, text) in pure_sources(name) {
            let uses = text.contains(&format!("{last}::")) || text.contains(&format!("::{last}"));
            assert!(!uses, "{} uses {module}", path.display());
        }
    }
}

#[test]
fn a_pure_module_uses_nothing_of_an_impure_crate_but_itself() {
    for module in PURE_MODULES {
        for (path, text) in module_sources(module) {
            // From its own file `super` leads out of the module, from those in its folder to the module.
            let out = if path.with_extension("").ends_with(module) { "super::" } else { "super::super" };
            for word in ["crate::", out] {
                assert!(!text.contains(word), "{} has {word}", path.display());
            }
        }
    }
}

#[test]
fn simulator_and_evaluation_do_not_know_the_method() {
    for name in ["fingerpost-sim", "fingerpost-eval"] {
        assert!(!dependencies(name).contains(&"fingerpost".to_owned()), "{name}");
    }
}

#[test]
fn the_method_does_not_know_truth_or_files() {
    for dependency in dependencies("fingerpost") {
        let known = [
            "fingerpost-control",
            "fingerpost-geometry",
            "fingerpost-lanes",
            "fingerpost-locate",
            "fingerpost-map",
            "fingerpost-vision",
        ];
        assert!(known.contains(&dependency.as_str()), "{dependency}");
    }
    for (path, text) in sources(&crates().join("fingerpost/src")) {
        assert!(!text.contains("TruthRecord"), "{}", path.display());
    }
}

#[test]
fn unsafe_code_stays_in_the_picture_kernels() {
    for entry in fs::read_dir(crates()).unwrap() {
        let path = entry.unwrap().path();
        if path.ends_with("fingerpost-vision") {
            continue;
        }
        let manifest = fs::read_to_string(path.join("Cargo.toml")).unwrap();
        assert!(manifest.contains("[lints]\nworkspace = true"), "{}", path.display());
    }
}
