//! What was meant by arguments that are refused.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// A sentence behind the message of an error, where more can be said than it does.
pub(crate) fn hint(error: &clap::Error, mut given: impl Iterator<Item = String>) -> Option<&'static str> {
    let names = |wanted: &str| match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(name)) => name.starts_with(wanted),
        Some(ContextValue::Strings(names)) => names.iter().any(|name| name.starts_with(wanted)),
        _ => false,
    };
    match error.kind() {
        ErrorKind::UnknownArgument if names("--input") => Some(
            "hint: the input has no option before it, as in `fingerpost run /dev/video0 --camera camera.toml --out run`",
        ),
        ErrorKind::MissingRequiredArgument
            if names("--route") && given.any(|word| word.starts_with("--start-m")) =>
        {
            Some(
                "hint: --start-m counts metres along a route, which `fingerpost route` makes of a map and two places; with a map alone give \
                 --near LAT,LON",
            )
        }
        _ => None,
    }
}
