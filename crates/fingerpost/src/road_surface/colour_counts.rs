//! Counts of the colours of some part of the view, in which older frames count less.

use fingerpost_vision::colour::HueSaturationBins;

/// How many pixels had each hue and saturation.
#[derive(Debug)]
pub(super) struct ColourCounts {
    bins: HueSaturationBins,
    counts: Vec<f32>,
}

impl ColourCounts {
    /// Nothing is counted yet.
    pub(super) fn new(bins: HueSaturationBins) -> Self {
        Self { bins, counts: vec![0.0; bins.count()] }
    }

    pub(super) fn forget(&mut self) {
        self.counts.fill(0.0);
    }

    /// Leaves this share of all counts.
    pub(super) fn fade(&mut self, kept: f32) {
        self.counts.iter_mut().for_each(|count| *count *= kept);
    }

    /// Counts a pixel; one of no bin is none.
    pub(super) fn add(&mut self, bin: u16) {
        if let Some(count) = self.counts.get_mut(usize::from(bin)) {
            *count += 1.0;
        }
    }

    pub(super) fn total(&self) -> f32 {
        self.counts.iter().sum()
    }

    /// For each bin, how many times the count of an even spread over all bins it and those beside it have, in the mean; hue
    /// goes round. Nothing of nothing.
    pub(super) fn densities(&self) -> impl Iterator<Item = f32> {
        let even = (self.total() / self.counts.len() as f32).max(f32::EPSILON);
        (0..self.counts.len()).map(move |index| self.about(index) / even)
    }

    /// Mean count of a bin and those beside it.
    fn about(&self, index: usize) -> f32 {
        let (hues, saturations) = (usize::from(self.bins.hue), usize::from(self.bins.saturation));
        let (hue, saturation) = (index / saturations, index % saturations);
        let mut sum = 0.0;
        for hue in [hue + hues - 1, hue, hue + 1] {
            for saturation in
                [saturation.saturating_sub(1), saturation, (saturation + 1).min(saturations - 1)]
            {
                sum += self.counts[hue % hues * saturations + saturation];
            }
        }
        sum / 9.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: HueSaturationBins = HueSaturationBins { hue: 8, saturation: 4 };

    #[test]
    fn neighbours_share_a_count_and_hue_goes_round() {
        let mut counts = ColourCounts::new(BINS);
        assert!(counts.densities().all(|density| density == 0.0));
        // Hue 0, saturation 2; and one that no bin is.
        counts.add(2);
        counts.add(900);
        let holds = |counts: &ColourCounts, total: f32| (counts.total() - total).abs() < 1e-6;
        assert!(holds(&counts, 1.0));
        let dense: Vec<usize> =
            counts.densities().enumerate().filter(|(_, d)| *d > 0.0).map(|(i, _)| i).collect();
        assert_eq!(dense, [1, 2, 3, 5, 6, 7, 29, 30, 31]);
        let density = counts.densities().nth(6).unwrap();
        assert!((density - 32.0 / 9.0).abs() < 1e-5, "{density}");
        counts.fade(0.25);
        assert!(holds(&counts, 0.25));
        counts.forget();
        assert!(holds(&counts, 0.0));
    }
}
