//! What a tuning came to.

use ppnpack_chart::{Curve, Lines};
use ppnpack_cli::options::Objective;
use ppnpack_packing::objective::Weights;
use serde::Serialize;

use super::fitness::Fitness;
use super::space::named;
use crate::document;
use crate::filling::Way;
use crate::origin;
use crate::statistics::Mean;

/// All that was found.
#[derive(Debug, Serialize)]
pub(super) struct Results {
    machine: String,
    workers: usize,
    #[serde(serialize_with = "document::with_version")]
    settings: Settings,
    /// How sequences are packed, but for the weights.
    way: Way,
    start: Candidate,
    /// The best candidate so far; the start where none was better.
    best: Candidate,
    generations: Vec<Generation>,
}

/// What a tuning follows from.
#[derive(Debug, Serialize)]
pub(super) struct Settings {
    pub(super) start: Objective,
    pub(super) weights: Vec<String>,
    pub(super) first_case: u32,
    pub(super) cases: u32,
    pub(super) population: u32,
    pub(super) unsteady_limit_percent: f64,
    pub(super) seed: u64,
}

/// Weights that were tried.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Candidate {
    pub(super) weights: Weights,
    pub(super) fitness: Fitness,
}

#[derive(Debug, Serialize)]
struct Generation {
    /// From 1.
    number: usize,
    best: Candidate,
    mean_fitness_percent: f64,
    /// The step size after it, in units of the search space.
    sigma: f64,
    /// The weights where the search is after it.
    mean: Weights,
}

impl Results {
    pub(super) fn new(settings: Settings, workers: usize, way: Way, start: Candidate) -> Self {
        Self {
            machine: origin::machine(),
            workers,
            settings,
            way,
            start,
            best: start,
            generations: Vec::new(),
        }
    }

    /// Adds a generation of candidates, and where the search is after it.
    pub(super) fn add(&mut self, candidates: &[Candidate], sigma: f64, mean: Weights) {
        let fitness = |candidate: &Candidate| candidate.fitness.value_percent;
        let better =
            |&one: &&Candidate, &other: &&Candidate| fitness(one).total_cmp(&fitness(other));
        let Some(best) = candidates.iter().max_by(better).copied() else {
            return;
        };
        if fitness(&best) > fitness(&self.best) {
            self.best = best;
        }
        let generation = Generation {
            number: self.generations.len() + 1,
            best,
            mean_fitness_percent: Mean::of(candidates.iter().map(fitness)).mean,
            sigma,
            mean,
        };
        tracing::info!(
            generation = generation.number,
            best_percent = fitness(&best),
            mean_percent = generation.mean_fitness_percent,
            sigma,
            "tuned"
        );
        self.generations.push(generation);
    }

    /// The start and the best, as `experiment filling --methods` reads them.
    pub(super) fn methods(&self) -> [Way; 2] {
        let way = |name: &str, weights: Weights| {
            let mut way = self.way.clone();
            way.name = format!("{name} weights");
            way.method.weights = weights;
            way
        };
        let start = document::name_of(&self.settings.start);
        [
            way(&start, self.start.weights),
            way("tuned", self.best.weights),
        ]
    }

    /// How good the best of each generation is, and their mean.
    pub(super) fn course_chart(&self) -> Lines {
        let curve = |name: &str, fitness: fn(&Generation) -> f64| {
            let generations = self.generations.iter();
            let points = generations.map(|of| [of.number as f64, fitness(of)]);
            Curve {
                name: name.to_owned(),
                points: points.collect(),
            }
        };
        Lines {
            title: "Fitness by generation".to_owned(),
            x_label: "Generation".to_owned(),
            y_label: "Fitness (%)".to_owned(),
            curves: vec![
                curve("best", |of| of.best.fitness.value_percent),
                curve("mean", |of| of.mean_fitness_percent),
            ],
        }
    }

    /// What the best weights pack more than the start's.
    pub(super) fn answer(&self) -> String {
        let generations = self.generations.len();
        let Fitness {
            value_percent,
            difference_percent,
            unsteady_percent,
            ..
        } = &self.best.fitness;
        if *value_percent <= self.start.fitness.value_percent {
            return format!("No weights of {generations} generations are better than the start's.");
        }
        format!(
            "On the sequences that they were tuned on, the best weights pack {} than the start's; {unsteady_percent:.1} % of their \
             placements did not stay, against {:.1} %. The best of many owes something to chance: only other sequences tell.",
            difference_percent.more_or_less(2, "%"),
            self.start.fitness.unsteady_percent
        )
    }

    pub(super) fn markdown(&self) -> String {
        let mut text = self.introduction();
        text += &self.candidates();
        text += "\nThe best of many candidates owes something to chance: tuned weights must be tested on sequences 0 to 99, by \
                 `ppnpack experiment filling --methods methods.json` with the file beside this one.\n";
        text += &self.course();
        text
    }

    fn introduction(&self) -> String {
        let Settings {
            first_case,
            cases,
            population,
            unsteady_limit_percent,
            seed,
            ..
        } = &self.settings;
        let last = u64::from(*first_case) + u64::from(*cases) - 1;
        format!(
            "# Tuned weights of the objective\n\n\
             By CMA-ES on sequences {first_case} to {last} in robot conditions, with tried placements, up to {} poses and {} \
             items set aside; {population} candidates a generation, seed {seed}. *Fitness* is the mean difference of the mesh \
             volume to that with the start's weights, sequence by sequence, less 2 % for each percent of unsteady placements \
             above {unsteady_limit_percent} %. Intervals are of 95 % by Student's t. Machine: {}.\n",
            self.way.poses, self.way.set_aside, self.machine
        )
    }

    /// The start and the best.
    fn candidates(&self) -> String {
        let mut text = "\n## Start and best\n\n".to_owned();
        text += &self.head(&["weights", "fitness", "mesh volume, difference", "unsteady"]);
        let start = format!("start ({})", document::name_of(&self.settings.start));
        for (name, candidate) in [(start.as_str(), &self.start), ("best", &self.best)] {
            let Fitness {
                value_percent,
                difference_percent,
                unsteady_percent,
                unsteady,
                placed,
            } = &candidate.fitness;
            let cells = [
                name.to_owned(),
                format!("{value_percent:+.2} %"),
                format!("{} %", difference_percent.shown(2)),
                format!("{unsteady_percent:.1} % ({unsteady} of {placed})"),
            ];
            text += &row(cells.into_iter().chain(self.values(&candidate.weights)));
        }
        text
    }

    /// The generations.
    fn course(&self) -> String {
        let mut text =
            "\n## Generations\n\nThe weights are those of the search's mean.\n\n".to_owned();
        text += &self.head(&["generation", "best fitness", "mean fitness", "sigma"]);
        for generation in &self.generations {
            let cells = [
                generation.number.to_string(),
                format!("{:+.2} %", generation.best.fitness.value_percent),
                format!("{:+.2} %", generation.mean_fitness_percent),
                format!("{:.3}", generation.sigma),
            ];
            text += &row(cells.into_iter().chain(self.values(&generation.mean)));
        }
        text
    }

    /// The head of a table whose last columns are the tuned weights.
    fn head(&self, first: &[&str]) -> String {
        let first = first.iter().map(|name| (*name).to_owned());
        let names: Vec<String> = first.chain(self.settings.weights.iter().cloned()).collect();
        let rule = names.iter().map(|_| "---".to_owned());
        let rule = row(rule);
        row(names) + &rule
    }

    /// The tuned weights.
    fn values(&self, weights: &Weights) -> Vec<String> {
        let values = named(weights).unwrap_or_default();
        let shown = self.settings.weights.iter().map(|name| {
            let value = values.get(name).copied();
            value.map(|value| format!("{value:.3}")).unwrap_or_default()
        });
        shown.collect()
    }
}

fn row(cells: impl IntoIterator<Item = String>) -> String {
    let cells: Vec<String> = cells.into_iter().collect();
    format!("| {} |\n", cells.join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(weights: Weights, value_percent: f64) -> Candidate {
        Candidate {
            weights,
            fitness: Fitness {
                value_percent,
                difference_percent: Mean::default(),
                unsteady_percent: 1.0,
                unsteady: 1,
                placed: 100,
            },
        }
    }

    fn results() -> Results {
        let settings = Settings {
            start: Objective::Published,
            weights: vec!["top_height".to_owned(), "distance".to_owned()],
            first_case: 1000,
            cases: 96,
            population: 8,
            unsteady_limit_percent: 2.0,
            seed: 0,
        };
        let start = candidate(Weights::default(), 0.0);
        Results::new(settings, 1, Way::default(), start)
    }

    #[test]
    fn the_best_of_all_generations_is_kept() {
        let mut results = results();
        let dense = candidate(Weights::dense(), 3.0);
        let worse = candidate(Weights::default(), -1.0);
        results.add(&[worse, worse], 1.0, Weights::default());
        assert_eq!(results.best.weights, Weights::default());
        assert_eq!(results.best.fitness.value_percent, 0.0);
        results.add(&[worse, dense], 0.9, Weights::default());
        results.add(&[worse, worse], 0.8, Weights::default());
        assert_eq!(results.best.weights, Weights::dense());
        assert_eq!(results.generations.len(), 3);
        assert_eq!(results.generations[1].mean_fitness_percent, 1.0);
    }

    #[test]
    fn the_methods_are_those_that_filling_reads() {
        let mut results = results();
        let dense = candidate(Weights::dense(), 3.0);
        results.add(&[dense], 1.0, Weights::default());
        let text = serde_json::to_string(&results.methods()).unwrap();
        let read: Vec<Way> = serde_json::from_str(&text).unwrap();
        let names: Vec<&str> = read.iter().map(|way| way.name.as_str()).collect();
        assert_eq!(names, ["published weights", "tuned weights"]);
        assert_eq!(read[0].method.weights, Weights::default());
        assert_eq!(read[1].method.weights, Weights::dense());
    }

    #[test]
    fn the_answer_says_whether_any_weights_are_better() {
        let mut results = results();
        results.add(
            &[candidate(Weights::dense(), -1.0)],
            1.0,
            Weights::default(),
        );
        assert!(results.answer().starts_with("No weights of 1 generations"));
        results.add(&[candidate(Weights::dense(), 3.0)], 1.0, Weights::default());
        assert!(results.answer().contains("than the start's"));
        assert_eq!(
            results.course_chart().curves[0].points,
            [[1.0, -1.0], [2.0, 3.0]]
        );
    }

    #[test]
    fn every_row_of_a_table_has_its_columns() {
        let mut results = results();
        results.add(&[candidate(Weights::dense(), 3.0)], 1.0, Weights::default());
        let text = results.markdown();
        let rows: Vec<&str> = text.lines().filter(|line| line.starts_with('|')).collect();
        assert_eq!(rows.len(), 4 + 3, "{text}");
        assert!(
            rows.iter().all(|row| row.matches('|').count() == 7),
            "{text}"
        );
        assert!(text.contains("| best | +3.00 % |"), "{text}");
        assert!(text.contains("sequences 0 to 99"), "{text}");
    }
}
