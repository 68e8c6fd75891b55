//! The height of a sample from the points in it, of a sensor with noise.
//!
//! The highest of many noisy points is too high by some standard deviations, and the mean of all is
//! too low where a sample holds an edge. So a sample takes its *top layer*, the points close below
//! its highest, and from them the height that a flat or sloping patch with these points reaches.

/// Depth of the top layer below the highest point, in standard deviations: the span of a few dozen
/// points.
const LAYER_DEVIATIONS: f32 = 5.0;

/// Maximum slope of a surface on which a point and its neighbours belong together, in pitches of
/// height per sample.
const STEEPEST_PITCHES: f32 = 2.0;

/// Minimum excess of a variance beyond that of noise, in its own standard deviations.
const VARIANCE_DEVIATIONS: f32 = 2.0;

/// Maximum number of times that points that stand by themselves are taken off a sample, to look at
/// those below.
const ROUNDS: usize = 3;

/// Height of a sample without a point.
pub(crate) const NO_POINT: f32 = -1.0;

/// Sorts noisy points into samples. Keeps its memory between clouds.
#[derive(Debug, Clone)]
pub(crate) struct TopLayers {
    ny: usize,
    noise_m: f32,
    layer_m: f32,
    /// Maximum difference in height of points of neighbouring samples that belong together.
    reach_m: f32,
    least_points: u32,
    /// Points of the cloud: the sample and the height of each.
    points: Vec<(u32, f32)>,
    /// The highest point that counts, per sample.
    highest_m: Vec<f32>,
    /// The height below which points count, per sample.
    ends_m: Vec<f32>,
    layers: Vec<Layer>,
    alone: Vec<usize>,
}

/// Points close below a sample's highest: their number, and the sums of their distances from it.
#[derive(Debug, Clone, Copy, Default)]
struct Layer {
    points: u32,
    below_m: f32,
    below_squared_m2: f32,
}

impl TopLayers {
    /// Makes layers for `samples` samples in rows of `ny`, `pitch_m` apart.
    pub(crate) fn new(
        samples: usize,
        ny: usize,
        pitch_m: f64,
        noise_m: f64,
        least_points: u32,
    ) -> Self {
        let layer_m = LAYER_DEVIATIONS * noise_m as f32;
        Self {
            ny,
            noise_m: noise_m as f32,
            layer_m,
            reach_m: layer_m + STEEPEST_PITCHES * pitch_m as f32,
            least_points,
            points: Vec::new(),
            highest_m: vec![NO_POINT; samples],
            ends_m: vec![f32::INFINITY; samples],
            layers: vec![Layer::default(); samples],
            alone: Vec::new(),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.points.clear();
        self.highest_m.fill(NO_POINT);
        self.ends_m.fill(f32::INFINITY);
    }

    /// Takes a point into a sample.
    pub(crate) fn add(&mut self, sample: usize, height_m: f32) {
        if let Some(highest_m) = self.highest_m.get_mut(sample) {
            *highest_m = highest_m.max(height_m);
            self.points.push((sample as u32, height_m));
        }
    }

    /// Writes the samples' heights in metres, [`NO_POINT`] where there is none; counts the lone
    /// points that were left out.
    pub(crate) fn heights(&mut self, heights_m: &mut [f32]) -> u64 {
        let before = self.points.len();
        self.gather();
        for _ in 0..ROUNDS {
            self.find_alone();
            if self.alone.is_empty() {
                break;
            }
            self.take_off();
            self.gather();
        }
        let tops = self.highest_m.iter().zip(&self.layers);
        for (height_m, (highest_m, layer)) in heights_m.iter_mut().zip(tops) {
            *height_m = layer.height_m(*highest_m, self.noise_m);
        }
        (before - self.points.len()) as u64
    }

    /// Collects each sample's top layer.
    fn gather(&mut self) {
        self.layers.fill(Layer::default());
        for (sample, height_m) in &self.points {
            let sample = *sample as usize;
            if let (Some(highest_m), Some(layer)) =
                (self.highest_m.get(sample), self.layers.get_mut(sample))
            {
                let below_m = highest_m - height_m;
                if below_m <= self.layer_m {
                    layer.points += 1;
                    layer.below_m += below_m;
                    layer.below_squared_m2 += below_m * below_m;
                }
            }
        }
    }

    /// Finds the samples whose top layer is of few points, and stands out above everything around.
    fn find_alone(&mut self) {
        self.alone.clear();
        for (sample, layer) in self.layers.iter().enumerate() {
            if (1..self.least_points).contains(&layer.points) && self.is_alone(sample) {
                self.alone.push(sample);
            }
        }
    }

    fn is_alone(&self, sample: usize) -> bool {
        let of = |sample: usize| {
            let highest_m = self.highest_m.get(sample).copied().unwrap_or(NO_POINT);
            let points = self.layers.get(sample).map_or(0, |layer| layer.points);
            (highest_m, points)
        };
        let lowest_m = of(sample).0 - self.reach_m;
        let around = neighbours(sample, self.highest_m.len(), self.ny).map(of);
        let support = around.filter(|(highest_m, _)| *highest_m >= lowest_m);
        support.map(|(_, points)| points).sum::<u32>() < self.least_points
    }

    /// Takes the top layers of the samples found off them.
    fn take_off(&mut self) {
        for sample in &self.alone {
            if let (Some(highest_m), Some(end_m)) = (
                self.highest_m.get_mut(*sample),
                self.ends_m.get_mut(*sample),
            ) {
                *end_m = *highest_m - self.layer_m;
                *highest_m = NO_POINT;
            }
        }
        self.points.retain(|(sample, height_m)| {
            let end_m = self.ends_m.get(*sample as usize);
            end_m.is_some_and(|end_m| height_m < end_m)
        });
        for (sample, height_m) in &self.points {
            if let Some(highest_m) = self.highest_m.get_mut(*sample as usize) {
                *highest_m = highest_m.max(*height_m);
            }
        }
    }
}

impl Layer {
    /// Gives the height that a flat or sloping patch with these points reaches: heights that are
    /// spread evenly over a range have a standard deviation of the range by the root of twelve,
    /// which the noise adds to.
    fn height_m(&self, highest_m: f32, noise_m: f32) -> f32 {
        if self.points < 2 {
            return highest_m;
        }
        let count = self.points as f32;
        let mean_m = self.below_m / count;
        let variance_m2 = (self.below_squared_m2 - mean_m * self.below_m) / (count - 1.0);
        // The variance of few points varies itself: what noise alone may bring is no slope.
        let of_noise = 1.0 + VARIANCE_DEVIATIONS * (2.0 / (count - 1.0)).sqrt();
        let slope_m2 = (variance_m2 - of_noise * noise_m * noise_m).max(0.0);
        (highest_m - mean_m + (3.0 * slope_m2).sqrt()).clamp(0.0, highest_m.max(0.0))
    }
}

/// Says whether something is known of a sample with this height.
pub(crate) fn is_known(height_m: f32) -> bool {
    height_m > NO_POINT
}

/// Gives the samples of a map by cell, `per_cell` along an edge and `ny` cells along y: a cell's
/// index with each of its rows.
pub(crate) fn by_cell<T>(
    samples: &[T],
    per_cell: usize,
    ny: usize,
) -> impl Iterator<Item = (usize, &[T])> {
    let rows = samples.chunks_exact(per_cell * ny).enumerate();
    rows.flat_map(move |(row, samples)| {
        let first_cell = row / per_cell * ny;
        (first_cell..).zip(samples.chunks_exact(per_cell))
    })
}

/// Gives the samples around a sample and itself, of `count` in rows of `ny`.
pub(crate) fn neighbours(sample: usize, count: usize, ny: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (sample / ny, sample % ny);
    let xs = x.saturating_sub(1)..(x + 2).min(count / ny);
    xs.flat_map(move |x| (y.saturating_sub(1)..(y + 2).min(ny)).map(move |y| x * ny + y))
}
