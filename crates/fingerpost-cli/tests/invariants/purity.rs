//! What crates may not touch.

use std::fs;

use crate::crates::{beneath, crates};
use crate::page;
use crate::paths::from_root;
use crate::sources::{Source, sources, workspace};

/// Which sources meet the world outside, by the page: crates and modules that do, and modules of those crates that do not.
struct Outside {
    met_by: Vec<String>,
    but_for: Vec<String>,
}

impl Outside {
    fn by_page() -> Self {
        let point = page::point("The world outside is met by");
        let (met_by, but_for) = point.split_once(" alone").unwrap();
        Self { met_by: page::names(met_by), but_for: page::names(but_for) }
    }

    /// Whether a module, as `crate/src/module`, or all of a crate, meets nothing of it.
    fn is_pure(&self, place: &str) -> bool {
        let holds = |whole: &String| place == whole || place.starts_with(&format!("{whole}/"));
        !self.met_by.iter().any(holds) || self.but_for.iter().any(holds)
    }

    /// The sources that follow from their arguments alone, each with its place.
    fn pure_sources(&self) -> Vec<(String, Source)> {
        let all = crates();
        for place in self.met_by.iter().chain(&self.but_for) {
            assert!(all.contains_key(place.split('/').next().unwrap()), "{place} is in no crate");
        }
        let placed = all.keys().flat_map(|name| {
            sources(name)
                .into_iter()
                .map(move |source| (format!("{name}/src/{}", source.module.join("/")), source))
        });
        placed.filter(|(place, _)| self.is_pure(place)).collect()
    }
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
    for (_, source) in Outside::by_page().pure_sources() {
        // A module's own tests, at its end, may do as they like.
        let code = source.text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        for word in impure {
            assert!(!code.contains(word), "{} has {word}", source.path.display());
        }
    }
}

#[test]
fn what_is_pure_uses_nothing_impure_of_its_own_crate() {
    let outside = Outside::by_page();
    let modules = outside.met_by.iter().filter_map(|place| place.split_once("/src/"));
    let modules: Vec<(&str, &str)> = modules.collect();
    for (place, source) in outside.pure_sources() {
        let name = place.split('/').next().unwrap();
        for first in from_root(&source).iter().filter_map(|path| path.first()) {
            let used = format!("{name}/src/{first}");
            assert!(outside.is_pure(&used), "{} uses {used}", source.path.display());
        }
        // By a path that begins beside it, too.
        for (_, module) in modules.iter().filter(|(of, _)| *of == name) {
            let uses =
                source.text.contains(&format!("{module}::")) || source.text.contains(&format!("::{module}"));
            assert!(!uses, "{} uses {module}", source.path.display());
        }
    }
}

#[test]
fn simulator_and_evaluation_do_not_know_the_method() {
    for name in ["fingerpost-sim", "fingerpost-eval"] {
        assert!(!beneath(name).contains("fingerpost"), "{name}");
    }
}

#[test]
fn the_method_does_not_know_truth_or_files() {
    let (beneath, outside) = (beneath("fingerpost"), Outside::by_page());
    for name in ["fingerpost-sim", "fingerpost-eval"] {
        assert!(!beneath.contains(name), "{name}");
    }
    for name in beneath {
        assert!(outside.is_pure(&name), "{name}");
    }
    for source in sources("fingerpost") {
        assert!(!source.text.contains("TruthRecord"), "{}", source.path.display());
    }
}

#[test]
fn unsafe_code_stays_in_the_picture_kernels() {
    for name in crates().keys().filter(|name| *name != "fingerpost-vision") {
        let path = workspace().join("crates").join(name).join("Cargo.toml");
        let manifest = fs::read_to_string(&path).unwrap();
        assert!(manifest.contains("[lints]\nworkspace = true"), "{}", path.display());
    }
}
