//! Metrics of hand-made runs against numbers computed by hand.

mod junctions;
mod made_by_hand;
mod motion;
