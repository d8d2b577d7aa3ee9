//! Every parser on changed files: a second each in the suite, and as long as FINGERPOST_FUZZ_SECONDS says.
//!
//! `FINGERPOST_FUZZ_PARSER` names one parser for a longer run, `FINGERPOST_FUZZ_SEED` another seed. An input that breaks
//! something is written to the folder for temporary files, and its path is said.

// Functions shared by tests fail their test by panicking, and how many inputs ran is said where output is shown.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use fingerpost_fuzz::{Mutator, PARSERS, Parser};

/// Inputs of each parser in the suite.
const INPUTS: u64 = 3000;
/// Memory that an input of at most 64 kB may take, bytes: a picture of so many bytes can be 33 million pixels.
const MOST_BYTES: u64 = 600_000_000;
/// The same where the input is no picture.
const MOST_TEXT_BYTES: u64 = 200_000_000;
/// How long an input may take; a quarter of this is seen on a loaded machine.
const MOST_TIME: Duration = Duration::from_secs(20);

fn setting<T: std::str::FromStr>(name: &str) -> Option<T> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name} = {text}")))
}

/// Runs a parser on inputs until there are `inputs`, or until the time is up where one is given, and says how many they were and how many
/// of them were accepted.
fn fuzz(parser: &Parser, inputs: u64, time: Option<Duration>) -> (u64, u64) {
    let seeds = (parser.seeds)();
    for (number, seed) in seeds.iter().enumerate() {
        assert!((parser.body)(seed), "{}: seed {number} is refused", parser.name);
    }
    let mut mutator = Mutator::new(setting("FINGERPOST_FUZZ_SEED").unwrap_or(7));
    let most = if parser.name == "picture" { MOST_BYTES } else { MOST_TEXT_BYTES };
    let began = Instant::now();
    let (mut count, mut accepted) = (0, 0);
    while time.map_or(count < inputs, |time| began.elapsed() < time) {
        let input = mutator.input(&seeds);
        let started = Instant::now();
        let mut read = Ok(false);
        let taken = allocation_counter::measure(|| {
            read = catch_unwind(AssertUnwindSafe(|| (parser.body)(&input)));
        });
        let failed = read.is_err();
        if failed || taken.bytes_max > most || started.elapsed() > MOST_TIME {
            let path = std::env::temp_dir().join(format!("fingerpost-fuzz-{}-{count}", parser.name));
            std::fs::write(&path, &input).unwrap();
            panic!(
                "{}: input {count} ({}): panic {failed}, {} bytes, {:?}",
                parser.name,
                path.display(),
                taken.bytes_max,
                started.elapsed()
            );
        }
        count += 1;
        accepted += u64::from(read.unwrap_or(false));
    }
    (count, accepted)
}

#[test]
fn no_changed_file_breaks_a_parser() {
    let only: Option<String> = setting("FINGERPOST_FUZZ_PARSER");
    let time = setting("FINGERPOST_FUZZ_SECONDS").map(Duration::from_secs);
    let mut ran = 0;
    for parser in PARSERS.iter().filter(|parser| only.as_deref().is_none_or(|only| only == parser.name)) {
        let began = Instant::now();
        let (inputs, accepted) = fuzz(parser, INPUTS, time);
        println!("{}: {inputs} inputs, {accepted} accepted, in {:.0?}", parser.name, began.elapsed());
        ran += 1;
    }
    assert!(ran > 0, "there is no parser {only:?}");
}

#[test]
fn every_parser_has_a_target_and_seeds_that_it_reads_twice_the_same() {
    let targets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let manifest = std::fs::read_to_string(targets.join("Cargo.toml")).unwrap();
    for parser in PARSERS {
        let target =
            std::fs::read_to_string(targets.join(format!("fuzz_targets/{}.rs", parser.name))).unwrap();
        assert!(target.contains(&format!("run(\"{}\"", parser.name)), "{}", parser.name);
        assert!(manifest.contains(&format!("name = \"{}\"", parser.name)), "{}", parser.name);
        let seeds = (parser.seeds)();
        assert!(seeds.iter().all(|seed| !seed.is_empty()) && !seeds.is_empty(), "{}", parser.name);
        let [mut a, mut b] = [Mutator::new(1), Mutator::new(1)];
        assert!((0..50).all(|_| a.input(&seeds) == b.input(&seeds)), "{}", parser.name);
    }
}

/// The public functions of a source that make a value of a text or of bytes or refuse it.
fn parsers_of(source: &str) -> impl Iterator<Item = &str> {
    let functions = source.split("\npub fn ").skip(1);
    functions.filter_map(|function| {
        let (signature, _) = function.split_once(" {\n")?;
        let (name, parameters) = signature.split_once('(')?;
        let reads = ["text: &str", "bytes: &[u8]", "line: &str"];
        let is_parser = reads.iter().any(|read| parameters.trim_start().starts_with(read));
        (is_parser && signature.contains("-> Result<")).then(|| name.split('<').next().unwrap_or(name))
    })
}

fn sources(folder: &std::path::Path) -> Vec<String> {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths
        .flat_map(|path| match path.extension() {
            _ if path.is_dir() => sources(&path),
            Some(ending) if ending == "rs" => vec![std::fs::read_to_string(&path).unwrap()],
            _ => Vec::new(),
        })
        .collect()
}

#[test]
fn every_public_parser_of_the_workspace_has_a_body() {
    let crates = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let bodies = sources(&crates.join("fingerpost-fuzz/src")).concat();
    let folders = std::fs::read_dir(&crates).unwrap().map(|entry| entry.unwrap().path());
    let others = folders.filter(|folder| folder.is_dir() && !folder.ends_with("fingerpost-fuzz"));
    let mut found = 0;
    for source in others.flat_map(|folder| sources(&folder.join("src"))) {
        for name in parsers_of(&source) {
            // With a bound given it is the same parser.
            let parser = name.trim_end_matches("_within");
            assert!(bodies.contains(parser), "{name} has no body in crates/fingerpost-fuzz/src");
            found += 1;
        }
    }
    assert!(found > 15, "{found} parsers are found");
}
