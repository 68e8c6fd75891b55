//! What was learned, as a document and as methods to compare.

use std::path::Path;

use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_files::write_whole;
use ppnpack_packing::scene_value::{FIGURES, FIGURES_OF_ITEMS, SceneValue};
use serde::Serialize;

use super::ValueArguments;
use super::ridge::{Sample, explained, fit};
use crate::filling::Way;

/// In standard deviations of the figures; from 30 to 1,000 what is explained differs by less than a thousandth.
const PENALTY: f64 = 100.0;

/// What was learned.
#[derive(Debug, Serialize)]
pub(super) struct Results {
    first_case: u32,
    cases: u32,
    way: Way,
    /// Steps.
    samples: usize,
    /// The share of the variance of sequences that were held back.
    explained: f64,
    /// As before, without the figures of the surface: what a placement has no influence on.
    explained_without_surface: f64,
    coefficients: Vec<f64>,
}

impl Results {
    /// # Errors
    /// Where nothing was packed.
    pub(super) fn new(
        arguments: &ValueArguments,
        way: Way,
        sequences: &[Vec<Sample>],
    ) -> Outcome<Self> {
        let nothing = || Failure::input("nothing was packed that could be learned from");
        let all = sequences.iter().flatten();
        let linear = fit(all.clone(), 0, PENALTY).ok_or_else(nothing)?;
        let explains = |first| explained(sequences, first, PENALTY).ok_or_else(nothing);
        let mut coefficients = linear.coefficients;
        // What was packed until then is the same for all placements of a step.
        coefficients.truncate(FIGURES);
        Ok(Self {
            first_case: arguments.sequences.first,
            cases: arguments.sequences.cases,
            samples: all.count(),
            explained: explains(0)?,
            explained_without_surface: explains(FIGURES - FIGURES_OF_ITEMS)?,
            coefficients,
            way,
        })
    }

    /// The ways to compare by `experiment filling --methods`.
    pub(super) fn save_methods(&self, out: &Path) -> Outcome {
        let way = |name: &str, value: SceneValue| {
            let mut way = self.way.clone();
            name.clone_into(&mut way.name);
            way.method.scene_value = value;
            way
        };
        let learned = SceneValue {
            coefficients: self.coefficients.clone(),
            ..SceneValue::default()
        };
        let ways = [
            way("objective alone", SceneValue::off()),
            way("with the learned value", learned),
        ];
        let ways = serde_json::to_vec_pretty(&ways).or_run()?;
        write_whole(&out.join("methods.json"), &ways)?;
        Ok(())
    }

    pub(super) fn markdown(&self) -> String {
        let grid = &self.way.grid;
        let value = &self.way.method.scene_value;
        format!(
            "# Value: what a placement leaves\n\n\
             Learned from sequences {} to {} in robot conditions: cells of {} mm, {} yaws, {} set aside, poses {}, weight of the value \
             while packing {}.\n\n\
             | | |\n|---|---|\n\
             | steps | {} |\n\
             | variance explained, of sequences held back | {:.1} % |\n\
             | of that without the figures of the surface | {:.1} % |\n\n\
             `methods.json` has the coefficients: `ppnpack-experiments experiment filling --methods methods.json` says what they are worth.\n",
            self.first_case,
            self.first_case + self.cases - 1,
            1e3 * grid.cell_m,
            grid.yaws,
            self.way.set_aside,
            self.way.poses,
            value.weight,
            self.samples,
            100.0 * self.explained,
            100.0 * self.explained_without_surface,
        )
    }
}
