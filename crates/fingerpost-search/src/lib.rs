//! Search for the settings that no others beat in everything: several objectives at once, all to be made small.
//!
//! [`Nsga2`] is the genetic algorithm of K. Deb, A. Pratap, S. Agarwal and T. Meyarivan, "A fast and elitist multiobjective
//! genetic algorithm: NSGA-II", IEEE Transactions on Evolutionary Computation 6(2), 2002. It is asked for points and told what
//! came of them, a generation at a time; whoever asks does the work between. What it asks for follows from its seed and from
//! what it was told alone, so that a search can be played back from its record and gone on with.
//!
//! Nothing here knows what the numbers mean, opens a file or reads a clock.

mod dominance;
mod nsga2;
mod random;
mod screening;
mod variable;

pub use dominance::{crowding, dominates, fronts};
pub use nsga2::{Nsga2, SearchError, SearchOptions};
pub use screening::{effects, one_at_a_time};
pub use variable::{Scale, Variable, VariableError};
