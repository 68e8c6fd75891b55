//! Holes in a map: samples that nothing is known of, surrounded by samples that something is known
//! of.

use crate::layers::{is_known, neighbours};

/// Memory for the search, kept between maps.
#[derive(Debug, Clone, Default)]
pub(crate) struct Holes {
    is_visited: Vec<bool>,
    hole: Vec<usize>,
}

impl Holes {
    /// Gives the samples of holes the height of the highest sample around, where that is safe: what
    /// could stand unseen in a narrow hole, of at most `most_samples` along x and y, among samples
    /// within `level_m` of each other is narrower still, while what hides
    /// a hole from the sensor stands up from what is beside it. Samples touch across edges and
    /// corners; those outside the map are level with any.
    pub(crate) fn fill(
        &mut self,
        heights_m: &mut [f32],
        ny: usize,
        most_samples: usize,
        level_m: f32,
    ) {
        let are_known = heights_m.iter().map(|height_m| is_known(*height_m));
        self.is_visited.clear();
        self.is_visited.extend(are_known);
        for start in 0..heights_m.len() {
            let Some((lowest_m, highest_m)) = self.visit(heights_m, ny, start) else {
                continue;
            };
            let is_level = highest_m - lowest_m <= level_m;
            let is_fillable = is_level && self.width(ny) <= most_samples;
            for sample in self.hole.iter().filter(|_| is_fillable) {
                if let Some(height_m) = heights_m.get_mut(*sample) {
                    *height_m = highest_m;
                }
            }
        }
    }

    /// Collects the hole that a sample belongs to, and gives the lowest and the highest height
    /// around; `None` where the sample is of no hole that is new, or of one that nothing is around.
    fn visit(&mut self, heights_m: &[f32], ny: usize, start: usize) -> Option<(f32, f32)> {
        self.hole.clear();
        self.take(start);
        let mut around: Option<(f32, f32)> = None;
        let mut next = 0;
        while let Some(sample) = self.hole.get(next).copied() {
            next += 1;
            for neighbour in neighbours(sample, heights_m.len(), ny) {
                match heights_m.get(neighbour).copied() {
                    Some(height_m) if is_known(height_m) => {
                        let (lowest_m, highest_m) = around.unwrap_or((height_m, height_m));
                        around = Some((lowest_m.min(height_m), highest_m.max(height_m)));
                    }
                    _ => self.take(neighbour),
                }
            }
        }
        around
    }

    fn take(&mut self, sample: usize) {
        if let Some(is_visited) = self.is_visited.get_mut(sample)
            && !*is_visited
        {
            *is_visited = true;
            self.hole.push(sample);
        }
    }

    /// Gives the greater of the hole's extents along x and y, in samples.
    fn width(&self, ny: usize) -> usize {
        let extent = |of: fn(usize, usize) -> usize| {
            let places = || self.hole.iter().map(|sample| of(*sample, ny));
            let (least, most) = (places().min(), places().max());
            least.zip(most).map_or(0, |(least, most)| most + 1 - least)
        };
        extent(|sample, ny| sample / ny).max(extent(|sample, ny| sample % ny))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::NO_POINT;

    const HOLE: f32 = NO_POINT;

    fn filled(heights_m: &[f32], ny: usize, samples: usize, level_m: f32) -> Vec<f32> {
        let mut heights_m = heights_m.to_vec();
        Holes::default().fill(&mut heights_m, ny, samples, level_m);
        heights_m
    }

    #[test]
    fn narrow_holes_among_level_samples_take_their_highest_neighbour() {
        #[rustfmt::skip]
        let map = [
            1.0, 1.0,  1.0, 1.2,
            1.0, HOLE, 1.1, HOLE,
            1.0, 1.0,  1.0, HOLE,
        ];
        #[rustfmt::skip]
        let one = [
            1.0, 1.0, 1.0, 1.2,
            1.0, 1.1, 1.1, HOLE,
            1.0, 1.0, 1.0, HOLE,
        ];
        assert_eq!(filled(&map, 4, 0, 0.25), map);
        assert_eq!(filled(&map, 4, 1, 0.25), one);
        let both = filled(&map, 4, 2, 0.25);
        assert_eq!(both.iter().filter(|height_m| **height_m == 1.2).count(), 3);
        let beside_a_step = filled(&map, 4, 2, 0.15);
        assert_eq!(beside_a_step, one);
    }

    #[test]
    fn holes_beside_a_step_stay_and_so_does_a_map_that_nothing_is_known_of() {
        let map = [2.0, HOLE, 1.0];
        assert_eq!(filled(&map, 3, 3, 0.5), map);
        assert_eq!(filled(&map, 3, 3, 1.0), [2.0, 2.0, 1.0]);
        assert_eq!(filled(&[HOLE; 6], 3, 100, 1.0), [HOLE; 6]);
    }

    #[test]
    fn samples_that_touch_at_corners_are_one_hole() {
        let map = [HOLE, 1.0, 1.0, HOLE];
        assert_eq!(filled(&map, 2, 1, 1.0), map);
        assert_eq!(filled(&map, 2, 2, 1.0), [1.0; 4]);
    }
}
