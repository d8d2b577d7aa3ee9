//! `fingerpost man`: pages of the manual.

use std::io;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use fingerpost_io::{create_folder, write_file};

use crate::examples::examples;
use crate::{Cli, output};

/// Print the program's page of the manual, or write a page for every command.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "man | man -l -",
    "man --out ~/.local/share/man/man1"
))]
pub(crate) struct ManArgs {
    /// Folder to write the pages into, fingerpost.1, fingerpost-run.1 and so on; files of these names are replaced.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Prints or writes.
pub(crate) fn man(args: &ManArgs) -> Result<()> {
    // A page tells of the commands alone.
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let Some(out) = &args.out else {
        return output::print_text(page(&program)?.trim_end());
    };
    create_folder(out)?;
    let mut waiting = vec![&program];
    while let Some(command) = waiting.pop() {
        write_file(&out.join(Man::new(command.clone()).get_filename()), page(command)?)?;
        waiting.extend(command.get_subcommands().filter(|command| !command.is_hide_set()));
    }
    Ok(())
}

/// The page of a command.
fn page(command: &Command) -> Result<String> {
    let mut page = Vec::new();
    render(command, &mut page).context("the page cannot be made")?;
    String::from_utf8(page).context("the page is no text")
}

/// Its sections, with examples in place of what is shown before the help.
fn render(command: &Command, page: &mut Vec<u8>) -> io::Result<()> {
    // The version stands in the place of a date: which day a page is from says nothing, and an empty one is lost.
    let version = env!("CARGO_PKG_VERSION");
    let man = Man::new(command.clone()).date(version).source("Fingerpost").manual("Fingerpost");
    man.render_title(page)?;
    man.render_name_section(page)?;
    man.render_synopsis_section(page)?;
    man.render_description_section(page)?;
    if let Some(examples) = command.get_before_long_help() {
        let mut section = Roff::new();
        section.control("SH", ["EXAMPLES"]).control("nf", []);
        for line in examples.to_string().lines().skip(1) {
            section.text([roman(line.trim())]);
        }
        section.control("fi", []);
        section.to_writer(page)?;
    }
    man.render_options_section(page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(page)?;
    }
    Ok(())
}
