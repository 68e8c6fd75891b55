//! Preparing batches on threads of their own, in a fixed order.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::Scope;
use std::time::{Duration, Instant};

use ppnpack_dataset::StepRecord;
use ppnpack_model::settings::TrainingSettings;
use rand::RngExt;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::batch::{Batch, BatchMaker};
use crate::error::NetworkError;
use crate::symmetry::Symmetry;

/// Maximum number of batches of each thread that wait to be used.
const AHEAD: usize = 2;

/// The steps that make up a batch, and the symmetry in which they are shown.
#[derive(Debug, Clone)]
pub(crate) struct BatchPlan {
    pub(crate) steps: Vec<usize>,
    pub(crate) symmetry: Symmetry,
}

/// Plans the batches of an epoch: a random order that the seed and the epoch decide.
pub(crate) fn shuffled(steps: usize, settings: &TrainingSettings, epoch: usize) -> Vec<BatchPlan> {
    let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
    random.set_stream(epoch as u64 + 1);
    let mut order: Vec<usize> = (0..steps).collect();
    order.shuffle(&mut random);
    let mut symmetry = || match settings.augment {
        true => Symmetry::of(random.random_range(0..Symmetry::COUNT)),
        false => Symmetry::default(),
    };
    plans(&order, settings.batch, &mut symmetry)
}

/// Plans the batches of a pass in order, as the data has it.
pub(crate) fn in_order(steps: usize, batch: usize) -> Vec<BatchPlan> {
    let order: Vec<usize> = (0..steps).collect();
    plans(&order, batch, &mut Symmetry::default)
}

fn plans(order: &[usize], batch: usize, symmetry: &mut dyn FnMut() -> Symmetry) -> Vec<BatchPlan> {
    let plans = order.chunks(batch.max(1)).map(|steps| BatchPlan {
        steps: steps.to_vec(),
        symmetry: symmetry(),
    });
    plans.collect()
}

/// The maker of batches, and its threads.
#[derive(Debug, Clone)]
pub(crate) struct Preparation {
    pub(crate) maker: BatchMaker,
    threads: usize,
}

impl Preparation {
    /// Prepares on one thread where the processor computes the network as well; on all `threads`
    /// where a device does, which takes batches faster than one thread makes them.
    pub(crate) fn new(maker: BatchMaker, device: tch::Device, threads: usize) -> Self {
        let threads = match device {
            tch::Device::Cuda(_) => threads.max(1),
            _ => 1,
        };
        Self { maker, threads }
    }
}

/// Batches as they become ready, in the order of their plans.
#[derive(Debug)]
pub(crate) struct Loader {
    /// Batches of each thread; they take turns.
    batches: Vec<Receiver<Batch>>,
    /// Number of batches given.
    given: usize,
    waited: Duration,
}

impl Loader {
    /// Starts preparing; stops when it is dropped.
    pub(crate) fn start<'scope>(
        scope: &'scope Scope<'scope, '_>,
        preparation: &Preparation,
        steps: &'scope [StepRecord],
        plans: &[BatchPlan],
    ) -> Self {
        let threads = preparation.threads;
        let batches = (0..threads).map(|first| {
            let (sender, batches) = sync_channel(AHEAD);
            let plans = plans.iter().skip(first).step_by(threads).cloned();
            let plans: Vec<BatchPlan> = plans.collect();
            let mut maker = preparation.maker.clone();
            scope.spawn(move || {
                for plan in plans {
                    let chosen = plan.steps.iter().filter_map(|index| steps.get(*index));
                    let chosen: Vec<_> = chosen.collect();
                    if sender.send(maker.make(&chosen, plan.symmetry)).is_err() {
                        break;
                    }
                }
            });
            batches
        });
        Self {
            batches: batches.collect(),
            given: 0,
            waited: Duration::ZERO,
        }
    }

    pub(crate) fn next(&mut self) -> Result<Batch, NetworkError> {
        let started = Instant::now();
        let turn = self.given % self.batches.len().max(1);
        let batch = self
            .batches
            .get(turn)
            .and_then(|batches| batches.recv().ok());
        let stopped = || "the thread that prepares batches stopped".to_owned();
        let batch = batch.ok_or_else(|| NetworkError::Other(stopped()))?;
        self.given += 1;
        self.waited += started.elapsed();
        Ok(batch)
    }

    /// Gives the time spent on waiting for batches.
    pub(crate) fn waited(&self) -> Duration {
        self.waited
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::grid::Grid;

    use super::*;

    #[test]
    fn any_number_of_threads_gives_the_batches_in_the_order_of_their_plans() {
        let grid = Grid::reference();
        let step = |sequence| StepRecord {
            sequence,
            step: 0,
            heightmap: vec![0; grid.nx() * grid.ny()],
            candidates: Vec::new(),
        };
        let steps: Vec<StepRecord> = (0..23).map(step).collect();
        let settings = TrainingSettings {
            batch: 4,
            ..TrainingSettings::default()
        };
        let plans = shuffled(steps.len(), &settings, 0);
        // The steps have no candidates: the sequence of each stands for it.
        let of_plan = |plan: &BatchPlan| plan.steps.iter().map(|step| *step as u32).collect();
        let expected: Vec<Vec<u32>> = plans.iter().map(of_plan).collect();
        for (device, threads, used) in [
            (tch::Device::Cpu, 5, 1),
            (tch::Device::Cuda(0), 0, 1),
            (tch::Device::Cuda(0), 3, 3),
            (tch::Device::Cuda(0), 50, 50),
        ] {
            let maker = BatchMaker::new(&grid, &[], 16, None);
            let preparation = Preparation::new(maker, device, threads);
            assert_eq!(preparation.threads, used);
            let given = std::thread::scope(|scope| {
                let mut loader = Loader::start(scope, &preparation, &steps, &plans);
                let batches = plans.iter().map(|_| loader.next().unwrap());
                batches.map(|batch| batch.sequences).collect::<Vec<_>>()
            });
            assert_eq!(given, expected, "{threads} threads");
        }
    }
}
