//! The method's modules: each knows only modules of earlier rows of ARCHITECTURE.md's table.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::TokenTree;

use crate::page;
use crate::paths::{from_root, of_crates, paths};
use crate::sources::{Source, is_punct, name_of, sources};

/// Row of each module, and of each crate whose name stands among them.
pub(crate) fn rows() -> BTreeMap<String, usize> {
    let mut rows = BTreeMap::new();
    for (row, cells) in page::table("The method's modules").iter().enumerate() {
        for name in page::names(&cells[0]) {
            assert_eq!(rows.insert(name.clone(), row), None, "{name} stands in two rows");
        }
    }
    rows
}

/// A crate that stands in a row for its controllers, and has what all rows may know: the vehicle's measures and its state.
const KNOWN_TO_ALL: &str = "fingerpost-control";

/// What the root gives out under names of its own, each with the module or crate that has it.
fn given_out(root: &Source, modules: &BTreeSet<String>) -> BTreeMap<String, String> {
    let mut given = BTreeMap::new();
    let mut tokens = root.tokens.iter();
    while let Some(token) = tokens.next() {
        if name_of(token).as_deref() != Some("use") {
            continue;
        }
        let tree: Vec<TokenTree> =
            tokens.by_ref().take_while(|token| !is_punct(token, ';')).cloned().collect();
        // An alias stands in place of the name that it is for, also of a whole crate's.
        let Some(first) = tree.iter().find_map(name_of) else { continue };
        let owner = if modules.contains(&first) { first } else { first.replace('_', "-") };
        given.extend(paths(&tree).into_iter().filter_map(|mut path| Some((path.pop()?, owner.clone()))));
    }
    given
}

#[test]
fn a_module_of_the_method_knows_only_modules_of_earlier_rows() {
    let (rows, sources) = (rows(), sources("fingerpost"));
    let modules: BTreeSet<String> =
        sources.iter().filter_map(|source| source.module.first().cloned()).collect();
    let root = sources.iter().find(|source| source.module.is_empty()).unwrap();
    let given_out = given_out(root, &modules);
    // A crate that stands in no row is beneath them all; one that does a stage's work is known to its row.
    let is_later = |known: &str, module: &str| match rows.get(known).filter(|_| known != KNOWN_TO_ALL) {
        Some(row) if modules.contains(known) => *row >= rows[module],
        Some(row) => *row > rows[module],
        None => false,
    };
    let mut wrong = BTreeSet::new();
    for source in &sources {
        let Some(module) = source.module.first() else { continue };
        for path in from_root(source) {
            let Some(first) = path.first() else { continue };
            let of_root = given_out.get(first);
            let known = if modules.contains(first) { first } else { of_root.unwrap_or(first) };
            if known == module {
                continue;
            }
            assert!(
                modules.contains(known) || of_root.is_some(),
                "{}: crate::{} is no module",
                source.path.display(),
                path.join("::")
            );
            if is_later(known, module) {
                wrong.insert(format!(
                    "{module} knows {known}: {} in {}",
                    path.join("::"),
                    source.path.display()
                ));
            }
        }
        for name in of_crates(source).into_iter().filter(|name| is_later(name, module)) {
            wrong.insert(format!("{module} knows {name}: {}", source.path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.into_iter().collect::<Vec<_>>().join("\n"));
}

#[test]
fn the_table_of_modules_has_them_all_and_no_others() {
    let listed: BTreeSet<String> =
        rows().into_keys().filter(|name| !name.starts_with("fingerpost")).collect();
    let there: BTreeSet<String> =
        sources("fingerpost").into_iter().filter_map(|source| source.module.into_iter().next()).collect();
    assert_eq!(listed, there);
}
