//! What things of several sizes cost, and the power of the size with which that grows.

use serde::Serialize;

use crate::measure::{median, processor_ms};

/// By how much a found power may be above the expected one.
const TOLERANCE: f64 = 0.1;
/// Least cost that a power is made of, bytes and milliseconds: less is nothing.
const LEAST: f64 = 1e-6;

/// What one of some size costs.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Cost {
    pub size: f64,
    /// Processor time, milliseconds.
    pub ms: f64,
    /// Most memory that was held at once, bytes.
    pub bytes: f64,
}

impl Cost {
    /// Of work that is done `times` times: the median, and the memory of one of them.
    pub fn of<T>(size: f64, times: usize, mut work: impl FnMut() -> T) -> Self {
        let mut bytes = 0;
        let mut laps_ms: Vec<f64> = (0..times.max(1))
            .map(|_| {
                let start_ms = processor_ms();
                let taken = allocation_counter::measure(|| drop(work()));
                bytes = taken.bytes_max;
                processor_ms() - start_ms
            })
            .collect();
        Self { size, ms: median(&mut laps_ms), bytes: bytes as f64 }
    }
}

/// Powers of the size, of time and of memory.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Powers {
    pub ms: f64,
    pub bytes: f64,
}

/// How one thing's costs grow with its size.
#[derive(Debug, Clone, Serialize)]
pub struct Growth {
    pub what: String,
    /// What the size is measured in.
    pub unit: &'static str,
    pub costs: Vec<Cost>,
    pub expected: Powers,
    pub found: Powers,
}

impl Growth {
    pub fn new(what: &str, unit: &'static str, costs: Vec<Cost>, expected: Powers) -> Self {
        let found = Powers { ms: power(&costs, |cost| cost.ms), bytes: power(&costs, |cost| cost.bytes) };
        Self { what: what.to_owned(), unit, costs, expected, found }
    }

    /// Whether neither grows faster than expected.
    pub fn holds(&self) -> bool {
        self.found.ms <= self.expected.ms + TOLERANCE && self.found.bytes <= self.expected.bytes + TOLERANCE
    }

    /// The lines of the table for people.
    pub fn lines(&self) -> String {
        let says = if self.holds() { "holds" } else { "FALLS SHORT" };
        let mut text = format!(
            "  {:<58} time ^{:.2} of {:.1}, memory ^{:.2} of {:.1}   {says}\n",
            self.what, self.found.ms, self.expected.ms, self.found.bytes, self.expected.bytes
        );
        for cost in &self.costs {
            text += &format!(
                "    {:>10} {:<12} {:>14.3} ms {:>14.3} MiB\n",
                cost.size,
                self.unit,
                cost.ms,
                cost.bytes / 1_048_576.0
            );
        }
        text
    }
}

/// The slope of the line through the logarithms, by least squares.
fn power(costs: &[Cost], of: impl Fn(&Cost) -> f64) -> f64 {
    let points: Vec<[f64; 2]> =
        costs.iter().map(|cost| [libm::log(cost.size), libm::log(of(cost).max(LEAST))]).collect();
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [mean_x, mean_y] = [mean(0), mean(1)];
    let products: f64 = points.iter().map(|[x, y]| (x - mean_x) * (y - mean_y)).sum();
    let squares: f64 = points.iter().map(|[x, _]| (x - mean_x) * (x - mean_x)).sum();
    products / squares
}
