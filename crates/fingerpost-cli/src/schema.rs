//! `fingerpost schema`: what may stand in fingerpost.toml.

use anyhow::{Context, Result};
use clap::Args;
use fingerpost::Config;
use fingerpost::advice::DEFAULT_RULES;

use crate::examples::examples;
use crate::output;

/// Print the JSON Schema of fingerpost.toml: every key with its unit, range and default.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "schema",
    "schema --rules > my.fuzzy"
))]
pub(crate) struct SchemaArgs {
    /// Print the shipped rules of the fuzzy controller instead: a text to change, for advice.rules.
    #[arg(long)]
    rules: bool,
}

/// Prints the schema, or the rules, on standard output.
pub(crate) fn schema(args: &SchemaArgs) -> Result<()> {
    if args.rules {
        return output::print_text(DEFAULT_RULES.trim_end());
    }
    output::print_text(
        &serde_json::to_string_pretty(Config::schema()).context("the schema cannot be written as JSON")?,
    )
}
