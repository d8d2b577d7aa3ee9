//! Signals of a vehicle's CAN bus: logs of `candump -L`, SocketCAN interfaces, and DBC files that say what the bits mean.
//!
//! A [`CanDatabase`] gives the [`SignalLayout`] of a signal by its name; [`read_can_log`] hands out the frames of a log,
//! [`SignalLog`] the samples of chosen signals. With the cargo feature `socketcan` a `CanListener` does the same from a
//! bus. Frames are decoded here, and only those of wanted signals are kept. CAN XL is not read.

mod bits;
mod candump;
mod database;
mod frame;
mod j1939;
mod layout;
#[cfg(all(feature = "socketcan", target_os = "linux"))]
mod listener;
mod log;

pub use candump::{CanLogError, CanLogFrames, parse_candump_line, read_can_log};
pub use database::{CanDatabase, CanDatabaseError, UnknownSignal};
pub use frame::{CanFrame, CanId, LogFrame};
pub use j1939::NoValue;
pub use layout::{SignalLayout, SignalReading};
#[cfg(all(feature = "socketcan", target_os = "linux"))]
pub use listener::{CanListener, CanListenerError};
pub use log::{NoValues, SignalLog, SignalSample};
