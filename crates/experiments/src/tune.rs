//! `ppnpack experiment tune`: weights of the objective, tuned by CMA-ES on sequences that no table uses.
//!
//! Each packed sequence is kept when it is finished, and the candidates follow from the seed and the kept runs alone. So a
//! tuning that was killed goes through what is kept without packing it again, and goes on where it was.

mod arguments;
mod cma;
mod fitness;
mod results;
mod space;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::options::Conditions;
use ppnpack_cli::sequence::SequenceFile;
use ppnpack_files::write_whole;
use ppnpack_packing::objective::Weights;

use crate::cases::{Case, cases};
use crate::document::{self, Answer, Document};
use crate::filling::apart::Apart;
use crate::filling::{self, Run, Way};
use crate::runs::Runs;
use crate::workers;
pub(crate) use arguments::TuneArguments;
use cma::Cma;
use fitness::Fitness;
use results::{Candidate, Results};
use space::Space;

/// The step size at the start: a factor of 1.65 on a weight.
const START_SIGMA: f64 = 1.0;

/// What all candidates share.
struct Tuning<'a> {
    arguments: &'a TuneArguments,
    /// How sequences are packed, but for the weights.
    way: Way,
    catalogue: Catalogue,
    cases: Vec<Case>,
    kept: Runs,
}

pub(crate) fn run(arguments: &TuneArguments) -> Outcome {
    arguments.validate()?;
    let space = Space::new(arguments.start.weights(), &arguments.weights)?;
    let results = Tuning::new(arguments)?.search(&space)?;
    let methods = serde_json::to_vec_pretty(&results.methods()).or_run()?;
    write_whole(&arguments.out.join("methods.json"), &methods)?;
    document(arguments, &results)?.publish(&arguments.out, arguments.json)
}

/// What was found until now; its chart is drawn.
fn document<'a>(
    arguments: &'a TuneArguments,
    results: &'a Results,
) -> Outcome<Document<'a, Results>> {
    document::figure(
        &arguments.out,
        "tune",
        results.course_chart().to_svg([760, 420]),
    )?;
    Ok(Document {
        name: "tune",
        answer: Answer {
            question: "Does tuning the objective's weights help?",
            text: results.answer(),
            picture: "tune.svg".to_owned(),
        },
        results,
        asked: arguments,
        measured: &["best", "generations"],
        markdown: results.markdown(),
    })
}

impl<'a> Tuning<'a> {
    fn new(arguments: &'a TuneArguments) -> Outcome<Self> {
        let way = Way {
            grid: arguments.grid.settings(Conditions::Robot),
            poses: arguments.catalogue.settings().poses,
            set_aside: arguments.set_aside,
            ..Way::default()
        };
        let resolution = way.grid.resolution().or_input()?;
        let catalogue = arguments.catalogue.load(&resolution)?;
        let sequences = SequenceFile::read(&arguments.sequences, &catalogue)?;
        let cases = cases(&sequences, arguments.first, arguments.cases)?;
        let folder = arguments.runs.folder(&arguments.out);
        let kept = Runs::new(&folder, &(catalogue.content_hash(), Apart::default()))?;
        Ok(Self {
            arguments,
            way,
            catalogue,
            cases,
            kept,
        })
    }

    /// Tries generation after generation; writes what is found after each.
    fn search(&self, space: &Space) -> Outcome<Results> {
        let arguments = self.arguments;
        let start = self.pack_all(&[space.start()])?.concat();
        let settings = arguments.settings();
        let first = self.candidate(space.start(), &start, &start);
        let mut results = Results::new(settings, arguments.workers, self.way.clone(), first);
        let population = arguments.population as usize;
        let mut cma = Cma::new(space.start_point(), START_SIGMA, population, arguments.seed);
        for _ in 0..arguments.generations {
            let points = cma.ask();
            let weights = points.iter().map(|point| space.weights(point));
            let weights = weights.collect::<Outcome<Vec<Weights>>>()?;
            let candidates = self.judge(&weights, &start)?;
            let loss = |candidate: &Candidate| -candidate.fitness.value_percent;
            let losses: Vec<f64> = candidates.iter().map(loss).collect();
            cma.tell(&points, &losses);
            results.add(&candidates, cma.sigma(), space.weights(cma.mean())?);
            document(arguments, &results)?.save(&arguments.out)?;
        }
        Ok(results)
    }

    /// How good weights are, compared with what the start came to.
    fn judge(&self, weights: &[Weights], start: &[Run]) -> Outcome<Vec<Candidate>> {
        let packed = self.pack_all(weights)?;
        let candidates = weights.iter().zip(&packed);
        let candidates =
            candidates.map(|(weights, packed)| self.candidate(*weights, packed, start));
        Ok(candidates.collect())
    }

    fn candidate(&self, weights: Weights, packed: &[Run], start: &[Run]) -> Candidate {
        Candidate {
            weights,
            fitness: Fitness::of(packed, start, self.arguments.unsteady_limit),
        }
    }

    /// Packs all sequences with all of these weights; gives what they came to by weights, then sequence.
    fn pack_all(&self, weights: &[Weights]) -> Outcome<Vec<Vec<Run>>> {
        let with = |weights: &Weights| {
            let mut way = self.way.clone();
            way.method.weights = *weights;
            way
        };
        let ways: Vec<Way> = weights.iter().map(with).collect();
        let jobs: Vec<(&Way, &Case)> = ways
            .iter()
            .flat_map(|way| self.cases.iter().map(move |case| (way, case)))
            .collect();
        let pack = |(way, case): &(&Way, &Case)| self.pack(way, case);
        let packed = workers::map("Packing", &jobs, self.arguments.workers, pack)?;
        let of_ways = packed.chunks(self.cases.len());
        Ok(of_ways.map(<[Run]>::to_vec).collect())
    }

    fn pack(&self, way: &Way, case: &Case) -> Outcome<Run> {
        filling::pack_kept(&self.kept, way, &self.catalogue, case, &Apart::default())
    }
}
