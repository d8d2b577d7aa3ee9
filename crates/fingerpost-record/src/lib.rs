//! What the method says of a frame, for files and viewers.
//!
//! At the top: the line of `frames.jsonl` that the program, its recording and its Python package give. Numbers are rounded there,
//! to digits finer than anything the method resolves, so that the same run gives the same text.
//!
//! Two features bring more:
//!
//! - `mcap`, the module `recording`: frames with their evidence as MCAP messages in Foxglove's schemas.
//! - `live`, the module `live`: these messages to viewers that are connected.

mod advice;
mod centreline;
mod fix;
mod frame;
mod lanes;
#[cfg(feature = "live")]
pub mod live;
#[cfg(feature = "mcap")]
pub mod recording;

pub use fix::fix_status;
pub use frame::{
    ANGLE_DIGITS, DIGITS, FrameTime, broken_record, feature_identities, frame_record, kind_name,
    motion_doubt, rounded,
};
pub use lanes::PIXEL_DIGITS;
