//! Lanes as in paper 3 (III-C): lines in sections of the picture, kept from frame to frame, and a spline through them.

mod section_tracker;

pub use section_tracker::SectionTracker;
