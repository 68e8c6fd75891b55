//! A picture of a container, held against what is believed to lie there.
//!
//! Items settle, tilt and slide, and assumed poses are off by a centimetre or two: that contradicts
//! nothing. An item whose place is empty does, unless something as large came up elsewhere: then it
//! moved. So does what came up where nothing is known to lie, such as a hand.

use crate::content::{Content, LyingSolid};
use crate::grid::Grid;
use crate::heightmap::{Heightmap, Scene, Surface};
use crate::hidden::{bounds, is_in_place};
use crate::model::raster::raise_surface;

/// A picture lower than a solid's top by this and by half of what it would fall to is one without
/// the solid, in metres.
const GONE_M: f64 = 0.02;

/// Tops less than this above what lies around and below tell nothing, in metres.
const TELLING_M: f64 = 0.025;

/// A solid is gone where the picture is without it in this share of what tells of it.
const GONE_SHARE: f64 = 0.7;

/// At least this area has to tell of a solid, in m².
const TELLING_M2: f64 = 2e-4;

/// At least this share of a solid, seen from above, has to tell of it: of an empty box the rim
/// does.
const TELLING_SHARE: f64 = 0.05;

/// Solids of which less than this share is seen from above are not looked for: what lies on them
/// says that they are there.
const OPEN_SHARE: f64 = 0.75;

/// A solid that left moved where something came up elsewhere that is this share of it.
const MOVED_SHARE: f64 = 0.3;

/// What came up elsewhere is higher than all that is within this, in metres along x and y.
const BESIDE_M: f64 = 0.015;

/// What came up elsewhere is higher by this, in metres.
const CAME_UP_M: f64 = 0.01;

/// What is foreign is higher than all that is within this, in metres along x and y.
const FOREIGN_BESIDE_M: f64 = 0.02;

/// What is foreign is higher by this, in metres.
const FOREIGN_M: f64 = 0.03;

/// What is foreign covers at least this, in m².
const FOREIGN_M2: f64 = 25e-4;

/// Contradiction between a picture and the expected content.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Contradiction {
    /// An item is not where it should be, nor anywhere else.
    #[error(
        "item {item} is not to be seen where it should lie: the picture is lower in {percent:.0} % of what shows it, by \
         {lower_m:.3} m, and nothing as large came up elsewhere: is the picture an old one, or was the item taken out?"
    )]
    Gone {
        /// Names the item.
        item: String,
        /// In how many percent of what tells of it the picture is without it.
        percent: f64,
        /// By how much the picture is lower there on average, in metres.
        lower_m: f64,
    },
    /// Something came up that is none of what is known to lie there.
    #[error(
        "{:.0} cm² came up that are higher than all that is known to lie there, by up to {higher_m:.3} m: is a hand or a \
         foreign item in the container?", area_m2 * 1e4
    )]
    Foreign {
        /// How much it covers, in m².
        area_m2: f64,
        /// How much higher it is at most, in metres.
        higher_m: f64,
    },
}

/// What pictures of a container should show. Keeps its memory between pictures.
#[derive(Debug, Clone, Default)]
pub struct Expected {
    tops: Vec<Top>,
    last: Option<Surface>,
}

/// The upper side of a solid where it lies.
#[derive(Debug, Clone)]
struct Top {
    solid: LyingSolid,
    /// The first of its samples among those of the picture.
    x: usize,
    y: usize,
    /// 0 where nothing of the solid is.
    surface: Surface,
    /// In how many samples something of it is.
    samples: usize,
}

/// The solids as a picture shows them from above.
struct Envelope {
    samples: Vec<Shown>,
    nx: usize,
    ny: usize,
}

/// What is highest in a sample, and what would be without it, in metres.
#[derive(Debug, Clone, Copy, Default)]
struct Shown {
    highest_m: f32,
    second_m: f32,
    /// Which of the solids is the highest; only where `highest_m` is above 0.
    solid: usize,
}

/// A solid whose place is empty.
struct Missing {
    solid: usize,
    percent: f64,
    lower_m: f64,
    volume_m3: f64,
}

impl Expected {
    /// Forgets the last picture that nothing contradicted: whatever is in the next one may lie
    /// there.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Says what contradicts a picture of a container in which this is believed to lie. Remembers
    /// one that nothing does.
    pub fn contradiction(
        &mut self,
        grid: &Grid,
        scene: &Scene,
        content: &Content,
    ) -> Option<Contradiction> {
        let picture = match scene.surface() {
            Some(surface) => surface.clone(),
            None => of_cells(grid, scene.heightmap())?,
        };
        self.follow(content, &picture);
        let envelope = Envelope::of(&self.tops, &picture);
        let seen = Seen {
            rim_m: grid.container().z_m as f32,
            sample_m2: picture.pitch_m().powi(2),
            picture: &picture,
        };
        let missing = self.missing(&envelope, &seen);
        let contradiction = match missing.is_empty() {
            false => self.gone(missing, &seen),
            true if content.is_partial() => None,
            true => self.foreign(&envelope, &seen),
        };
        if contradiction.is_none() {
            self.last = Some(picture);
        }
        contradiction
    }

    /// Draws the solids that came or moved.
    fn follow(&mut self, content: &Content, picture: &Surface) {
        let mut known = std::mem::take(&mut self.tops);
        for solid in content.all_solids() {
            let is_kept = |top: &Top| top.is_of(solid, picture);
            let kept = known.iter().position(is_kept);
            let kept = kept.map(|at| known.swap_remove(at));
            let top = kept.or_else(|| Top::of(solid, picture));
            self.tops.extend(top);
        }
    }

    /// The solids whose places are empty.
    fn missing(&self, envelope: &Envelope, seen: &Seen<'_>) -> Vec<Missing> {
        let mut counts = vec![(0_usize, 0_usize); self.tops.len()];
        for (sample, shown) in envelope.samples.iter().enumerate() {
            if shown.highest_m > 0.0
                && let Some((open, lower)) = counts.get_mut(shown.solid)
            {
                *open += 1;
                let height_m = seen.at(sample).unwrap_or(shown.highest_m);
                *lower += usize::from(height_m + GONE_M as f32 <= shown.highest_m);
            }
        }
        let tops = self.tops.iter().enumerate().zip(counts);
        // What is there is lower in few samples, and needs no close look.
        let is_doubtful = |top: &Top, (open, lower): (usize, usize)| {
            let samples = top.samples as f64;
            open as f64 >= OPEN_SHARE * samples
                && lower > 0
                && lower as f64 >= GONE_SHARE * TELLING_SHARE * samples
        };
        let doubtful = tops.filter(|((_, top), counts)| is_doubtful(top, *counts));
        let missing = doubtful.filter_map(|((solid, top), _)| envelope.miss(solid, top, seen));
        missing.collect()
    }

    /// The largest solid that is gone and for which nothing came up elsewhere.
    fn gone(&self, mut missing: Vec<Missing>, seen: &Seen<'_>) -> Option<Contradiction> {
        let is_missing = |index: &usize| missing.iter().any(|missing| missing.solid == *index);
        let others = self.tops.iter().enumerate();
        let others = others.filter(|(index, _)| !is_missing(index));
        let mut known_m = vec![0.0; seen.picture.heights_m().len()];
        others.for_each(|(_, top)| top.raise(&mut known_m, seen.picture.ny()));
        let known_m = seen.widened(&known_m, BESIDE_M);
        let came_up = seen.above(&known_m, CAME_UP_M);
        let mut came_up_m3 = came_up.sum_m * seen.sample_m2;
        missing.sort_by(|one, other| other.volume_m3.total_cmp(&one.volume_m3));
        let gone = missing.into_iter().find(|missing| {
            let is_gone = came_up_m3 < MOVED_SHARE * missing.volume_m3;
            came_up_m3 = (came_up_m3 - missing.volume_m3).max(0.0);
            is_gone
        })?;
        let top = self.tops.get(gone.solid)?;
        Some(Contradiction::Gone {
            item: top.solid.burden.name.to_string(),
            percent: gone.percent,
            lower_m: gone.lower_m,
        })
    }

    /// What came up since the last picture where nothing is known to lie.
    fn foreign(&self, envelope: &Envelope, seen: &Seen<'_>) -> Option<Contradiction> {
        let last = self.last.as_ref();
        let last = last.filter(|last| last.has_size_of(seen.picture))?;
        let both = envelope.samples.iter().zip(last.heights_m());
        let known_m = both.map(|(shown, last_m)| shown.highest_m.max(*last_m));
        let known_m: Vec<f32> = known_m.collect();
        let is_foreign = |above: &Above| above.count as f64 * seen.sample_m2 >= FOREIGN_M2;
        // As a rule there is nothing: then nothing has to be widened.
        if !is_foreign(&seen.above(&known_m, FOREIGN_M)) {
            return None;
        }
        let above = seen.above(&seen.widened(&known_m, FOREIGN_BESIDE_M), FOREIGN_M);
        is_foreign(&above).then_some(Contradiction::Foreign {
            area_m2: above.count as f64 * seen.sample_m2,
            higher_m: f64::from(above.most_m),
        })
    }
}

impl Top {
    /// The top of a solid as far as it is above the samples of a picture; `None` where nothing is.
    fn of(solid: &LyingSolid, picture: &Surface) -> Option<Self> {
        let bounds = bounds(solid)?;
        let pitch_m = picture.pitch_m();
        let along = |axis: usize, count: usize| {
            // Casts saturate.
            let first = (bounds.lowest[axis] / pitch_m).floor().max(0.0) as usize;
            let end = (bounds.highest[axis] / pitch_m).ceil().max(0.0) as usize;
            (first, end.min(count).saturating_sub(first))
        };
        let ((x, nx), (y, ny)) = (along(0, picture.nx()), along(1, picture.ny()));
        if nx == 0 || ny == 0 {
            return None;
        }
        let mut surface = Surface::from_metres(nx, ny, pitch_m, vec![0.0; nx * ny]).ok()?;
        let mut pose = solid.container_from_item;
        pose.translation.vector.x -= x as f64 * pitch_m;
        pose.translation.vector.y -= y as f64 * pitch_m;
        raise_surface(&solid.model.mesh, &pose, &mut surface);
        let heights_m = surface.heights_m().iter();
        Some(Self {
            samples: heights_m.filter(|height_m| **height_m > 0.0).count(),
            solid: solid.clone(),
            x,
            y,
            surface,
        })
    }

    /// Whether it is that of a solid in such a picture.
    fn is_of(&self, solid: &LyingSolid, picture: &Surface) -> bool {
        self.surface.pitch_m() == picture.pitch_m()
            && self.solid.burden.name == solid.burden.name
            && is_in_place(&self.solid, solid)
    }

    /// Its samples by their numbers in a picture with so many along y, with their heights in
    /// metres.
    fn samples(&self, ny: usize) -> impl Iterator<Item = (usize, f32)> {
        let rows = self.surface.heights_m().chunks_exact(self.surface.ny());
        rows.enumerate().flat_map(move |(row, heights_m)| {
            let first = (self.x + row) * ny + self.y;
            let samples = heights_m.iter().copied().enumerate();
            let samples = samples.filter(|(_, height_m)| *height_m > 0.0);
            samples.map(move |(sample, height_m)| (first + sample, height_m))
        })
    }

    /// Raises the samples of a picture, with so many along y, to it.
    fn raise(&self, heights_m: &mut [f32], ny: usize) {
        for (sample, height_m) in self.samples(ny) {
            if let Some(known_m) = heights_m.get_mut(sample) {
                *known_m = known_m.max(height_m);
            }
        }
    }
}

impl Envelope {
    fn of(tops: &[Top], picture: &Surface) -> Self {
        let (nx, ny) = (picture.nx(), picture.ny());
        let mut samples = vec![Shown::default(); nx * ny];
        for (solid, top) in tops.iter().enumerate() {
            for (sample, height_m) in top.samples(ny) {
                let Some(shown) = samples.get_mut(sample) else {
                    continue;
                };
                if height_m > shown.highest_m {
                    *shown = Shown {
                        highest_m: height_m,
                        second_m: shown.highest_m,
                        solid,
                    };
                } else {
                    shown.second_m = shown.second_m.max(height_m);
                }
            }
        }
        Self { samples, nx, ny }
    }

    /// How high a picture without a solid would be in a sample or beside it, in metres.
    fn without(&self, solid: usize, sample: usize) -> f32 {
        let (x, y) = (sample / self.ny, sample % self.ny);
        let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let xs = around(x, self.nx);
        let near = xs.flat_map(|x| around(y, self.ny).map(move |y| x * self.ny + y));
        let shown = near.filter_map(|near| self.samples.get(near));
        let heights_m = shown.map(|shown| match shown.solid == solid {
            true => shown.second_m,
            false => shown.highest_m,
        });
        heights_m.fold(0.0, f32::max)
    }

    /// The solid where its place is empty. What tells of it are seen samples in which it is the
    /// highest, well above what else lies in and beside them.
    fn miss(&self, solid: usize, top: &Top, seen: &Seen<'_>) -> Option<Missing> {
        let (mut telling, mut gone, mut lower_m) = (0_usize, 0_usize, 0.0);
        for (sample, top_m) in top.samples(self.ny) {
            let shown = self.samples.get(sample)?;
            let Some(height_m) = seen.at(sample).filter(|_| shown.solid == solid) else {
                continue;
            };
            let falls_m = f64::from(top_m - self.without(solid, sample));
            if falls_m < TELLING_M {
                continue;
            }
            telling += 1;
            // An edge may be in the next sample of the picture.
            let shown_m = seen.picture.highest_around(sample);
            if f64::from(top_m - shown_m) > GONE_M.max(0.5 * falls_m) {
                gone += 1;
                lower_m += f64::from(top_m - height_m);
            }
        }
        let share = gone as f64 / telling.max(1) as f64;
        let is_told = telling as f64 * seen.sample_m2 >= TELLING_M2
            && telling as f64 >= TELLING_SHARE * top.samples as f64;
        (is_told && share >= GONE_SHARE).then_some(Missing {
            solid,
            percent: 100.0 * share,
            lower_m: lower_m / gone as f64,
            volume_m3: lower_m * seen.sample_m2,
        })
    }
}

/// What was seen in a picture.
struct Seen<'a> {
    picture: &'a Surface,
    rim_m: f32,
    sample_m2: f64,
}

/// The samples that are higher than what is known.
struct Above {
    count: usize,
    /// By how much they are altogether, in metres.
    sum_m: f64,
    most_m: f32,
}

impl Seen<'_> {
    /// The height of a sample in metres, where it was seen: what is higher than the rim may stand
    /// for what was not.
    fn at(&self, sample: usize) -> Option<f32> {
        let (held_m, height_m) = self.picture.at(sample);
        (held_m == height_m && height_m <= self.rim_m).then_some(height_m)
    }

    /// What is higher by more than this, in metres.
    fn above(&self, known_m: &[f32], by_m: f64) -> Above {
        let mut above = Above {
            count: 0,
            sum_m: 0.0,
            most_m: 0.0,
        };
        for (sample, known_m) in known_m.iter().enumerate() {
            let Some(height_m) = self.at(sample) else {
                continue;
            };
            let higher_m = height_m - known_m;
            if f64::from(higher_m) > by_m {
                above.count += 1;
                above.sum_m += f64::from(higher_m);
                above.most_m = above.most_m.max(higher_m);
            }
        }
        above
    }

    /// Gives each sample the greatest height of those within this along x and y, in metres.
    fn widened(&self, heights_m: &[f32], within_m: f64) -> Vec<f32> {
        let (nx, ny) = (self.picture.nx(), self.picture.ny());
        let reach = (within_m / self.picture.pitch_m()).ceil() as usize;
        let greatest = |heights_m: &[f32], sample: usize, at: usize, count: usize, step: usize| {
            let first = sample - (at - at.saturating_sub(reach)) * step;
            let count = (at + reach + 1).min(count) - at.saturating_sub(reach);
            let near = heights_m.iter().skip(first).step_by(step).take(count);
            near.copied().fold(0.0, f32::max)
        };
        let all = 0..heights_m.len();
        let rows: Vec<f32> = all
            .clone()
            .map(|sample| greatest(heights_m, sample, sample % ny, ny, 1))
            .collect();
        all.map(|sample| greatest(&rows, sample, sample / ny, nx, ny))
            .collect()
    }
}

/// A heightmap as a picture of one sample a cell.
fn of_cells(grid: &Grid, heightmap: &Heightmap) -> Option<Surface> {
    let resolution = grid.resolution();
    let unit_m = resolution.height_unit_m();
    let heights_m = heightmap.heights().iter();
    let heights_m = heights_m.map(|units| (f64::from(*units) * unit_m) as f32);
    let (nx, ny) = (heightmap.nx(), heightmap.ny());
    Surface::from_metres(nx, ny, resolution.cell_m(), heights_m.collect()).ok()
}
