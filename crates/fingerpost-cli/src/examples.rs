//! The examples that a command's `--help` opens with.

/// Two calls of the program, each without its name, as the text before a command's help.
macro_rules! examples {
    ($first:literal, $second:literal) => {
        concat!("Examples:\n  fingerpost ", $first, "\n  fingerpost ", $second)
    };
}
pub(crate) use examples;

#[cfg(test)]
mod tests {
    use clap::{Command, CommandFactory, Parser};

    use crate::Cli;

    /// The program and all of its commands that are shown, each with the words that call it.
    fn commands() -> Vec<(String, Command)> {
        let mut waiting = vec![(String::new(), Cli::command())];
        let mut found = Vec::new();
        while let Some((path, command)) = waiting.pop() {
            let shown = command.get_subcommands().filter(|command| !command.is_hide_set());
            waiting.extend(shown.map(|inner| (format!("{path} {}", inner.get_name()), inner.clone())));
            found.push((path, command));
        }
        found
    }

    #[test]
    fn every_help_opens_with_two_examples_that_the_program_takes() {
        let commands = commands();
        assert!(commands.len() > 15, "{}", commands.len());
        for (path, mut command) in commands {
            let help = command.render_long_help().to_string();
            let examples: Vec<&str> = help
                .lines()
                .skip(1)
                .take_while(|line| line.starts_with("  fingerpost "))
                .map(str::trim)
                .collect();
            assert!(help.starts_with("Examples:\n") && examples.len() == 2, "{path}: {help}");
            assert_ne!(examples[0], examples[1]);
            for example in examples {
                assert!(example.starts_with(&format!("fingerpost{path}")), "{path}: {example}");
                // What a shell does with what comes out is no argument.
                let arguments = example.split_whitespace().take_while(|word| !matches!(*word, ">" | "|"));
                if let Err(refused) = Cli::try_parse_from(arguments) {
                    panic!("{example}: {refused}");
                }
            }
        }
    }
}
