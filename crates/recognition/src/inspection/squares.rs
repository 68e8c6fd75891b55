//! Squares of a container's floor.

use nalgebra::{Point2, Point3};
use ppnpack_packing::kernel::heightmap::Surface;

/// Stands for no height: lower than any.
pub(crate) const NOTHING_M: f32 = f32::MIN;

/// Squares of a container's floor, as its surface samples them; row-major.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Squares {
    nx: usize,
    ny: usize,
    /// The edge of a square, in metres.
    pub(crate) pitch_m: f64,
}

impl Squares {
    /// Gives the squares of a surface; `None` where it has no samples, or they have no sound
    /// distance.
    pub(crate) fn of(surface: &Surface) -> Option<Self> {
        let pitch_m = surface.pitch_m();
        let is_sound = pitch_m > 1e-4 && pitch_m < 1.0 && surface.nx() > 0 && surface.ny() > 0;
        is_sound.then(|| Self {
            nx: surface.nx(),
            ny: surface.ny(),
            pitch_m,
        })
    }

    /// Gives the square that a place lies in.
    pub(crate) fn at(&self, x_m: f64, y_m: f64) -> Option<usize> {
        if !(x_m >= 0.0 && y_m >= 0.0) {
            return None;
        }
        // Casts saturate.
        let (x, y) = ((x_m / self.pitch_m) as usize, (y_m / self.pitch_m) as usize);
        (x < self.nx && y < self.ny).then(|| x * self.ny + y)
    }

    /// Counts the squares that a length reaches.
    pub(crate) fn reach(&self, length_m: f64) -> usize {
        ((length_m / self.pitch_m - 1e-6).ceil().max(0.0) as usize).min(self.nx.max(self.ny))
    }

    /// Gives the greatest value within a distance in squares of each, along both axes.
    pub(crate) fn greatest(&self, values: &[f32], reach: usize) -> Vec<f32> {
        let rows = values.chunks_exact(self.ny);
        let along_y: Vec<f32> = rows.flat_map(|row| window_greatest(row, reach)).collect();
        let mut greatest = vec![0.0; along_y.len()];
        for y in 0..self.ny {
            let column: Vec<f32> = along_y.iter().skip(y).step_by(self.ny).copied().collect();
            let raised = window_greatest(&column, reach);
            for (value, raised) in greatest.iter_mut().skip(y).step_by(self.ny).zip(raised) {
                *value = raised;
            }
        }
        greatest
    }

    /// Gives the height to which a square is hidden from an eye by what stands before it, in
    /// metres; [`NOTHING_M`] where nothing does. `highest_m` is the greatest of the heights.
    pub(crate) fn shadow_m(
        &self,
        heights_m: &[f32],
        highest_m: f64,
        eye_m: &Point3<f64>,
        square: usize,
    ) -> f32 {
        if eye_m.z <= highest_m {
            return f32::MAX;
        }
        let middle = self.middle(square);
        let away = eye_m.xy() - middle;
        let distance_m = away.norm();
        // Farther towards the eye, the line of sight to the floor is higher than everything.
        let reach_m = distance_m * highest_m / eye_m.z;
        let steps = ((reach_m / self.pitch_m).ceil() as usize).min(self.nx + self.ny);
        let shadows_m = (1..=steps).filter_map(|step| {
            let share = step as f64 * self.pitch_m / distance_m;
            let place = middle + away * share;
            let height_m = *heights_m.get(self.at(place.x, place.y)?)?;
            (share < 1.0 && height_m > NOTHING_M)
                .then(|| (f64::from(height_m) - share * eye_m.z) / (1.0 - share))
        });
        shadows_m.fold(f64::from(NOTHING_M), f64::max) as f32
    }

    /// Gives the middle of a square, in metres.
    pub(crate) fn middle(&self, square: usize) -> Point2<f64> {
        let along = |index: usize| (index as f64 + 0.5) * self.pitch_m;
        Point2::new(along(square / self.ny), along(square % self.ny))
    }

    /// Says whether a stretch `length_m` long and `width_m` wide fits in some direction where a
    /// condition holds, bends too.
    pub(crate) fn holds_stretch(&self, is_true: &[bool], length_m: f64, width_m: f64) -> bool {
        let side = ((width_m / self.pitch_m + 0.25).round().max(1.0) as usize).min(self.nx);
        let mut is_free = self.opened(is_true, side);
        let is_long = |[low_x, low_y, high_x, high_y]: [usize; 4]| {
            let (x, y) = (high_x - low_x + 1, high_y - low_y + 1);
            (x as f64).hypot(y as f64) * self.pitch_m >= length_m
        };
        (0..is_free.len()).any(|start| self.taken(&mut is_free, start).is_some_and(is_long))
    }

    /// Gives the samples that are covered by squares of `side` samples that fit where a condition
    /// holds.
    fn opened(&self, is_true: &[bool], side: usize) -> Vec<bool> {
        let mut opened = vec![false; is_true.len()];
        // The side of the greatest square that ends at each sample.
        let mut above = vec![0_usize; self.ny];
        for (x, row) in is_true.chunks_exact(self.ny).enumerate() {
            let (mut left, mut above_left) = (0, 0);
            for (y, (is_true, above)) in row.iter().zip(above.iter_mut()).enumerate() {
                let here = usize::from(*is_true) * (1 + left.min(above_left).min(*above));
                let rows = (here >= side).then(|| x + 1 - side..=x);
                for x in rows.into_iter().flatten() {
                    let first = x * self.ny + y + 1 - side;
                    let covered = opened.get_mut(first..first + side);
                    covered.unwrap_or_default().fill(true);
                }
                (above_left, left) = (*above, here);
                *above = here;
            }
        }
        opened
    }

    /// Takes the samples out that hang together with one; gives the least and greatest indices
    /// along x and y.
    fn taken(&self, is_free: &mut [bool], start: usize) -> Option<[usize; 4]> {
        let mut queue = Vec::new();
        let mut bounds: Option<[usize; 4]> = None;
        take(is_free, start, &mut queue);
        while let Some(square) = queue.pop() {
            let (x, y) = (square / self.ny, square % self.ny);
            let [low_x, low_y, high_x, high_y] = bounds.unwrap_or([x, y, x, y]);
            bounds = Some([low_x.min(x), low_y.min(y), high_x.max(x), high_y.max(y)]);
            for x in x.saturating_sub(1)..(x + 2).min(self.nx) {
                for y in y.saturating_sub(1)..(y + 2).min(self.ny) {
                    take(is_free, x * self.ny + y, &mut queue);
                }
            }
        }
        bounds
    }
}

/// Moves a sample that is still there to a queue.
fn take(is_free: &mut [bool], square: usize, queue: &mut Vec<usize>) {
    if let Some(is_free) = is_free.get_mut(square)
        && std::mem::take(is_free)
    {
        queue.push(square);
    }
}

/// Gives the greatest value within a distance of each.
fn window_greatest(values: &[f32], reach: usize) -> Vec<f32> {
    let greatest = (0..values.len()).map(|index| {
        let end = (index + reach + 1).min(values.len());
        let window = values.get(index.saturating_sub(reach)..end);
        let window = window.unwrap_or_default().iter().copied();
        window.fold(f32::MIN, f32::max)
    });
    greatest.collect()
}
