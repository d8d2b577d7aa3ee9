//! Evidence is for people: no stage takes that of another, `why` alone reads it, and the pipeline hands it on unread.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, TokenTree};

use crate::modules::rows;
use crate::sources::{Source, is_punct, name_of, runs, sources};

/// Those who may name the evidence of every stage.
const MAY_NAME: [&str; 2] = ["why", "pipeline"];

/// The method's own sources, and those of the crates that stand in its table of modules; each with what owns it there.
fn of_stages() -> Vec<(String, Source)> {
    let crates = rows().into_keys().filter(|name| name.starts_with("fingerpost"));
    let of_crates =
        crates.flat_map(|name| sources(&name).into_iter().map(move |source| (name.clone(), source)));
    let of_method =
        sources("fingerpost").into_iter().filter_map(|source| Some((source.module.first()?.clone(), source)));
    of_method.chain(of_crates).collect()
}

/// Public types whose names end in "Evidence", each with the module or crate that has it.
fn evidence_types(stages: &[(String, Source)]) -> BTreeMap<String, String> {
    let mut types = BTreeMap::new();
    for (owner, source) in stages {
        for run in runs(&source.tokens) {
            for words in run.windows(3) {
                let [Some(public), Some(kind), Some(name)] = [0, 1, 2].map(|i| name_of(&words[i])) else {
                    continue;
                };
                let is_type = public == "pub" && ["struct", "enum", "type"].contains(&kind.as_str());
                if is_type && name.ends_with("Evidence") {
                    types.insert(name, owner.clone());
                }
            }
        }
    }
    types
}

#[test]
fn no_stage_names_the_evidence_of_another() {
    let (rows, stages) = (rows(), of_stages());
    let types = evidence_types(&stages);
    assert!(types.len() > 10, "{types:?}");
    let mut wrong = BTreeSet::new();
    for (module, source) in stages.iter().filter(|(module, _)| !MAY_NAME.contains(&module.as_str())) {
        let names: BTreeSet<String> = runs(&source.tokens).iter().flatten().filter_map(name_of).collect();
        for (name, owner) in types.iter().filter(|(name, owner)| names.contains(*name) && *owner != module) {
            // A crate that does a stage's work stands in its row.
            let does_its_work = owner.starts_with("fingerpost") && rows[owner] == rows[module];
            if !does_its_work {
                wrong.insert(format!("{module} names {name} of {owner}: {}", source.path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.into_iter().collect::<Vec<_>>().join("\n"));
}

#[test]
fn the_pipeline_reads_nothing_in_evidence() {
    let mut wrong = BTreeSet::new();
    for (_, source) in of_stages().iter().filter(|(module, _)| module == "pipeline") {
        for run in runs(&source.tokens) {
            for (i, words) in run.windows(3).enumerate() {
                let value = name_of(&words[0]).filter(|name| name.ends_with("evidence"));
                let field = name_of(&words[2]).filter(|_| is_punct(&words[1], '.'));
                let is_call = matches!(
                    run.get(i + 3),
                    Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis
                );
                if let (Some(value), Some(field), false) = (value, field, is_call) {
                    wrong.insert(format!("{value}.{field} in {}", source.path.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.into_iter().collect::<Vec<_>>().join("\n"));
}
