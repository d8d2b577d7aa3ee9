//! What is left for every other place of the route: an unknown start, a start that is wrong, a vehicle that was moved.
//!
//! A histogram along the whole route, in cells that move with the vehicle, so that driving costs it no sharpness.

/// Number of cells: 16 m each on a route of 2 km, 160 m on one of 20 km.
const CELLS: usize = 128;

/// Probability by place along the route, in cells.
#[derive(Debug, Clone)]
pub(super) struct Elsewhere {
    /// Probability of each cell.
    masses: [f64; CELLS],
    /// Where the first cell begins, metres along the route: 0 or less, and more than a cell's width before 0 never.
    origin_m: f64,
    cell_m: f64,
    route_length_m: f64,
    /// Standard deviation of the distance driven so far, metres: errors of the scale add up in one direction.
    driven_sigma_m: f64,
    /// Variance that the cells are yet to be blurred by, square metres.
    blur_m2: f64,
}

impl Elsewhere {
    pub(super) fn new(route_length_m: f64) -> Self {
        let cell_m = route_length_m / (CELLS - 1) as f64;
        Self {
            masses: [0.0; CELLS],
            origin_m: 0.0,
            cell_m,
            route_length_m,
            driven_sigma_m: 0.0,
            blur_m2: 0.0,
        }
    }

    pub(super) fn mass(&self) -> f64 {
        self.masses.iter().sum()
    }

    /// Adds `mass`, spread evenly between two places along the route, metres.
    pub(super) fn add_between(&mut self, mass: f64, from_m: f64, to_m: f64) {
        let cell_m = self.cell_m;
        for (start_m, cell) in cells(self.origin_m, cell_m, &mut self.masses) {
            *cell += mass * overlap(start_m, start_m + cell_m, from_m, to_m) / (to_m - from_m);
        }
    }

    /// Adds `mass`, spread evenly over the route.
    pub(super) fn add_evenly(&mut self, mass: f64) {
        self.add_between(mass, 0.0, self.route_length_m);
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.masses.iter_mut().for_each(|mass| *mass *= factor);
    }

    /// Moves on by `forward_m`, of which this step adds `sigma_m` to the error.
    pub(super) fn advance(&mut self, forward_m: f64, sigma_m: f64) {
        self.blur_m2 += (2.0 * self.driven_sigma_m + sigma_m) * sigma_m;
        self.driven_sigma_m += sigma_m;
        self.blur();
        self.origin_m += forward_m;
        let cells = (self.origin_m / self.cell_m).ceil();
        self.origin_m -= cells * self.cell_m;
        self.shift(cells as i64);
    }

    /// Moves the masses by whole cells; what goes beyond an end of the route is dropped, as no vehicle of this route.
    fn shift(&mut self, cells: i64) {
        let by = usize::try_from(cells.unsigned_abs()).map_or(CELLS, |by| by.min(CELLS));
        if cells >= 0 {
            self.masses.copy_within(..CELLS - by, by);
            self.masses.iter_mut().take(by).for_each(|mass| *mass = 0.0);
        } else {
            self.masses.copy_within(by.., 0);
            self.masses.iter_mut().skip(CELLS - by).for_each(|mass| *mass = 0.0);
        }
    }

    /// Takes what has added up of the variance into the cells, by steps of half a cell squared.
    fn blur(&mut self) {
        let step_m2 = 0.5 * self.cell_m * self.cell_m;
        // The variance of an even spread over the route: no more can be blurred.
        self.blur_m2 = self.blur_m2.min(self.route_length_m * self.route_length_m / 12.0);
        while self.blur_m2 >= step_m2 {
            self.blur_m2 -= step_m2;
            let mut before = self.masses.first().copied().unwrap_or_default();
            for i in 0..CELLS {
                let here = self.masses[i];
                let after = self.masses.get(i + 1).copied().unwrap_or(here);
                self.masses[i] = 0.25 * before + 0.5 * here + 0.25 * after;
                before = here;
            }
        }
    }

    /// Probability between `from_m` and `to_m` along the route.
    pub(super) fn mass_between(&self, from_m: f64, to_m: f64) -> f64 {
        let mut sum = 0.0;
        for (i, mass) in self.masses.iter().enumerate() {
            let start_m = self.origin_m + i as f64 * self.cell_m;
            sum += mass * overlap(start_m, start_m + self.cell_m, from_m, to_m) / self.cell_m;
        }
        sum
    }

    /// Probability per metre at `route_m`, on average over a width of two standard deviations to either side.
    pub(super) fn density(&self, route_m: f64, sigma_m: f64) -> f64 {
        let half_m = (2.0 * sigma_m).max(0.5 * self.cell_m);
        self.mass_between(route_m - half_m, route_m + half_m) / (2.0 * half_m)
    }

    /// Leaves only `share` of what lies between `from_m` and `to_m` along the route.
    pub(super) fn thin(&mut self, from_m: f64, to_m: f64, share: f64) {
        let cell_m = self.cell_m;
        for (start_m, mass) in cells(self.origin_m, cell_m, &mut self.masses) {
            *mass *= 1.0 - (1.0 - share) * overlap(start_m, start_m + cell_m, from_m, to_m) / cell_m;
        }
    }

    /// Multiplies each cell by what `factor` gives for its middle, metres along the route.
    pub(super) fn weigh(&mut self, factor: impl Fn(f64) -> f64) {
        let cell_m = self.cell_m;
        for (start_m, mass) in cells(self.origin_m, cell_m, &mut self.masses) {
            *mass *= factor(start_m + 0.5 * cell_m);
        }
    }

    /// Mean and variance of the progress, metres and square metres; none without any mass.
    pub(super) fn moments_m(&self) -> Option<(f64, f64)> {
        let mass = self.mass();
        let middles = || (0..CELLS).map(|i| self.origin_m + (i as f64 + 0.5) * self.cell_m);
        let mean = |value: &dyn Fn(f64) -> f64| {
            self.masses.iter().zip(middles()).map(|(mass, at_m)| mass * value(at_m)).sum::<f64>() / mass
        };
        (mass > 0.0).then(|| {
            let mean_m = mean(&|at_m| at_m);
            (mean_m, mean(&|at_m| (at_m - mean_m).powi(2)) + self.cell_m * self.cell_m / 12.0)
        })
    }
}

fn cells(origin_m: f64, cell_m: f64, masses: &mut [f64]) -> impl Iterator<Item = (f64, &mut f64)> {
    masses.iter_mut().enumerate().map(move |(i, mass)| (origin_m + i as f64 * cell_m, mass))
}

fn overlap(from_m: f64, to_m: f64, other_from_m: f64, other_to_m: f64) -> f64 {
    (to_m.min(other_to_m) - from_m.max(other_from_m)).max(0.0)
}
