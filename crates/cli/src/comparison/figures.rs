//! The figures of two runs, with their differences.

use serde::Serialize;
use serde_json::Value;

/// A figure of `summary.json`, how it is called and shown.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kind {
    name: &'static str,
    pointer: &'static str,
    unit: &'static str,
    /// From the unit of `summary.json` to the one that is shown.
    scale: f64,
    decimals: usize,
}

const UTILISATION: &str = "/utilisation";

/// In the order in which they matter.
const KINDS: [Kind; 14] = [
    kind("Items packed", "/packed/items", "", 1.0, 0),
    kind("Container filled (meshes)", UTILISATION, "%", 100.0, 2),
    kind("Volume of the meshes", "/packed/meshes_m3", "cm³", 1e6, 0),
    kind("Items placed", "/items_placed", "", 1.0, 0),
    kind("Unsteady when placed", "/items_unsteady", "", 1.0, 0),
    kind("Fallen out", "/items_fallen_out", "", 1.0, 0),
    kind(
        "Compactness by the floor (meshes)",
        "/mesh_floor_compactness",
        "%",
        100.0,
        2,
    ),
    kind(
        "Compactness by the floor (voxels)",
        "/floor_compactness",
        "%",
        100.0,
        2,
    ),
    kind(
        "Compactness by the bounding box (voxels)",
        "/box_compactness",
        "%",
        100.0,
        2,
    ),
    kind("Height", "/height_m", "cm", 100.0, 1),
    kind("Decision, mean", "/decision_s/mean", "ms", 1e3, 2),
    kind("Decision, longest", "/decision_s/max", "ms", 1e3, 2),
    kind("Whole run", "/took_s", "s", 1.0, 2),
    kind("Arm cycle, mean", "/arm/cycle_s/mean", "s", 1.0, 2),
];

const fn kind(
    name: &'static str,
    pointer: &'static str,
    unit: &'static str,
    scale: f64,
    decimals: usize,
) -> Kind {
    Kind {
        name,
        pointer,
        unit,
        scale,
        decimals,
    }
}

/// A figure in both runs, in the unit of `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Figure {
    /// Where it is in `summary.json`, as a JSON pointer.
    pointer: &'static str,
    name: &'static str,
    /// What it is in each; absent in one that has none.
    a: Option<f64>,
    b: Option<f64>,
    /// B less A, where both have it.
    pub(super) difference: Option<f64>,
    #[serde(skip)]
    kind: Kind,
}

/// The figures that at least one of the runs has.
pub(super) fn figures(a: &Value, b: &Value) -> Vec<Figure> {
    let figures = KINDS.into_iter().map(|kind| {
        let of = |summary: &Value| summary.pointer(kind.pointer).and_then(Value::as_f64);
        let (a, b) = (of(a), of(b));
        Figure {
            pointer: kind.pointer,
            name: kind.name,
            a,
            b,
            difference: a.zip(b).map(|(a, b)| b - a),
            kind,
        }
    });
    let some = figures.filter(|figure| figure.a.is_some() || figure.b.is_some());
    some.collect()
}

impl Figure {
    /// Whether it is how full the container is.
    pub(super) fn is_filling(&self) -> bool {
        self.pointer == UTILISATION
    }

    /// Its name, with the unit of what is shown.
    pub(super) fn head(&self) -> String {
        match self.kind.unit {
            "" => self.name.to_owned(),
            unit => format!("{}, in {unit}", self.name),
        }
    }

    /// A value of it in the unit that is shown.
    pub(super) fn shown(&self, value: f64) -> String {
        format!("{:.*}", self.kind.decimals, value * self.kind.scale)
    }

    /// What it is in A and in B.
    pub(super) fn values(&self) -> [String; 2] {
        [self.a, self.b].map(|value| {
            let shown = value.map(|value| self.shown(value));
            shown.unwrap_or_else(|| "none".to_owned())
        })
    }

    /// How much more it is in B, with its sign.
    pub(super) fn change(&self) -> String {
        let Some(difference) = self.difference else {
            return String::new();
        };
        let shown = self.shown(difference.abs());
        let is_zero = shown.chars().all(|digit| matches!(digit, '0' | '.'));
        match difference > 0.0 {
            _ if is_zero => shown,
            true => format!("+{shown}"),
            false => format!("−{shown}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figures_are_shown_with_their_difference_and_left_out_where_none_has_them() {
        let a = json!({"packed": {"items": 10}, "utilisation": 0.25, "took_s": 1.0});
        let b = json!({"packed": {"items": 12}, "utilisation": 0.2, "took_s": 1.001,
            "decision": 3.0});
        let all = figures(&a, &b);
        let shown = all.iter().map(|figure| (figure.head(), figure.change()));
        let shown: Vec<(String, String)> = shown.collect();
        let expected = [
            ("Items packed", "+2"),
            ("Container filled (meshes), in %", "−5.00"),
            ("Whole run, in s", "0.00"),
            ("Greatest load, in N", ""),
        ];
        let expected = expected.map(|(head, change)| (head.to_owned(), change.to_owned()));
        assert_eq!(shown, expected);
        let load = all.last().map(Figure::values);
        assert_eq!(load, Some(["none".to_owned(), "3.0".to_owned()]));
    }
}
