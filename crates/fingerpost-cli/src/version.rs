//! Which program this is.

/// Version, and the commit where it was built in a checkout: "0.1.0 (commit 0123456789ab)".
pub(crate) const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), env!("FINGERPOST_COMMIT"));

/// The first line of a configuration that the program writes, a comment that it reads over.
pub(crate) const WRITTEN_BY: &str =
    concat!("# Written by fingerpost ", env!("CARGO_PKG_VERSION"), env!("FINGERPOST_COMMIT"), "\n");

/// The same in words.
pub(crate) const WRITTEN_BY_PROGRAM: &str =
    concat!("fingerpost ", env!("CARGO_PKG_VERSION"), env!("FINGERPOST_COMMIT"));
