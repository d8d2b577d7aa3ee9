//! `fingerpost schema`: what may stand in fingerpost.toml.

use anyhow::{Context, Result};
use clap::Args;
use fingerpost::Config;

use crate::output;

/// Print the JSON Schema of fingerpost.toml: every key with its unit, range and default.
#[derive(Debug, Args)]
pub(crate) struct SchemaArgs {}

/// Prints the schema on standard output.
pub(crate) fn schema(SchemaArgs {}: &SchemaArgs) -> Result<()> {
    output::print_text(
        &serde_json::to_string_pretty(Config::schema()).context("the schema cannot be written as JSON")?,
    )
}
