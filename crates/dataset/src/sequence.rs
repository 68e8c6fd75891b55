//! The steps of a sequence as arrays.
//!
//! | array | shape | |
//! |---|---|---|
//! | `heightmaps` | steps, nx, ny | the container before the step, in units |
//! | `objects` | steps, buffer | the buffer's objects; 2³² - 1 where there is none |
//! | `least` | steps, buffer, yaws | the least value of a valid placement; infinite where none is valid |
//! | `optima` | count, 5 | the placements of that value: step, place in the buffer, yaw, x, y |
//! | `above` | count | with values: of each candidate and yaw by how much each placement, row-major, is above the candidate's least value |

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::proposals::possible_count;
use safetensors::{Dtype, SafeTensors};

use crate::arrays::{Arrays, MAX_BYTES, numbers, read};
use crate::error::DatasetError;
use crate::record::{CandidateRecord, Corner, SequenceRecord, StepRecord, YawOptima};
use crate::settings::Settings;
use crate::validate;
use crate::values::Values;

/// Stands for no object.
const NONE: u32 = u32::MAX;

/// Settings and items, which all sequences of a dataset have in common.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub(crate) settings: Settings,
    pub(crate) items: Vec<Arc<Item>>,
}

impl Layout {
    /// Gives the number of candidates, and of yaws.
    fn sizes(&self) -> (usize, usize) {
        let yaws = self.settings.grid.resolution().yaws().count();
        (self.settings.expert.buffer as usize, yaws)
    }

    /// Gives the most bytes that a sequence may have.
    fn most_bytes(&self) -> u64 {
        let ((buffer, yaws), grid) = (self.sizes(), &self.settings.grid);
        let cells = (grid.nx() * grid.ny()) as u64;
        // An optimum takes 20 bytes, a value 2.
        let candidate = 4 + yaws as u64 * (8 + 22 * cells);
        let step = (buffer as u64)
            .saturating_mul(candidate)
            .saturating_add(2 * cells);
        let steps = step.saturating_mul(self.settings.length.into());
        steps.saturating_add(4096).min(MAX_BYTES)
    }

    /// Counts the values of the candidates of these steps.
    fn value_count(&self, steps: &[StepRecord]) -> u64 {
        let candidates = steps.iter().flat_map(|step| &step.candidates);
        let items = candidates.filter_map(|found| self.items.get(found.object as usize));
        let counts = items.map(|item| possible_count(&self.settings.grid, item));
        counts.sum()
    }

    /// Packs a sequence; or gives what is wrong with it.
    pub(crate) fn arrays(&self, record: &SequenceRecord) -> Result<Arrays, String> {
        let steps = &record.steps;
        for (index, step) in steps.iter().enumerate() {
            validate::step(&self.settings, &self.items, record.sequence, index, step)?;
        }
        let ((buffer, yaws), grid) = (self.sizes(), &self.settings.grid);
        let count = steps.len();
        let places = move || (0..count).flat_map(move |step| (0..buffer).map(move |at| (step, at)));
        let all_yaws = move || places().flat_map(move |at| (0..yaws).map(move |yaw| (at, yaw)));
        let candidate = |(step, at): (usize, usize)| steps.get(step)?.candidates.get(at);
        let yaw = |at, yaw: usize| candidate(at).and_then(|found| found.yaws.get(yaw));
        let heights = steps.iter().flat_map(|step| &step.heightmap);
        let objects = places().map(|at| candidate(at).map_or(NONE, |found| found.object));
        let least =
            all_yaws().map(|(at, index)| yaw(at, index).map_or(f64::INFINITY, |it| it.value));
        let optima = all_yaws().flat_map(|(at, index)| {
            let corners = yaw(at, index).into_iter().flat_map(|it| &it.placements);
            let (step, place) = (at.0 as u32, at.1 as u32);
            corners.flat_map(move |corner| {
                [step, place, index as u32, corner.x.into(), corner.y.into()]
            })
        });
        let optima: Vec<u32> = optima.collect();

        let mut arrays = Arrays::default();
        let shape = vec![count, grid.nx(), grid.ny()];
        let heights = heights.map(|height| height.to_le_bytes());
        arrays.add("heightmaps", Dtype::I16, shape, heights);
        let objects = objects.map(u32::to_le_bytes);
        arrays.add("objects", Dtype::U32, vec![count, buffer], objects);
        let shape = vec![count, buffer, yaws];
        arrays.add("least", Dtype::F64, shape, least.map(f64::to_le_bytes));
        let shape = vec![optima.len() / 5, 5];
        let optima = optima.into_iter().map(u32::to_le_bytes);
        arrays.add("optima", Dtype::U32, shape, optima);
        if self.settings.has_values {
            let candidates = steps.iter().flat_map(|step| &step.candidates);
            let values = candidates.filter_map(|found| found.values.as_ref());
            let above: Vec<u16> = values.flat_map(Values::steps).collect();
            if above.len() as u64 != self.value_count(steps) {
                return Err("its values are not those of its candidates' placements".to_owned());
            }
            let shape = vec![above.len()];
            let above = above.into_iter().map(u16::to_le_bytes);
            arrays.add("above", Dtype::U16, shape, above);
        }
        Ok(arrays)
    }

    /// Reads the file of a sequence.
    pub(crate) fn read(
        &self,
        folder: &Path,
        sequence: u32,
        with_values: bool,
    ) -> Result<Vec<StepRecord>, DatasetError> {
        read(
            &sequence_path(folder, sequence),
            self.most_bytes(),
            |arrays| self.steps(arrays, sequence, with_values),
        )
    }

    /// Reads the steps of a sequence, checked; or gives what is wrong. Values are read where they
    /// are wanted and there are any.
    fn steps(
        &self,
        arrays: &SafeTensors<'_>,
        sequence: u32,
        with_values: bool,
    ) -> Result<Vec<StepRecord>, String> {
        let heights = numbers(arrays, "heightmaps", Dtype::I16, i16::from_le_bytes)?;
        let objects = numbers(arrays, "objects", Dtype::U32, u32::from_le_bytes)?;
        let least = numbers(arrays, "least", Dtype::F64, f64::from_le_bytes)?;
        let optima = numbers(arrays, "optima", Dtype::U32, u32::from_le_bytes)?;
        let ((buffer, yaws), grid) = (self.sizes(), &self.settings.grid);
        let (cells, count) = (grid.nx() * grid.ny(), objects.len() / buffer);
        let lengths = [heights.len(), objects.len(), least.len()];
        if lengths != [cells, buffer, buffer * yaws].map(|each| count * each) {
            return Err(format!(
                "its {count} steps have arrays of {lengths:?} numbers"
            ));
        }
        let each = heights
            .chunks_exact(cells)
            .zip(objects.chunks_exact(buffer));
        let each = each.zip(least.chunks_exact(buffer * yaws));
        let steps = (0..).zip(each).map(|(step, ((heights, objects), least))| {
            let candidates = objects.iter().zip(least.chunks_exact(yaws));
            let candidates = candidates.filter(|(object, _)| **object != NONE);
            StepRecord {
                sequence,
                step,
                heightmap: heights.to_vec(),
                candidates: candidates.map(candidate).collect(),
            }
        });
        let mut steps: Vec<StepRecord> = steps.collect();
        for row in optima.chunks(5) {
            enter(&mut steps, row).ok_or("an optimum is of no candidate")?;
        }
        for (index, step) in steps.iter().enumerate() {
            validate::step(&self.settings, &self.items, sequence, index, step)?;
        }
        if with_values && self.settings.has_values {
            self.enter_values(arrays, &mut steps)?;
        }
        Ok(steps)
    }

    fn enter_values(
        &self,
        arrays: &SafeTensors<'_>,
        steps: &mut [StepRecord],
    ) -> Result<(), String> {
        let above = numbers(arrays, "above", Dtype::U16, u16::from_le_bytes)?;
        let (found, expected) = (above.len() as u64, self.value_count(steps));
        if found != expected {
            return Err(format!("it has {found} values instead of {expected}"));
        }
        let mut above = above.into_iter();
        for candidate in steps.iter_mut().flat_map(|step| &mut step.candidates) {
            let best = candidate.best_value();
            let item = self.items.get(candidate.object as usize);
            candidate.values =
                item.map(|item| Values::from_steps(&self.settings.grid, item, best, &mut above));
        }
        Ok(())
    }
}

/// Names the file of a sequence.
pub(crate) fn sequence_path(folder: &Path, sequence: u32) -> PathBuf {
    folder.join(format!("sequence-{sequence:05}.safetensors.zst"))
}

/// Makes a candidate whose optima are still to be entered.
fn candidate((object, least): (&u32, &[f64])) -> CandidateRecord {
    let yaws = least.iter().map(|value| YawOptima {
        value: *value,
        placements: Vec::new(),
    });
    CandidateRecord {
        object: *object,
        yaws: yaws.collect(),
        values: None,
    }
}

/// Enters an optimum where it belongs; `None` where that is nowhere.
fn enter(steps: &mut [StepRecord], row: &[u32]) -> Option<()> {
    let &[step, place, yaw, x, y] = row else {
        return None;
    };
    let step = steps.get_mut(step as usize)?;
    let candidate = step.candidates.get_mut(place as usize)?;
    let optima = candidate.yaws.get_mut(yaw as usize)?;
    optima.placements.push(Corner {
        x: x.try_into().ok()?,
        y: y.try_into().ok()?,
    });
    Some(())
}
