//! The sides of the opening: lines through the inner faces of walls, or along the rim's inner edge.

use nalgebra::{Point2, Vector2};

use super::levelled::Levelled;
use super::opening::Opening;
use super::plane::median;

/// Length of the strips that a side is looked at in, about, in metres.
const STRIP_M: f64 = 0.015;

/// Minimum length of the opening's corners, which are left out, in metres: the next wall begins
/// there.
pub(super) const CORNER_M: f64 = 0.012;

/// Height of a wall's lowest and uppermost part, which are left out, in metres: floor and rim begin
/// there.
const WALL_END_M: f64 = 0.015;

/// Minimum distance of the sensor in front of a wall whose inner face it sees, in metres.
const IN_FRONT_M: f64 = 0.02;

/// Minimum number of points of a wall's strip.
const LEAST_STRIP_POINTS: usize = 4;

/// Minimum share of a side's strips that is seen.
const LEAST_STRIPS_SHARE: f64 = 0.5;

/// Maximum distance of the rim's points from its height, in metres; points seen through the opening
/// lie over twice as deep.
const RIM_BAND_M: f64 = 0.004;

/// Maximum residual that counts, in medians of the residuals.
const TUKEY_MEDIANS: f64 = 6.0;

/// Minimum of the residuals' median, in metres.
const SMALL_M: f64 = 0.0002;

/// A side of the opening, looked at from the middle: points have a place along it and across it,
/// outwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) outward: Vector2<f64>,
    /// The beginning and the end of the side, along it.
    pub(super) ends_m: [f64; 2],
    /// The place of the side across it, about.
    pub(super) about_m: f64,
    /// Length of the corners at its ends, which are left out, in metres.
    pub(super) corner_m: f64,
}

/// A line along a side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// The place across, at the middle of its strips.
    pub(super) across_m: f64,
    /// The middle of its strips, along.
    pub(super) along_m: f64,
    /// Growth of across with along.
    pub(super) slope: f64,
    /// The weighted scatter of its strips along, in square metres: what the slope is worth.
    pub(super) weight_m2: f64,
    /// 90 % of its strips are within this, in metres.
    pub(super) bow_m: f64,
}

/// The inner face of a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wall {
    pub(super) line: Line,
    /// The root mean square distance of its points from the line, in metres.
    pub(super) rms_m: f64,
    /// Distance of its upper half from its lower, outwards, in metres.
    pub(super) lean_m: f64,
    /// Distance outwards by which it rises, per metre of height.
    pub(super) lean: f64,
}

/// A side as far as it is seen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub(super) frame: Frame,
    pub(super) wall: Option<Wall>,
    pub(super) edge: Option<Line>,
}

impl Side {
    /// Looks for a side within `reach_m` of where it is about.
    pub(super) fn look(levelled: &Levelled, opening: &Opening, frame: Frame, reach_m: f64) -> Self {
        Self {
            frame,
            wall: frame.wall(levelled, opening, reach_m),
            edge: frame.edge(levelled, opening, reach_m),
        }
    }

    /// Gives the line of the side: that of its wall where it is seen.
    pub(super) fn line(&self) -> Option<Line> {
        self.wall.map(|wall| wall.line).or(self.edge)
    }
}

impl Line {
    /// Gives the place across of the line turned parallel to the side's frame about the frame's
    /// origin.
    pub(super) fn straightened_m(&self, slope: f64) -> f64 {
        self.across_m - slope * self.along_m
    }

    /// Fits a line through the strips of `all` that are seen, with less weight for those that stand
    /// out; `None` of too few.
    fn through(strips: &[Strip], all: usize) -> Option<Self> {
        if strips.len() < 3 || (strips.len() as f64) < LEAST_STRIPS_SHARE * all as f64 {
            return None;
        }
        let mut slopes = Vec::with_capacity(strips.len() * strips.len() / 2);
        for (index, one) in strips.iter().enumerate() {
            let others = strips.iter().skip(index + 1);
            let slope = |two: &Strip| (two.across_m - one.across_m) / (two.along_m - one.along_m);
            slopes.extend(others.map(slope));
        }
        let mut slope = median(&mut slopes);
        let offset_m = |strip: &Strip, slope: f64| strip.across_m - slope * strip.along_m;
        let offsets = strips.iter().map(|strip| offset_m(strip, slope));
        let mut middle_m = median(&mut offsets.collect::<Vec<_>>());
        let residuals = |slope: f64, middle_m: f64| -> Vec<f64> {
            let offsets = strips.iter().map(move |strip| offset_m(strip, slope));
            offsets.map(move |offset_m| offset_m - middle_m).collect()
        };
        let mut line = None;
        for _ in 0..5 {
            let residuals = residuals(slope, middle_m);
            let mut sizes: Vec<f64> = residuals.iter().copied().map(f64::abs).collect();
            let end_m = TUKEY_MEDIANS * median(&mut sizes).max(SMALL_M);
            let shares = residuals.iter().map(|residual| (residual / end_m).powi(2));
            let weights: Vec<f64> = shares.map(|share| (1.0 - share).max(0.0).powi(2)).collect();
            let fitted = Self::weighted(strips, &weights)?;
            slope = fitted.slope;
            middle_m = fitted.across_m - slope * fitted.along_m;
            line = Some(fitted);
        }
        let mut sizes = residuals(slope, middle_m);
        sizes
            .iter_mut()
            .for_each(|residual| *residual = residual.abs());
        sizes.sort_by(f64::total_cmp);
        let bow_m = sizes.get((sizes.len() - 1) * 9 / 10).copied();
        line.map(|line| Self {
            bow_m: bow_m.unwrap_or(0.0),
            ..line
        })
    }

    fn weighted(strips: &[Strip], weights: &[f64]) -> Option<Self> {
        let sum: f64 = weights.iter().sum();
        let mean = |of: fn(&Strip) -> f64| {
            let both = strips.iter().zip(weights);
            both.map(|(strip, weight)| weight * of(strip)).sum::<f64>() / sum
        };
        let (along_m, across_m) = (mean(|strip| strip.along_m), mean(|strip| strip.across_m));
        let (mut of_both, mut weight_m2) = (0.0, 0.0);
        for (strip, weight) in strips.iter().zip(weights) {
            let from_mean_m = strip.along_m - along_m;
            of_both += weight * from_mean_m * (strip.across_m - across_m);
            weight_m2 += weight * from_mean_m * from_mean_m;
        }
        (sum > 0.0 && weight_m2 > 0.0).then(|| Self {
            across_m,
            along_m,
            slope: of_both / weight_m2,
            weight_m2,
            bow_m: 0.0,
        })
    }
}

/// The place of a side in a strip.
#[derive(Debug, Clone, Copy)]
struct Strip {
    along_m: f64,
    across_m: f64,
}

impl Frame {
    /// Counts the strips of the side.
    pub(super) fn strips(&self) -> usize {
        ((self.ends_m[1] - self.ends_m[0] - 2.0 * self.corner_m) / STRIP_M).clamp(4.0, 100.0)
            as usize
    }

    /// Gives the strip that a place along the side is in.
    pub(super) fn strip(&self, along_m: f64) -> Option<usize> {
        let [from_m, to_m] = [
            self.ends_m[0] + self.corner_m,
            self.ends_m[1] - self.corner_m,
        ];
        let share = (along_m - from_m) / (to_m - from_m);
        let is_inside = (0.0..1.0).contains(&share);
        is_inside.then(|| (share * self.strips() as f64) as usize)
    }

    /// Gives the strip that a place is in, with its place along and across; `None` farther than
    /// `reach_m` from the side.
    fn in_strip(&self, place: &Point2<f64>, reach_m: f64) -> Option<(usize, [f64; 2])> {
        let [along_m, across_m] = self.along_and_across(place);
        if (across_m - self.about_m).abs() > reach_m {
            return None;
        }
        Some((self.strip(along_m)?, [along_m, across_m]))
    }

    /// Gives a place along, a quarter turn counter-clockwise from outwards, and across.
    pub(super) fn along_and_across(&self, place: &Point2<f64>) -> [f64; 2] {
        let along = Vector2::new(-self.outward.y, self.outward.x);
        [along, self.outward].map(|direction| direction.dot(&place.coords))
    }

    /// Finds the inner face of the wall, where enough of it is seen. Its points are moved to where
    /// it meets the rim, by what walls are taken to lean.
    fn wall(&self, levelled: &Levelled, opening: &Opening, reach_m: f64) -> Option<Wall> {
        // The sensor is above the origin.
        if self.about_m < IN_FRONT_M {
            return None;
        }
        let heights_m = opening.floor_m + WALL_END_M..opening.rim_m - WALL_END_M;
        let middle_m = (opening.floor_m + opening.rim_m) / 2.0;
        let mut strips: Vec<Vec<[f64; 2]>> = vec![Vec::new(); self.strips()];
        let mut halves = [Vec::new(), Vec::new()];
        for point in &levelled.points_m {
            if !heights_m.contains(&point.z) {
                continue;
            }
            let at_rim = point.xy() + self.outward * opening.lean * (opening.rim_m - point.z);
            if let Some((strip, place)) = self.in_strip(&at_rim, reach_m)
                && let Some(strip) = strips.get_mut(strip)
            {
                strip.push(place);
                let [lower, upper] = &mut halves;
                let half = if point.z > middle_m { upper } else { lower };
                half.push(place);
            }
        }
        let seen = strips
            .iter()
            .filter(|strip| strip.len() >= LEAST_STRIP_POINTS);
        let seen = seen.map(|strip| {
            let mut across_m: Vec<f64> = strip.iter().map(|[_, across_m]| *across_m).collect();
            Strip {
                along_m: mean_along_m(strip),
                across_m: median(&mut across_m),
            }
        });
        let seen: Vec<Strip> = seen.collect();
        let line = Line::through(&seen, strips.len())?;
        let residual = |[along_m, across_m]: &[f64; 2]| {
            across_m - line.across_m - line.slope * (along_m - line.along_m)
        };
        let points = || strips.iter().flatten().map(residual);
        let squares = points().map(|residual_m| residual_m * residual_m);
        let [lower_m, upper_m] = halves.map(|half| {
            let enough = half.len() >= 10 * LEAST_STRIP_POINTS;
            enough.then(|| median(&mut half.iter().map(residual).collect::<Vec<_>>()))
        });
        let lean_m = lower_m.zip(upper_m);
        let lean_m = lean_m.map_or(0.0, |(lower_m, upper_m)| upper_m - lower_m);
        Some(Wall {
            line,
            rms_m: (squares.sum::<f64>() / points().count() as f64).sqrt(),
            lean_m,
            lean: opening.lean + 2.0 * lean_m / (heights_m.end - heights_m.start),
        })
    }

    /// Finds the rim's inner edge: between the innermost points of the rim and the outermost rays
    /// that pass through the opening. Noise moves points along their rays, which does not matter
    /// here.
    fn edge(&self, levelled: &Levelled, opening: &Opening, reach_m: f64) -> Option<Line> {
        let count = self.strips();
        let mut rims = vec![Vec::new(); count];
        let mut through = vec![Vec::new(); count];
        for point in &levelled.points_m {
            // The place where its ray meets the rim's height.
            let on_rim = point.xy() * (opening.rim_m / point.z);
            let Some((strip, on_rim)) = self.in_strip(&on_rim, reach_m) else {
                continue;
            };
            let below_m = opening.rim_m - point.z;
            let strips = if below_m.abs() <= RIM_BAND_M {
                &mut rims
            } else if below_m > 2.0 * RIM_BAND_M {
                &mut through
            } else {
                continue;
            };
            if let Some(strip) = strips.get_mut(strip) {
                strip.push(on_rim);
            }
        }
        let strips = rims.iter().zip(&through);
        let seen: Vec<Strip> = strips
            .filter_map(|(rim, through)| edge_strip(rim, through, opening.spacing_m))
            .collect();
        Line::through(&seen, count)
    }
}

/// Gives the mean of places along a side.
fn mean_along_m(places: &[[f64; 2]]) -> f64 {
    places.iter().map(|[along_m, _]| along_m).sum::<f64>() / places.len() as f64
}

/// Gives the place of the edge in a strip. Where the innermost points of the rim and the outermost
/// rays through the opening are no neighbours, since the wall between them was not measured, the
/// rim's points tell alone.
fn edge_strip(rim: &[[f64; 2]], through: &[[f64; 2]], spacing_m: f64) -> Option<Strip> {
    let across = |[_, across_m]: &[f64; 2]| *across_m;
    let inner_m = rim.iter().map(across).fold(f64::INFINITY, f64::min);
    let passing = through
        .iter()
        .map(across)
        .filter(|across_m| *across_m < inner_m);
    let gap_m = inner_m - passing.fold(f64::NEG_INFINITY, f64::max);
    let are_neighbours = gap_m <= 2.0 * spacing_m;
    let across_m = inner_m
        - if are_neighbours {
            gap_m / 2.0
        } else {
            spacing_m / 4.0
        };
    across_m.is_finite().then(|| Strip {
        along_m: mean_along_m(rim),
        across_m,
    })
}
