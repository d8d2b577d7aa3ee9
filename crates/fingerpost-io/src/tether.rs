//! Programs that end with the one that started them, even when that is killed.
//!
//! On Linux the system sends a signal to a process whose parent has ended, if the process asks for it; a program as ffmpeg
//! does not ask, and its parent cannot ask for it. So a program of ours is started in its place, asks, and becomes it.

use std::{ffi::OsStr, io, path::Path, process::Command};

/// First argument of the program that [`become_tethered`] is called by; its parent's number and the command follow.
pub const TETHER_ARGUMENT: &str = "tether";

/// Becomes another program that ends when the process `parent` does. Comes back with what went wrong.
///
/// On systems other than Linux the program is not tethered.
#[cfg(unix)]
pub fn become_tethered<'a>(
    parent: u32,
    program: &OsStr,
    arguments: impl IntoIterator<Item = &'a OsStr>,
) -> io::Error {
    use std::os::unix::process::CommandExt;
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, set_parent_process_death_signal};
        if let Err(cause) = set_parent_process_death_signal(Some(Signal::KILL)) {
            return cause.into();
        }
    }
    if std::os::unix::process::parent_id() != parent {
        return io::Error::other("who started it has ended already");
    }
    Command::new(program).args(arguments).exec()
}

/// The command that starts `program` through `tether`, a program that calls [`become_tethered`].
pub(crate) fn tethered(tether: &Path, program: &Path) -> Command {
    let mut command = Command::new(tether);
    command.arg(TETHER_ARGUMENT).arg(std::process::id().to_string()).arg(program);
    command
}

/// Whether the system finds a program of that name or path.
pub(crate) fn is_there(program: &Path) -> bool {
    if program.components().count() > 1 {
        return program.exists();
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}
