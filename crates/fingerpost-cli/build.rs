//! Tells the program the commit that it is built from, as far as there is one.

use std::path::Path;
use std::process::Command;

fn main() {
    // A new commit is one line more in the log of HEAD; a checkout without that log is built anew when HEAD is another.
    for file in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", file]).filter(|path| Path::new(path).exists()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
    let commit = git(&["rev-parse", "--short=12", "HEAD"]);
    let commit = commit.map(|commit| format!(" (commit {commit})")).unwrap_or_default();
    println!("cargo::rustc-env=FINGERPOST_COMMIT={commit}");
}

/// What git answers about the folder of this crate; none without git, outside of a checkout, and in a package that was
/// unpacked inside of somebody else's.
fn git(arguments: &[&str]) -> Option<String> {
    let own = Command::new("git").args(["ls-files", "--error-unmatch", "build.rs"]).output().ok()?;
    let output = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    (own.status.success() && output.status.success()).then(|| said.trim().to_owned())
}
