//! Which settings of two runs differ.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

/// Longer values are cut for people.
const MOST_CHARACTERS: usize = 60;

/// A setting that differs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Difference {
    /// Where it is in the settings of `summary.json`, parts joined by dots.
    pub(crate) setting: String,
    /// What it is in each; null in one that has none.
    pub(crate) a: Value,
    pub(crate) b: Value,
}

/// The settings that differ, in the order of their names.
pub(super) fn differences(a: &Value, b: &Value) -> Vec<Difference> {
    let [mut all_a, mut all_b] = [BTreeMap::new(), BTreeMap::new()];
    flatten(String::new(), a, &mut all_a);
    flatten(String::new(), b, &mut all_b);
    let mut names: Vec<&String> = all_a.keys().chain(all_b.keys()).collect();
    names.sort();
    names.dedup();
    let of = |all: &BTreeMap<String, &Value>, name: &String| all.get(name).copied().cloned();
    let pairs = names.into_iter().map(|name| Difference {
        setting: name.clone(),
        a: of(&all_a, name).unwrap_or_default(),
        b: of(&all_b, name).unwrap_or_default(),
    });
    pairs.filter(|pair| pair.a != pair.b).collect()
}

/// All values that are no objects, by their path.
fn flatten<'a>(path: String, value: &'a Value, all: &mut BTreeMap<String, &'a Value>) {
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(format!("{path}{dot}{name}"), field, all);
            }
        }
        value => {
            all.insert(path, value);
        }
    }
}

/// A value for people; long ones are cut.
pub(super) fn shown(value: &Value) -> String {
    let text = match value {
        Value::Null => "none".to_owned(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    match text.char_indices().nth(MOST_CHARACTERS) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or(&text)),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_what_differs_is_named_with_its_path() {
        let a = json!({"grid": {"cell_m": 0.01, "yaws": [0, 1]}, "poses": 1, "only": "here"});
        assert!(differences(&a, &a).is_empty());
        let b = json!({"grid": {"cell_m": 0.005, "yaws": [0, 1]}, "poses": 1});
        let found = differences(&a, &b);
        let found: Vec<_> = found.iter().map(|found| found.setting.as_str()).collect();
        assert_eq!(found, ["grid.cell_m", "only"]);
    }

    #[test]
    fn long_values_are_cut_between_characters() {
        let long = shown(&Value::String("ä".repeat(200)));
        assert_eq!(long.chars().count(), MOST_CHARACTERS + 1);
        assert_eq!(shown(&Value::Null), "none");
    }
}
