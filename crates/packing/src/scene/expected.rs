//! A picture of a container, held against what is believed to lie there.
//!
//! Items settle, tilt and slide, and assumed poses are off by a centimetre or two: that contradicts
//! nothing. An item whose place is empty does, unless something as large came up elsewhere: then it
//! moved. So does what came up where nothing is known to lie, such as a hand.

use crate::kernel::grid::Grid;
use crate::kernel::heightmap::{Heightmap, Surface};
use crate::scene::Scene;
use crate::scene::content::{Content, LyingSolid};
use crate::scene::hidden::{bounds, is_in_place};
use crate::scene::model::raster::raise_surface;

/// Minimum depth of a picture without a solid below its top; half of its fall, too; in metres.
const GONE_M: f64 = 0.02;

/// Minimum height of a top above what lies around and below, to tell anything, in metres.
const TELLING_M: f64 = 0.025;

/// Minimum share, of what tells of a solid that is gone, in which the picture is without it.
const GONE_SHARE: f64 = 0.7;

/// Minimum area that has to tell of a solid, in m².
const TELLING_M2: f64 = 2e-4;

/// Minimum share of a solid, seen from above, that has to tell of it: of an empty box the rim does.
const TELLING_SHARE: f64 = 0.05;

/// Minimum open share of a solid: below it, what lies on it says that it is there.
const OPEN_SHARE: f64 = 0.75;

/// Minimum volume that came up elsewhere, as a share of a solid that moved.
const MOVED_SHARE: f64 = 0.3;

/// Reach along x and y, and minimum height above all within it, of what came up, in metres.
const CAME_UP_M: [f64; 2] = [0.015, 0.01];

/// Reach along x and y, and minimum height above all within it, of what is foreign, in metres.
const FOREIGN_M: [f64; 2] = [0.02, 0.03];

/// Minimum area of what is foreign, in m².
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
        /// Name of the item.
        item: String,
        /// Share of what tells of it in which the picture is without it, in percent.
        percent: f64,
        /// Mean depth of the picture below it there, in metres.
        lower_m: f64,
    },
    /// Something came up that is none of what is known to lie there.
    #[error(
        "{:.0} cm² came up that are higher than all that is known to lie there, by up to {higher_m:.3} m: is a hand or a \
         foreign item in the container?", area_m2 * 1e4
    )]
    Foreign {
        /// Area that it covers, in m².
        area_m2: f64,
        /// Maximum height above what is known, in metres.
        higher_m: f64,
    },
}

/// Expected pictures of a container. Keeps its memory between pictures.
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
    /// Height 0 where nothing of the solid is.
    surface: Surface,
}

/// The highest solid in a sample, and the height without it, in metres.
#[derive(Debug, Clone, Copy, Default)]
struct Shown {
    highest_m: f32,
    second_m: f32,
    /// Index of the highest solid; only where `highest_m` is above 0.
    solid: usize,
}

/// A picture, beside the tops that it should show.
struct Comparison<'a> {
    picture: &'a Surface,
    rim_m: f32,
    sample_m2: f64,
    shown: Vec<Shown>,
}

struct Missing {
    solid: usize,
    percent: f64,
    lower_m: f64,
    volume_m3: f64,
}

impl Expected {
    /// Forgets the last uncontradicted picture: whatever is in the next one may lie there.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Holds a picture of a container against its content, and remembers it. Gives the content with
    /// something unknown in it where the picture shows more, such as what lay there before.
    ///
    /// # Errors
    /// [`Contradiction`] where both cannot be.
    pub fn compare(
        &mut self,
        grid: &Grid,
        scene: &Scene,
        content: Content,
    ) -> Result<Content, Contradiction> {
        let surface = scene.surface().cloned();
        let Some(picture) = surface.or_else(|| of_cells(grid, scene.heightmap())) else {
            return Ok(content);
        };
        self.follow(&content, &picture);
        let comparison = Comparison::new(&self.tops, &picture, grid);
        let tops = self.tops.iter().enumerate();
        let missing = tops.filter_map(|(solid, top)| comparison.miss(solid, top));
        let missing: Vec<Missing> = missing.collect();
        let contradiction = match missing.is_empty() {
            false => self.gone(missing, &comparison),
            true if content.is_partial() => None,
            true => comparison.foreign(self.last.as_ref()),
        };
        if let Some(contradiction) = contradiction {
            return Err(contradiction);
        }
        let shows_more = !content.is_partial() && comparison.shows_more();
        self.last = Some(picture);
        Ok(match shows_more {
            true => content.with_unknown(),
            false => content,
        })
    }

    /// Draws the solids that came or moved.
    fn follow(&mut self, content: &Content, picture: &Surface) {
        let mut known = std::mem::take(&mut self.tops);
        for solid in content.all_solids() {
            let kept = known.iter().position(|top| top.is_of(solid, picture));
            let kept = kept.map(|at| known.swap_remove(at));
            let top = kept.or_else(|| Top::of(solid, picture));
            self.tops.extend(top);
        }
    }

    /// Finds the largest solid that is gone and for which nothing came up elsewhere.
    fn gone(
        &self,
        mut missing: Vec<Missing>,
        comparison: &Comparison<'_>,
    ) -> Option<Contradiction> {
        let ny = comparison.picture.ny();
        let mut known_m = vec![0.0_f32; comparison.shown.len()];
        for (index, top) in self.tops.iter().enumerate() {
            if !missing.iter().any(|missing| missing.solid == index) {
                for (sample, height_m) in top.samples(ny) {
                    if let Some(known_m) = known_m.get_mut(sample) {
                        *known_m = known_m.max(height_m);
                    }
                }
            }
        }
        let [reach_m, least_m] = CAME_UP_M;
        let came_up_m = comparison.above(&comparison.widened(&known_m, reach_m), least_m);
        let came_up_m = came_up_m.into_iter().map(f64::from);
        let mut came_up_m3 = came_up_m.sum::<f64>() * comparison.sample_m2;
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
}

impl Top {
    /// Draws a solid as far as it is above the samples of a picture; `None` where nothing is.
    fn of(solid: &LyingSolid, picture: &Surface) -> Option<Self> {
        let pitch_m = picture.pitch_m();
        let [xs, ys] = bounds(solid)?.squares(pitch_m, [picture.nx(), picture.ny()]);
        if xs.is_empty() || ys.is_empty() {
            return None;
        }
        let (nx, ny) = (xs.len(), ys.len());
        let mut surface = Surface::from_metres(nx, ny, pitch_m, vec![0.0; nx * ny]).ok()?;
        let mut pose = solid.container_from_item;
        pose.translation.vector.x -= xs.start as f64 * pitch_m;
        pose.translation.vector.y -= ys.start as f64 * pitch_m;
        raise_surface(&solid.model.mesh, &pose, &mut surface);
        Some(Self {
            solid: solid.clone(),
            x: xs.start,
            y: ys.start,
            surface,
        })
    }

    /// Whether it is that of a solid in such a picture.
    fn is_of(&self, solid: &LyingSolid, picture: &Surface) -> bool {
        self.surface.pitch_m() == picture.pitch_m()
            && self.solid.burden.name == solid.burden.name
            && is_in_place(&self.solid, solid)
    }

    /// Gives its samples by their numbers in a picture with `ny` along y, with heights in metres.
    fn samples(&self, ny: usize) -> impl Iterator<Item = (usize, f32)> {
        let rows = self.surface.heights_m().chunks_exact(self.surface.ny());
        rows.enumerate().flat_map(move |(row, heights_m)| {
            let first = (self.x + row) * ny + self.y;
            let samples = heights_m.iter().copied().enumerate();
            let samples = samples.filter(|(_, height_m)| *height_m > 0.0);
            samples.map(move |(sample, height_m)| (first + sample, height_m))
        })
    }
}

impl<'a> Comparison<'a> {
    fn new(tops: &[Top], picture: &'a Surface, grid: &Grid) -> Self {
        let empty_m = grid.inside_m(picture.pitch_m(), [picture.nx(), picture.ny()]);
        let empty = empty_m.map(|height_m| Shown {
            highest_m: height_m,
            second_m: height_m,
            ..Shown::default()
        });
        let mut shown: Vec<Shown> = empty.collect();
        for (solid, top) in tops.iter().enumerate() {
            for (sample, height_m) in top.samples(picture.ny()) {
                match shown.get_mut(sample) {
                    Some(shown) if height_m > shown.highest_m => {
                        *shown = Shown {
                            highest_m: height_m,
                            second_m: shown.highest_m,
                            solid,
                        };
                    }
                    Some(shown) => shown.second_m = shown.second_m.max(height_m),
                    None => {}
                }
            }
        }
        Self {
            picture,
            rim_m: grid.container().z_m as f32,
            sample_m2: picture.pitch_m().powi(2),
            shown,
        }
    }

    /// Gives the height of a sample in metres, where seen: above the rim it may not have been.
    fn seen(&self, sample: usize) -> Option<f32> {
        let (held_m, height_m) = self.picture.at(sample);
        (held_m == height_m && height_m <= self.rim_m).then_some(height_m)
    }

    /// Gives the greatest height without a solid in a sample and beside it, in metres.
    fn without(&self, solid: usize, sample: usize) -> f32 {
        let (nx, ny) = (self.picture.nx(), self.picture.ny());
        let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let xs = around(sample / ny, nx);
        let near = xs.flat_map(|x| around(sample % ny, ny).map(move |y| x * ny + y));
        let shown = near.filter_map(|near| self.shown.get(near));
        let heights_m = shown.map(|shown| match shown.solid == solid {
            true => shown.second_m,
            false => shown.highest_m,
        });
        heights_m.fold(0.0, f32::max)
    }

    /// Misses a solid where its place is empty. What tells of it are seen samples in which it is
    /// the highest, well above what else lies in and beside them.
    fn miss(&self, solid: usize, top: &Top) -> Option<Missing> {
        let samples = || top.samples(self.picture.ny());
        let is_highest = |sample: usize| {
            let shown = self.shown.get(sample);
            shown.is_some_and(|shown| shown.solid == solid)
        };
        let open = || samples().filter(move |(sample, _)| is_highest(*sample));
        let count = samples().count() as f64;
        // What is there is lower nowhere, and needs no close look.
        let is_lower = |(sample, top_m): (usize, f32)| {
            let height_m = self.seen(sample);
            height_m.is_some_and(|height_m| height_m + GONE_M as f32 <= top_m)
        };
        if (open().count() as f64) < OPEN_SHARE * count || !open().any(is_lower) {
            return None;
        }
        let (mut telling, mut gone, mut lower_m) = (0_usize, 0_usize, 0.0);
        for (sample, top_m) in open() {
            let falls_m = f64::from(top_m - self.without(solid, sample));
            let Some(height_m) = self.seen(sample).filter(|_| falls_m >= TELLING_M) else {
                continue;
            };
            telling += 1;
            // An edge may be in the next sample of the picture.
            let shown_m = self.picture.highest_around(sample);
            if f64::from(top_m - shown_m) > GONE_M.max(0.5 * falls_m) {
                gone += 1;
                lower_m += f64::from(top_m - height_m);
            }
        }
        let share = gone as f64 / telling.max(1) as f64;
        let is_told = telling as f64 * self.sample_m2 >= TELLING_M2
            && telling as f64 >= TELLING_SHARE * count;
        (is_told && share >= GONE_SHARE).then_some(Missing {
            solid,
            percent: 100.0 * share,
            lower_m: lower_m / gone as f64,
            volume_m3: lower_m * self.sample_m2,
        })
    }

    /// Finds what came up since the last picture where nothing is known to lie.
    fn foreign(&self, last: Option<&Surface>) -> Option<Contradiction> {
        let last = last.filter(|last| last.has_size_of(self.picture))?;
        let both = self.shown.iter().zip(last.heights_m());
        let known_m = both.map(|(shown, last_m)| shown.highest_m.max(*last_m));
        self.higher_than(&known_m.collect::<Vec<f32>>())
    }

    /// Says whether something lies there beside the known solids.
    fn shows_more(&self) -> bool {
        let known_m = self.shown.iter().map(|shown| shown.highest_m);
        self.higher_than(&known_m.collect::<Vec<f32>>()).is_some()
    }

    /// Finds what is higher than all that is known to lie there.
    fn higher_than(&self, known_m: &[f32]) -> Option<Contradiction> {
        let area_m2 = |above_m: &[f32]| above_m.len() as f64 * self.sample_m2;
        let [reach_m, least_m] = FOREIGN_M;
        // As a rule there is nothing: then nothing has to be widened.
        if area_m2(&self.above(known_m, least_m)) < FOREIGN_M2 {
            return None;
        }
        let above_m = self.above(&self.widened(known_m, reach_m), least_m);
        let area_m2 = area_m2(&above_m);
        (area_m2 >= FOREIGN_M2).then(|| Contradiction::Foreign {
            area_m2,
            higher_m: f64::from(above_m.into_iter().fold(0.0, f32::max)),
        })
    }

    /// Gives by how much seen samples are higher, where it is more than `by_m`, in metres.
    fn above(&self, known_m: &[f32], by_m: f64) -> Vec<f32> {
        let known_m = known_m.iter().enumerate();
        let higher_m = known_m.filter_map(|(sample, known_m)| Some(self.seen(sample)? - known_m));
        higher_m.filter(|it| f64::from(*it) > by_m).collect()
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
        let rows = all.clone();
        let rows = rows.map(|sample| greatest(heights_m, sample, sample % ny, ny, 1));
        let rows: Vec<f32> = rows.collect();
        let both = all.map(|sample| greatest(&rows, sample, sample / ny, nx, ny));
        both.collect()
    }
}

fn of_cells(grid: &Grid, heightmap: &Heightmap) -> Option<Surface> {
    let resolution = grid.resolution();
    let unit_m = resolution.height_unit_m();
    let heights_m = heightmap.heights().iter();
    let heights_m = heights_m.map(|units| (f64::from(*units) * unit_m) as f32);
    let (nx, ny) = (heightmap.nx(), heightmap.ny());
    Surface::from_metres(nx, ny, resolution.cell_m(), heights_m.collect()).ok()
}
