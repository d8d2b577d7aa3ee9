//! `fingerpost man`: pages of the manual.

use std::io;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use fingerpost_io::{create_folder, write_file};

use crate::examples::examples;
use crate::output_path::{self, FileKind};
use crate::{Cli, output};

/// Print the program's page of the manual, or write a page for every command.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "man | man -l -",
    "man --out ~/.local/share/man/man1"
))]
pub(crate) struct ManArgs {
    /// Folder to write the pages into, fingerpost.1, fingerpost-run.1 and so on; pages of an earlier `man` are replaced.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// What the pages are of, and how the line with a page's title ends by it.
const SOURCE: &str = "Fingerpost";
const TITLE_END: &str = " Fingerpost Fingerpost";

/// Prints or writes.
pub(crate) fn man(args: &ManArgs) -> Result<()> {
    // A page tells of the commands alone.
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let Some(out) = &args.out else {
        return output::print_text(page(&program)?.trim_end());
    };
    let (mut pages, mut waiting) = (Vec::new(), vec![&program]);
    while let Some(command) = waiting.pop() {
        let path = out.join(Man::new(command.clone()).get_filename());
        // All of them before the first is written.
        output_path::check_file(&path, FileKind::Page, [])?;
        pages.push((path, page(command)?));
        waiting.extend(command.get_subcommands().filter(|command| !command.is_hide_set()));
    }
    create_folder(out)?;
    pages.iter().try_for_each(|(path, page)| Ok(write_file(path, page)?))
}

/// Whether a text is such a page, of this version or another.
pub(crate) fn is_page(text: &str) -> bool {
    text.lines().any(|line| line.starts_with(".TH fingerpost") && line.ends_with(TITLE_END))
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
    let man = Man::new(command.clone()).date(version).source(SOURCE).manual(SOURCE);
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
