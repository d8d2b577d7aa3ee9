//! The program's pages in Debian's Chromium.

// A helper that unwraps is part of the test that calls it; what a page takes is printed.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod chromium;
mod comparing;
mod feeling;
mod looking;
mod marking;
mod network_classes;
mod painted_drive;
mod recorded;
mod served;
mod set_up_page;
mod setting_up;
mod setting_up_start;
mod setting_up_video;
mod simulated_drive;
mod simulated_run;
