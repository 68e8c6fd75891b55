//! Settings of a dataset. Two datasets with equal settings have equal sequences.

use std::collections::{BTreeMap, BTreeSet};

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The version of the files' format; readers refuse others.
pub const FORMAT_VERSION: u32 = 2;

/// The file of a dataset's settings.
pub const SETTINGS_FILE: &str = "settings.json";

/// The file of a dataset's items.
pub(crate) const ITEMS_FILE: &str = "items.safetensors.zst";

/// Settings that a dataset is made with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The version of the files' format.
    pub format_version: u32,
    /// The version of the program that makes it.
    pub package_version: String,
    /// The digest of the catalogue, in hexadecimal.
    pub catalogue_hash: String,
    /// Number of objects of the catalogue.
    pub objects: u32,
    /// The container's grid.
    pub grid: Grid,
    /// The expert, who packs.
    pub expert: ExpertSettings,
    /// The simulated cell, as its crate describes it.
    pub cell: Value,
    /// The seed that sequences are drawn with.
    pub seed: u64,
    /// Objects in a sequence.
    pub length: u32,
    /// Whether the value of every placement is kept.
    pub has_values: bool,
    /// Number of sequences.
    pub sequences: u32,
}

/// Settings of the expert: an exhaustive search of this heuristic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpertSettings {
    /// The heuristic that placements are judged by.
    pub heuristic: Heuristic,
    /// The order in which the items of the buffer compete.
    pub order: Order,
    /// The weights of the heuristic's terms.
    pub weights: Weights,
    /// The name of the stability test.
    pub stability: String,
    /// Number of items to choose among.
    pub buffer: u32,
}

impl Settings {
    /// Checks everything that readers rely on; gives what is wrong.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let resolution = self.grid.resolution();
        let yaws = u32::try_from(resolution.yaws().count()).unwrap_or(u32::MAX);
        for (what, value, most) in [
            ("the number of objects", self.objects, 1_000_000),
            ("the number of sequences", self.sequences, 10_000_000),
            ("the length of a sequence", self.length, 100_000),
            ("the buffer", self.expert.buffer, 1000),
            ("the number of the grid's yaws", yaws, 360),
        ] {
            if !(1..=most).contains(&value) {
                return Err(format!("{what} must be 1 to {most}, but is {value}"));
            }
        }
        match Grid::new(self.grid.container(), resolution.clone()) {
            Ok(grid) if grid == self.grid => Ok(()),
            Ok(_) => Err("the grid's cells do not follow from the container's size".to_owned()),
            Err(error) => Err(error.to_string()),
        }
    }

    /// Names the settings that differ from those of `found`, with both values; `None` where all are
    /// equal.
    pub(crate) fn difference(&self, found: &Value) -> Option<String> {
        let (asked, found) = (leaves(self), leaves(found));
        let names: BTreeSet<&String> = asked.keys().chain(found.keys()).collect();
        let differing = names.into_iter().filter_map(|name| {
            let text = |of: &BTreeMap<String, String>| {
                of.get(name).map_or("absent", |text| text).to_owned()
            };
            let (there, here) = (text(&found), text(&asked));
            (there != here).then(|| format!("{name} is {there} there, {here} is asked for"))
        });
        let differing: Vec<String> = differing.collect();
        (!differing.is_empty()).then(|| differing.join("; "))
    }
}

/// Gives every setting by its path, sorted: independent of the order in which a file has them.
fn leaves(settings: &impl Serialize) -> BTreeMap<String, String> {
    let mut leaves = BTreeMap::new();
    // Only maps with keys that are no text fail, and settings have none.
    let settings = serde_json::to_value(settings).unwrap_or_default();
    collect("", &settings, &mut leaves);
    leaves
}

fn collect(path: &str, value: &Value, leaves: &mut BTreeMap<String, String>) {
    match value {
        Value::Object(entries) => {
            for (name, entry) in entries {
                let separator = if path.is_empty() { "" } else { "." };
                collect(&format!("{path}{separator}{name}"), entry, leaves);
            }
        }
        leaf => {
            leaves.insert(path.to_owned(), leaf.to_string());
        }
    }
}
