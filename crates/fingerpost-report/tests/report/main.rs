//! Pictures and pages of a painted drive, checked at known places.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod locating;
mod page;
mod painted_run;
mod pictures;
