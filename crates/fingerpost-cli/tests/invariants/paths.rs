//! What a source names of its own crate.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, TokenTree};

use crate::sources::{Source, is_punct, name_of, runs};

/// The paths of a tree like `a::{b, c::d as e}`: each as its names, an alias in place of the last.
pub(crate) fn paths(tree: &[TokenTree]) -> Vec<Vec<String>> {
    let mut path = Vec::new();
    for (i, token) in tree.iter().enumerate() {
        match token {
            TokenTree::Ident(_) if tree.get(i + 1).and_then(name_of).as_deref() == Some("as") => {}
            TokenTree::Ident(name) if name != "as" => path.push(name.to_string()),
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                let inside: Vec<TokenTree> = group.stream().into_iter().collect();
                let branches = inside.split(|token| is_punct(token, ','));
                let under = |branch: Vec<String>| path.iter().cloned().chain(branch).collect();
                return branches.filter(|branch| !branch.is_empty()).flat_map(paths).map(under).collect();
            }
            TokenTree::Punct(_) | TokenTree::Ident(_) => {}
            _ => break,
        }
    }
    vec![path]
}

/// The paths in a file that begin at the crate's root, from there on: `crate::a::B`, and `super::a::B` in a module of the root.
pub(crate) fn from_root(source: &Source) -> Vec<Vec<String>> {
    let from_root = |path: Vec<String>| {
        let supers = path.iter().take_while(|name| *name == "super").count();
        let up = if path.first().is_some_and(|name| name == "crate") { 1 } else { supers };
        (up > 0 && (supers == 0 || supers >= source.module.len())).then(|| path[up..].to_vec())
    };
    all_paths(source).into_iter().filter_map(from_root).collect()
}

/// The crates of this workspace that a file names, as their manifests do.
pub(crate) fn of_crates(source: &Source) -> BTreeSet<String> {
    let firsts = all_paths(source).into_iter().filter_map(|path| path.into_iter().next());
    firsts.filter(|name| name.starts_with("fingerpost_")).map(|name| name.replace('_', "-")).collect()
}

/// Every path in a file, as it stands there.
fn all_paths(source: &Source) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for run in runs(&source.tokens) {
        let mut rest = run.as_slice();
        while !rest.is_empty() {
            let tree = tree_at(rest);
            found.extend(paths(tree));
            rest = &rest[tree.len().max(1)..];
        }
    }
    found
}

/// The tokens of a path, or a tree of paths, at the beginning of a run.
fn tree_at(run: &[TokenTree]) -> &[TokenTree] {
    let mut end = 0;
    while run.get(end).is_some_and(|token| name_of(token).is_some()) {
        end += 1;
        let goes_on = [0, 1].iter().all(|i| run.get(end + i).is_some_and(|token| is_punct(token, ':')));
        if !goes_on {
            return &run[..end];
        }
        end += 2;
    }
    let is_tree =
        matches!(run.get(end), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace);
    &run[..end + usize::from(is_tree)]
}
