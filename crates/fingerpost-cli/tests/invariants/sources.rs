//! The workspace's sources as tokens, without comments and without what only tests see.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The workspace's root.
pub(crate) fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_owned()
}

/// A source file of a crate.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    /// Modules from the crate's root to the one that the file holds; empty for the root.
    pub(crate) module: Vec<String>,
    pub(crate) text: String,
    /// Its tokens but for those of tests.
    pub(crate) tokens: Vec<TokenTree>,
}

/// The sources of a crate of this name that are a part of what is built from it.
pub(crate) fn sources(name: &str) -> Vec<Source> {
    let root = workspace().join("crates").join(name).join("src");
    let mut found = BTreeMap::new();
    read(&root, &mut found);
    assert!(!found.is_empty(), "{name} has sources");
    let mut of_tests = BTreeSet::new();
    let mut sources: Vec<Source> = found
        .into_iter()
        .map(|(path, text)| {
            let module = module_of(path.strip_prefix(&root).unwrap());
            let stream: TokenStream =
                text.parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            let tokens = without_tests(stream, &module, &mut of_tests);
            Source { path, module, text, tokens }
        })
        .collect();
    sources.retain(|source| !(0..=source.module.len()).any(|end| of_tests.contains(&source.module[..end])));
    sources
}

fn read(folder: &Path, found: &mut BTreeMap<PathBuf, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            read(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            found.insert(path, text);
        }
    }
}

/// `track/belief.rs` and `track/belief/mod.rs` hold the module `track::belief`, `lib.rs` and `main.rs` the root.
fn module_of(path: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        path.with_extension("").iter().map(|name| name.to_str().unwrap().to_owned()).collect();
    names.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
    names
}

/// Tokens without the items under `#[cfg(test)]`; of modules among them that are files of their own the names are kept.
fn without_tests(
    stream: TokenStream,
    module: &[String],
    of_tests: &mut BTreeSet<Vec<String>>,
) -> Vec<TokenTree> {
    let mut kept = Vec::new();
    let mut tokens = stream.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let is_for_tests = is_punct(&token, '#')
            && tokens.peek().is_some_and(|attribute| attribute.to_string().replace(' ', "") == "[cfg(test)]");
        if !is_for_tests {
            kept.push(token);
            continue;
        }
        // The item ends with its braces or a semicolon.
        let mut item = Vec::new();
        for token in tokens.by_ref() {
            let braces = matches!(&token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
            let ends = braces || is_punct(&token, ';');
            item.push(token.to_string());
            if ends {
                break;
            }
        }
        if let [.., word, name, end] = item.as_slice()
            && word == "mod"
            && end == ";"
        {
            of_tests.insert(module.iter().chain([name]).cloned().collect());
        }
    }
    kept
}

pub(crate) fn is_punct(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == character)
}

/// The token as a name; none of other tokens.
pub(crate) fn name_of(token: &TokenTree) -> Option<String> {
    match token {
        TokenTree::Ident(name) => Some(name.to_string()),
        _ => None,
    }
}

/// All runs of tokens, one a pair of brackets, the outermost first.
pub(crate) fn runs(tokens: &[TokenTree]) -> Vec<Vec<TokenTree>> {
    let mut all = vec![tokens.to_vec()];
    for token in tokens {
        if let TokenTree::Group(group) = token {
            all.extend(runs(&group.stream().into_iter().collect::<Vec<_>>()));
        }
    }
    all
}
