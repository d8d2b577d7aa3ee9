//! `fingerpost licences`: under which licences the program and what is linked into it may be used.

use anyhow::Result;
use clap::Args;

use crate::examples::examples;
use crate::output;

/// `tools/notices.py` makes it of the licence files of all crates that are linked.
const NOTICES: &str = include_str!("../THIRD_PARTY_NOTICES.txt");

/// Print the licences of all that the program holds: other people's libraries and map data.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "licences",
    "licences > NOTICES.txt"
))]
pub(crate) struct LicencesArgs {}

/// Prints the notices on standard output.
pub(crate) fn licences(LicencesArgs {}: &LicencesArgs) -> Result<()> {
    output::print_text(NOTICES.trim_end())
}
