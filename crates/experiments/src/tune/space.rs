//! The space that weights are searched in: logarithmic, since they are positive and what counts are their ratios.
//!
//! A coordinate `z` stands for the weight `reference * exp(0.5 z)`. The references are the published weights, and 0.2 for
//! `top_height`, which is 0 there. A search starts at its start's weights, and at the reference of a weight that is 0.

use std::collections::BTreeMap;

use nalgebra::DVector;
use ppnpack_cli::failure::{Failure, OrRun, Outcome};
use ppnpack_packing::objective::Weights;

/// The logarithm of the factor that one unit of a coordinate stands for.
const LOG_PER_UNIT: f64 = 0.5;

/// The most that a weight's logarithm is apart from its reference's: what is beyond counts as there. A factor of 148.
const MOST_LOG: f64 = 5.0;

/// The weights that are tuned, and where the search starts.
#[derive(Debug)]
pub(super) struct Space {
    start: Weights,
    axes: Vec<Axis>,
}

/// A weight that is tuned.
#[derive(Debug)]
struct Axis {
    name: String,
    reference: f64,
    /// The weight at the start.
    start: f64,
}

impl Axis {
    fn weight(&self, coordinate: f64) -> f64 {
        let log = (LOG_PER_UNIT * coordinate).clamp(-MOST_LOG, MOST_LOG);
        self.reference * log.exp()
    }

    fn coordinate(&self, weight: f64) -> f64 {
        (weight / self.reference).ln() / LOG_PER_UNIT
    }

    fn start(&self) -> f64 {
        match self.start > 0.0 {
            true => self.coordinate(self.start),
            false => 0.0,
        }
    }
}

fn references() -> Weights {
    Weights {
        top_height: 0.2,
        ..Weights::default()
    }
}

/// Weights by name.
pub(super) fn named(weights: &Weights) -> Outcome<BTreeMap<String, f64>> {
    let value = serde_json::to_value(weights).or_run()?;
    serde_json::from_value(value).or_run()
}

impl Space {
    /// The space of the weights with these names.
    pub(super) fn new(start: Weights, names: &[String]) -> Outcome<Self> {
        let (starts, references) = (named(&start)?, named(&references())?);
        let mut axes: Vec<Axis> = Vec::new();
        for name in names {
            let wrong = |why: &str| {
                let known: Vec<&str> = starts.keys().map(String::as_str).collect();
                Failure::input(format_args!(
                    "--weights: '{name}' {why}; give some of {}",
                    known.join(", ")
                ))
            };
            let (Some(start), Some(reference)) = (starts.get(name), references.get(name)) else {
                return Err(wrong("is no weight"));
            };
            if axes.iter().any(|axis| axis.name == *name) {
                return Err(wrong("is named twice"));
            }
            axes.push(Axis {
                name: name.clone(),
                reference: *reference,
                start: *start,
            });
        }
        Ok(Self { start, axes })
    }

    /// The weights that candidates are compared with.
    pub(super) fn start(&self) -> Weights {
        self.start
    }

    /// Where the search starts.
    pub(super) fn start_point(&self) -> DVector<f64> {
        DVector::from_vec(self.axes.iter().map(Axis::start).collect())
    }

    /// The weights at a point: those that are tuned, and the start's.
    pub(super) fn weights(&self, point: &DVector<f64>) -> Outcome<Weights> {
        let mut weights = named(&self.start)?;
        for (axis, coordinate) in self.axes.iter().zip(point.iter()) {
            weights.insert(axis.name.clone(), axis.weight(*coordinate));
        }
        let value = serde_json::to_value(weights).or_run()?;
        serde_json::from_value(value).or_run()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn space(start: Weights, names: &[&str]) -> Outcome<Space> {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        Space::new(start, &names)
    }

    fn assert_same(found: &Weights, expected: &Weights) {
        let expected = named(expected).unwrap();
        for (name, value) in named(found).unwrap() {
            assert!((value - expected[&name]).abs() < 1e-12 * value, "{name}");
        }
    }

    #[test]
    fn the_start_is_the_start() {
        let start = Weights::dense();
        let names = [
            "resting_height",
            "distance",
            "top_height",
            "box_share",
            "balance",
            "corner",
            "surface_volume",
            "touching_area",
        ];
        let space = space(start, &names).unwrap();
        assert_eq!(space.start(), start);
        assert_same(&space.weights(&space.start_point()).unwrap(), &start);
    }

    #[test]
    fn a_weight_of_0_starts_at_its_reference_and_the_others_stay() {
        let space = space(Weights::default(), &["top_height"]).unwrap();
        assert_eq!(space.start_point(), DVector::<f64>::zeros(1));
        let found = space.weights(&space.start_point()).unwrap();
        assert_eq!(found, references());
    }

    #[test]
    fn coordinates_and_weights_turn_into_each_other() {
        let space = space(Weights::dense(), &["distance", "top_height"]).unwrap();
        for axis in &space.axes {
            for coordinate in [-9.0, -1.0, 0.0, 0.3, 9.0] {
                let there_and_back = axis.coordinate(axis.weight(coordinate));
                assert!((there_and_back - coordinate).abs() < 1e-9);
            }
        }
        let point = DVector::from_vec(vec![2.0, -2.0]);
        let weights = space.weights(&point).unwrap();
        let e = std::f64::consts::E;
        assert!((weights.distance - 2.5 * e).abs() < 1e-12);
        assert!((weights.top_height - 0.2 / e).abs() < 1e-12);
    }

    #[test]
    fn weights_are_possible_however_far_a_point_is() {
        let space = space(Weights::default(), &["distance", "balance"]).unwrap();
        for coordinate in [-1e300, -50.0, 50.0, 1e300] {
            let weights = space.weights(&DVector::from_element(2, coordinate));
            let weights = weights.unwrap();
            weights.validate().unwrap();
            assert!(weights.distance > 0.0 && weights.balance > 0.0);
        }
    }

    #[test]
    fn unknown_and_repeated_names_are_refused() {
        let refused = |names: &[&str]| space(Weights::default(), names).unwrap_err().to_string();
        let unknown = refused(&["distance", "width"]);
        assert!(unknown.contains("'width' is no weight"), "{unknown}");
        assert!(unknown.contains("top_height"), "{unknown}");
        let twice = refused(&["distance", "distance"]);
        assert!(twice.contains("'distance' is named twice"), "{twice}");
    }
}
