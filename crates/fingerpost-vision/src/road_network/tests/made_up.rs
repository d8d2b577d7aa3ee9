//! Networks of made-up numbers, and what comes of them by the definition: one place, channel and product after the other.

use crate::picture::Plane;

/// A network as its file has it.
#[derive(Debug, Clone)]
pub(super) struct MadeUp {
    pub(super) size: [usize; 2],
    pub(super) strip: [f32; 4],
    pub(super) channels: [usize; 4],
    pub(super) blocks: [usize; 3],
    pub(super) outputs: usize,
    pub(super) layers: Vec<Layer>,
}

#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub(super) inputs: usize,
    pub(super) weights: Vec<i8>,
    pub(super) bias: Vec<i32>,
    pub(super) multiplier: Vec<f32>,
    pub(super) scales: Vec<f32>,
}

/// A linear congruential generator with Knuth's constants for MMIX.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    pub(super) fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }

    fn share(&mut self) -> f32 {
        self.next() as f32 / u32::MAX as f32
    }
}

/// Weights of a network.
#[derive(Debug, Clone, Copy)]
pub(super) enum Filling {
    Noise,
    All(i8),
}

impl MadeUp {
    pub(super) fn new(
        random: &mut Random,
        size: [usize; 2],
        channels: [usize; 4],
        blocks: [usize; 3],
        outputs: usize,
        filling: Filling,
    ) -> Self {
        let strip = [0.86, 1.0, 0.36, 0.64];
        let mut made = Self { size, strip, channels, blocks, outputs, layers: Vec::new() };
        let mut layer = |inputs: usize, outputs: usize, scales: &[f32]| {
            // So that sums spread over all activations, some beyond them.
            let scale = 1.0 / (36.0 * (inputs as f32).sqrt());
            made.layers.push(Layer {
                inputs,
                weights: (0..inputs * outputs)
                    .map(|_| match filling {
                        Filling::Noise => random.next() as i8,
                        Filling::All(weight) => weight,
                    })
                    .collect(),
                bias: (0..outputs).map(|_| random.below(4001) as i32 - 1000).collect(),
                multiplier: (0..outputs).map(|_| scale * (0.2 + random.share())).collect(),
                scales: scales.to_vec(),
            });
        };
        let c = channels;
        layer(72, c[0], &[]);
        for level in 0..3 {
            layer(9, c[level], &[]);
            layer(c[level], c[level + 1], &[]);
            for _ in 0..blocks[level] {
                layer(9, c[level + 1], &[]);
                layer(c[level + 1], c[level + 1], &[0.71]);
            }
        }
        let places = (size[0] / 16 * (size[1] / 16)) as f32;
        layer(c[3], c[3], &[0.9 / places, 0.8, 0.33]);
        for level in (0..3).rev() {
            layer(c[level + 1], c[level], &[0.041, 0.62]);
            layer(9, c[level], &[]);
            layer(c[level], c[level], &[]);
        }
        layer(c[0], outputs, &[]);
        made
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = b"FPROAD01".to_vec();
        let mut number = |value: usize| bytes.extend((value as u32).to_le_bytes());
        self.size.into_iter().for_each(&mut number);
        bytes.extend(self.strip.iter().flat_map(|side| side.to_le_bytes()));
        let mut number = |value: usize| bytes.extend((value as u32).to_le_bytes());
        self.channels.into_iter().chain(self.blocks).chain([self.outputs]).for_each(&mut number);
        for layer in &self.layers {
            bytes.extend(layer.weights.iter().map(|&weight| weight as u8));
            bytes.extend(layer.bias.iter().flat_map(|bias| bias.to_le_bytes()));
            bytes
                .extend(layer.multiplier.iter().chain(&layer.scales).flat_map(|number| number.to_le_bytes()));
        }
        bytes
    }

    /// The logits for an input of eight numbers a pixel.
    pub(super) fn logits(&self, input: &[u8]) -> Vec<Plane<i8>> {
        let mut layers = self.layers.iter();
        let mut layer = || layers.next().unwrap();
        let input = Values::new(self.size, 8, input.iter().map(|&q| i64::from(q) - 64).collect());
        let mut levels = vec![input.full(layer(), 2)];
        for blocks in self.blocks {
            let mut level = levels[levels.len() - 1].depthwise(layer(), 2).pointwise(layer(), 0);
            for _ in 0..blocks {
                let between = level.depthwise(layer(), 1);
                level = between.pointwise_added(layer(), 0, Some(&level));
            }
            levels.push(level);
        }
        let context = layer();
        let mut level = levels.pop().unwrap();
        let mean: Vec<i64> = (0..level.channels)
            .map(|channel| {
                let sum: i64 = level.values.iter().skip(channel).step_by(level.channels).sum();
                rounded(sum as f32 * context.scales[0], 0)
            })
            .collect();
        let mean = Values::new([1, 1], level.channels, mean).pointwise(context, 0);
        for (index, value) in level.values.iter_mut().enumerate() {
            let of_context = mean.values[index % mean.channels] as f32 * context.scales[2];
            *value = rounded(*value as f32 * context.scales[1] + of_context, 0);
        }
        while let Some(above) = levels.pop() {
            let narrow = layer();
            let doubled = level.pointwise(narrow, -127).doubled();
            let joined = doubled.values.iter().zip(&above.values).map(|(&doubled, &level)| {
                rounded(doubled as f32 * narrow.scales[0] + level as f32 * narrow.scales[1], 0)
            });
            let joined = Values { values: joined.collect(), ..above };
            level = joined.depthwise(layer(), 1).pointwise(layer(), 0);
        }
        let head = level.pointwise(layer(), -127);
        let plane = |output: usize| {
            let logits = head.values.iter().skip(output).step_by(self.outputs).map(|&logit| logit as i8);
            Plane::from_vec(head.size[0], head.size[1], logits.collect()).unwrap()
        };
        (0..self.outputs).map(plane).collect()
    }
}

/// Numbers of places, channels last.
#[derive(Debug, Clone)]
struct Values {
    size: [usize; 2],
    channels: usize,
    values: Vec<i64>,
}

fn rounded(value: f32, low: i64) -> i64 {
    value.round_ties_even().clamp(low as f32, 127.0) as i64
}

impl Layer {
    fn requantised(&self, output: usize, sum: i64, added: f32, low: i64) -> i64 {
        let sum = sum + i64::from(self.bias[output]);
        rounded(sum as f32 * self.multiplier[output] + added, low)
    }
}

impl Values {
    fn new(size: [usize; 2], channels: usize, values: Vec<i64>) -> Self {
        Self { size, channels, values }
    }

    fn get(&self, x: usize, y: usize, channel: usize) -> i64 {
        self.values[(y * self.size[0] + x) * self.channels + channel]
    }

    /// The same with zeros all around, a place up and left.
    fn padded(&self, x: usize, y: usize, channel: usize) -> i64 {
        let inside = (1..=self.size[0]).contains(&x) && (1..=self.size[1]).contains(&y);
        if inside { self.get(x - 1, y - 1, channel) } else { 0 }
    }

    fn made(size: [usize; 2], channels: usize, mut value: impl FnMut(usize, usize, usize) -> i64) -> Self {
        let mut values = Vec::new();
        for y in 0..size[1] {
            for x in 0..size[0] {
                values.extend((0..channels).map(|channel| value(x, y, channel)));
            }
        }
        Self { size, channels, values }
    }

    fn full(&self, layer: &Layer, step: usize) -> Self {
        Self::made(self.size.map(|side| side / step), layer.bias.len(), |x, y, output| {
            let mut sum = 0;
            for (at, &weight) in layer.weights[output * layer.inputs..][..layer.inputs].iter().enumerate() {
                let (window, channel) = (at / self.channels, at % self.channels);
                sum += i64::from(weight) * self.padded(step * x + window % 3, step * y + window / 3, channel);
            }
            layer.requantised(output, sum, 0.0, 0)
        })
    }

    fn depthwise(&self, layer: &Layer, step: usize) -> Self {
        Self::made(self.size.map(|side| side / step), self.channels, |x, y, channel| {
            let weights = layer.weights[9 * channel..][..9].iter().enumerate();
            let product = |(at, &weight): (usize, &i8)| {
                i64::from(weight) * self.padded(step * x + at % 3, step * y + at / 3, channel)
            };
            layer.requantised(channel, weights.map(product).sum(), 0.0, 0)
        })
    }

    fn pointwise(&self, layer: &Layer, low: i64) -> Self {
        self.pointwise_added(layer, low, None)
    }

    fn pointwise_added(&self, layer: &Layer, low: i64, added: Option<&Self>) -> Self {
        Self::made(self.size, layer.bias.len(), |x, y, output| {
            let weights = layer.weights[output * layer.inputs..][..layer.inputs].iter().enumerate();
            let sum = weights.map(|(channel, &weight)| i64::from(weight) * self.get(x, y, channel)).sum();
            let added = added.map_or(0.0, |added| added.get(x, y, output) as f32 * layer.scales[0]);
            layer.requantised(output, sum, added, low)
        })
    }

    /// In 16ths.
    fn doubled(&self) -> Self {
        let quarters = |at: usize, side: usize| {
            let near = at / 2;
            let far = if at.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(side - 1) };
            [(near, 3), (far, 1)]
        };
        Self::made(self.size.map(|side| 2 * side), self.channels, |x, y, channel| {
            let mut sum = 0;
            for (x, across) in quarters(x, self.size[0]) {
                for (y, down) in quarters(y, self.size[1]) {
                    sum += across * down * self.get(x, y, channel);
                }
            }
            sum
        })
    }
}
