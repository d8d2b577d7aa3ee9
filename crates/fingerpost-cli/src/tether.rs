//! What this program starts ffmpeg and ffprobe through, so that they never outlive it.

use std::ffi::{OsStr, OsString};

use anyhow::{Result, anyhow};
use clap::Args;
use fingerpost_io::become_tethered;

/// Become another program, which ends when the process that started this one does.
#[derive(Debug, Args)]
pub(crate) struct TetherArgs {
    /// Number of that process.
    #[arg(value_name = "PID")]
    parent: u32,
    /// The program and what it is given.
    #[arg(value_name = "COMMAND", required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    command: Vec<OsString>,
}

/// Becomes that program; comes back only if that cannot be done.
pub(crate) fn tether(args: &TetherArgs) -> Result<()> {
    let (program, arguments) = args.command.split_first().ok_or_else(|| anyhow!("no command is given"))?;
    let cause = become_tethered(args.parent, program, arguments.iter().map(OsString::as_os_str));
    Err(anyhow!("{} cannot be run ({cause}); check its installation", OsStr::to_string_lossy(program)))
}
