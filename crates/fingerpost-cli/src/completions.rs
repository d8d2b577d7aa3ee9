//! `fingerpost completions`: what a shell completes.

use anyhow::Result;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;

use crate::examples::examples;
use crate::version::VERSION;
use crate::{Cli, output};

/// What the program is called by.
const NAME: &str = "fingerpost";

/// Print what makes a shell complete the program's commands and options.
///
/// Bash reads it from ~/.local/share/bash-completion/completions/fingerpost, fish from ~/.config/fish/completions/fingerpost.fish, zsh from
/// a file _fingerpost in a folder of its $fpath. The Debian package brings those of these three.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "completions bash > ~/.local/share/bash-completion/completions/fingerpost",
    "completions fish > ~/.config/fish/completions/fingerpost.fish"
))]
pub(crate) struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

/// Prints the completions on standard output.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<()> {
    let all = Cli::command();
    // Completions would offer what is hidden too.
    let shown = all.get_subcommands().filter(|command| !command.is_hide_set()).cloned();
    let mut program =
        Command::new(NAME).version(VERSION).args(all.get_arguments().cloned()).subcommands(shown);
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, NAME, &mut text);
    output::print_text(String::from_utf8_lossy(&text).trim_end())
}
