//! The genetic algorithm.

use thiserror::Error;

use crate::dominance::{crowding, fronts};
use crate::random::Random;
use crate::variable::Variable;

/// Share of pairs of parents that are crossed; the others give copies, which mutation changes (Deb et al. 2002, section V).
const CROSSED_SHARE: f64 = 0.9;
/// How near children lie to their parents, and changed genes to what they were: distribution indices of simulated binary
/// crossover and of polynomial mutation (K. Deb and R. Agrawal, "Simulated binary crossover for continuous search space",
/// Complex Systems 9, 1995). Less than the 20 of the paper, which has tens of thousands of trials to move in.
const CROSSOVER_INDEX: f64 = 10.0;
/// See [`CROSSOVER_INDEX`].
const MUTATION_INDEX: f64 = 10.0;
/// Draws of a point until it is allowed and new.
const ATTEMPTS: usize = 200;

/// How a search goes about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchOptions {
    /// Points of a generation, 2 at the least.
    pub population: usize,
    /// What all that is random follows from.
    pub seed: u64,
}

/// A search that cannot be done.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SearchError {
    /// There is nothing to vary.
    #[error("there is nothing to search; give one variable at the least")]
    NoVariables,
    /// A generation of fewer than two has no parents.
    #[error("a population of {population} has no parents; give 2 or more")]
    Population {
        /// Points of a generation asked for.
        population: usize,
    },
    /// The start is of another search.
    #[error("the start has {found} values for {wanted} variables; give one each")]
    Start {
        /// Values given.
        found: usize,
        /// Variables to be searched.
        wanted: usize,
    },
    /// What is told is not what was asked.
    #[error(
        "objectives of {found} points are told and {wanted} were asked for; tell those of all points of the generation"
    )]
    Told {
        /// Points that are told of.
        found: usize,
        /// Points that were asked for.
        wanted: usize,
    },
}

/// A point with what came of it.
#[derive(Debug, Clone)]
struct Individual {
    genes: Vec<f64>,
    values: Vec<f64>,
    objectives: Vec<f64>,
}

/// The search, a generation at a time: ask, work, tell.
///
/// ```
/// use fingerpost_search::{Nsga2, Scale, SearchOptions, Variable};
/// let x = Variable::real(-2.0, 4.0, Scale::Linear)?;
/// let mut search = Nsga2::new(vec![x], &[3.0], SearchOptions { population: 10, seed: 1 })?;
/// let mut nearest = f64::INFINITY;
/// for _ in 0..10 {
///     let points = search.ask(&|_| true);
///     let objectives = points.iter().map(|x| vec![x[0].powi(2), (x[0] - 2.0).powi(2)]).collect();
///     nearest = points.iter().map(|x| (x[0] - 1.0).abs()).fold(nearest, f64::min);
///     search.tell(objectives)?;
/// }
/// assert!(nearest < 0.3, "{nearest}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Nsga2 {
    variables: Vec<Variable>,
    options: SearchOptions,
    /// Where the search begins.
    start: Vec<f64>,
    generation: u64,
    /// The best of all generations, best first, as many as a generation has.
    parents: Vec<Individual>,
    /// The points that were asked for and not told of yet.
    asked: Vec<Individual>,
    /// Values of all points so far.
    seen: Vec<Vec<f64>>,
}

impl Nsga2 {
    /// A search that begins at the values `start`, which are the first point it asks for.
    ///
    /// # Errors
    /// [`SearchError`] when there is nothing to vary, the start has other variables, or a generation has no parents.
    pub fn new(variables: Vec<Variable>, start: &[f64], options: SearchOptions) -> Result<Self, SearchError> {
        if variables.is_empty() {
            return Err(SearchError::NoVariables);
        }
        if options.population < 2 {
            return Err(SearchError::Population { population: options.population });
        }
        if start.len() != variables.len() {
            return Err(SearchError::Start { found: start.len(), wanted: variables.len() });
        }
        let start = start.to_vec();
        let (parents, asked, seen) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Self { variables, options, start, generation: 0, parents, asked, seen })
    }

    /// The values of the next generation's points; the same again until they are told of. Where `allowed` refuses what is drawn,
    /// others are drawn, so that a generation may be smaller than asked for where hardly anything is allowed or new.
    pub fn ask(&mut self, allowed: &dyn Fn(&[f64]) -> bool) -> Vec<Vec<f64>> {
        if self.asked.is_empty() {
            let mut random = Random::new(self.options.seed, self.generation);
            if self.parents.is_empty() {
                self.begin(&mut random, allowed);
            } else {
                self.breed(&mut random, allowed);
            }
        }
        self.asked.iter().map(|point| point.values.clone()).collect()
    }

    /// Takes in the objectives of the points that were asked for, in their order. What is no number counts as worse than any.
    ///
    /// # Errors
    /// [`SearchError::Told`] when they are not as many as the points.
    pub fn tell(&mut self, objectives: Vec<Vec<f64>>) -> Result<(), SearchError> {
        if objectives.len() != self.asked.len() {
            return Err(SearchError::Told { found: objectives.len(), wanted: self.asked.len() });
        }
        let worst_for_nan = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
        let told = self.asked.drain(..).zip(objectives).map(|(point, objectives)| Individual {
            objectives: objectives.into_iter().map(worst_for_nan).collect(),
            ..point
        });
        let all: Vec<Individual> = self.parents.drain(..).chain(told).collect();
        self.parents = best(all, self.options.population);
        self.generation += 1;
        Ok(())
    }

    /// The first generation: the start, and a Latin hypercube (M. McKay, R. Beckman and W. Conover, Technometrics 21, 1979)
    /// drawn towards it, the first points the most: the start is known to be good, and far from it much fails.
    fn begin(&mut self, random: &mut Random, allowed: &dyn Fn(&[f64]) -> bool) {
        let genes: Vec<f64> =
            self.variables.iter().zip(&self.start).map(|(v, &value)| v.gene(value)).collect();
        // As it was given, whatever the rounding of values.
        self.seen.push(self.start.clone());
        self.asked.push(Individual {
            genes: genes.clone(),
            values: self.start.clone(),
            objectives: Vec::new(),
        });
        let others = self.options.population - 1;
        let orders: Vec<Vec<usize>> = self.variables.iter().map(|_| random.order(others)).collect();
        for index in 0..others {
            let reach = (index + 1) as f64 / others as f64;
            self.add_allowed(random, allowed, |random| {
                let strata = genes.iter().zip(&orders).map(|(&from, order)| {
                    let to = (order[index] as f64 + random.unit()) / others as f64;
                    from + reach * (to - from)
                });
                strata.collect()
            });
        }
    }

    /// A later generation: children of the best so far.
    fn breed(&mut self, random: &mut Random, allowed: &dyn Fn(&[f64]) -> bool) {
        let parents = std::mem::take(&mut self.parents);
        for _ in 0..self.options.population {
            self.add_allowed(random, allowed, |random| {
                let [one, two] = [0; 2].map(|_| &parents[chosen(random, parents.len())].genes);
                let mut child = crossed(random, one, two);
                mutate(random, &mut child);
                child
            });
        }
        self.parents = parents;
    }

    /// Adds a point to those that are asked for: the first drawn one that is allowed and new.
    fn add_allowed(
        &mut self,
        random: &mut Random,
        allowed: &dyn Fn(&[f64]) -> bool,
        draw: impl Fn(&mut Random) -> Vec<f64>,
    ) {
        for _ in 0..ATTEMPTS {
            let mut genes: Vec<f64> = draw(random);
            genes.iter_mut().for_each(|gene| *gene = gene.clamp(0.0, 1.0));
            let values: Vec<f64> =
                self.variables.iter().zip(&genes).map(|(v, &gene)| v.value(gene)).collect();
            if !self.seen.contains(&values) && allowed(&values) {
                self.seen.push(values.clone());
                self.asked.push(Individual { genes, values, objectives: Vec::new() });
                return;
            }
        }
    }
}

/// The `count` best, best first: by fronts, and within one those with more room (the crowded comparison of Deb et al. 2002).
fn best(all: Vec<Individual>, count: usize) -> Vec<Individual> {
    let objectives: Vec<&[f64]> = all.iter().map(|point| point.objectives.as_slice()).collect();
    let mut order = Vec::with_capacity(all.len());
    for front in fronts(&objectives) {
        let room = crowding(&objectives, &front);
        let mut places: Vec<usize> = (0..front.len()).collect();
        places.sort_by(|&a, &b| room[b].total_cmp(&room[a]));
        order.extend(places.into_iter().map(|place| front[place]));
    }
    order.truncate(count);
    order.into_iter().map(|index| all[index].clone()).collect()
}

/// The better of two drawn parents, which stand best first.
fn chosen(random: &mut Random, parents: usize) -> usize {
    random.below(parents).min(random.below(parents))
}

/// One child of two parents by simulated binary crossover.
fn crossed(random: &mut Random, one: &[f64], two: &[f64]) -> Vec<f64> {
    if random.unit() >= CROSSED_SHARE {
        return one.to_vec();
    }
    let gene = |(&a, &b): (&f64, &f64)| {
        let drawn = random.unit();
        let spread = if drawn < 0.5 { 2.0 * drawn } else { 0.5 / (1.0 - drawn) };
        let spread = libm::pow(spread, 1.0 / (CROSSOVER_INDEX + 1.0));
        // Either child of the pair is as likely.
        let side = if random.unit() < 0.5 { spread } else { -spread };
        0.5 * (a + b) + 0.5 * side * (a - b)
    };
    one.iter().zip(two).map(gene).collect()
}

/// Changes one gene of a point on average by polynomial mutation.
fn mutate(random: &mut Random, genes: &mut [f64]) {
    let share = 1.0 / genes.len() as f64;
    for gene in genes {
        if random.unit() >= share {
            continue;
        }
        let drawn = random.unit();
        let step = if drawn < 0.5 {
            libm::pow(2.0 * drawn, 1.0 / (MUTATION_INDEX + 1.0)) - 1.0
        } else {
            1.0 - libm::pow(2.0 * (1.0 - drawn), 1.0 / (MUTATION_INDEX + 1.0))
        };
        *gene += step;
    }
}
