//! From what the method says of a frame to the line of `frames.jsonl` that the program, its recording and its Python package give.
//!
//! Numbers are rounded here, to digits finer than anything the method resolves, so that the same run gives the same text.

mod advice;
mod centreline;
mod fix;
mod frame;
mod lanes;

pub use fix::fix_status;
pub use frame::{
    ANGLE_DIGITS, DIGITS, FrameTime, broken_record, feature_identities, frame_record, kind_name, rounded,
};
pub use lanes::PIXEL_DIGITS;
