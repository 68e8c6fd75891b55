//! Training: from a dataset to a model.

mod batch;
mod checkpoint;
mod loader;
mod loss;
mod optimiser;

use std::path::Path;
use std::time::{Duration, Instant};

use ppnpack_dataset::{Dataset, Split, StepRecord};
use ppnpack_files::write_whole;
use ppnpack_model::card::{Accuracy, DataFacts, FORMAT, ModelCard, Versions};
use ppnpack_model::report::{EpochReport, TrainingEvent};
use ppnpack_model::settings::{Loss, TrainingRequest, TrainingSettings};
use ppnpack_model::weights::to_bytes;
use tch::{TchError, Tensor, no_grad};

use crate::error::NetworkError;
use crate::files::all_to_plain;
use crate::network::{Network, Parameters};
use crate::runtime;
use batch::{Batch, BatchMaker, BatchTensors};
pub use checkpoint::CHECKPOINT_FILE;
use checkpoint::{State, damaged};
use loader::{Loader, in_order, shuffled};
use loss::{loss, ranks};
use optimiser::{AdamW, learning_rate};

/// The shares `K`, in percent, that accuracy is reported for.
pub const ACCURACY_PERCENTS: [f64; 5] = [1.0, 5.0, 8.0, 10.0, 20.0];

/// The names of a training's results in its folder.
pub const MODEL_FILE: &str = "model.safetensors";

/// How often a checkpoint is written.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(60);
/// How many steps are looked at together outside of training.
const EVALUATION_BATCH: usize = 64;

/// Trains a network, or goes on training; leaves the model, its card and a checkpoint in the request's folder.
///
/// # Errors
/// [`NetworkError`] where the data or the checkpoint cannot be used, or the loss is no number.
pub fn train(
    request: &TrainingRequest,
    watch: &mut dyn FnMut(TrainingEvent),
) -> Result<ModelCard, NetworkError> {
    request.settings.architecture.validate()?;
    let device = runtime::device(request.device)?;
    tch::set_num_threads(request.threads.max(1) as i32);
    let dataset = Dataset::open(&request.dataset)?;
    if request.settings.loss == Loss::Mse && !dataset.settings().has_values {
        return Err(NetworkError::NoValues);
    }
    let data = Data::load(&dataset, &request.settings, watch)?;
    let mut training = Training::start(request, &dataset, &data, device)?;
    for report in &training.state.epochs {
        watch(TrainingEvent::Epoch(report.clone()));
    }
    while training.state.epoch < request.settings.epochs {
        let report = training.epoch(watch)?;
        watch(TrainingEvent::Epoch(report));
    }
    training.finish()
}

/// The steps that a training works on.
struct Data {
    training: Vec<StepRecord>,
    test: Vec<StepRecord>,
}

impl Data {
    fn load(
        dataset: &Dataset,
        settings: &TrainingSettings,
        watch: &mut dyn FnMut(TrainingEvent),
    ) -> Result<Self, NetworkError> {
        let watch = std::cell::RefCell::new(watch);
        let progress = |done, total| watch.borrow_mut()(TrainingEvent::Reading { done, total });
        let with_values = settings.loss == Loss::Mse;
        let load = |split| dataset.load(split, with_values, &progress);
        let mut training = load(Split::Train)?;
        if let Some(sequences) = settings.sequences {
            let mut kept: Vec<u32> = training.iter().map(|step| step.sequence).collect();
            kept.dedup();
            let limit = kept.get(sequences).copied().unwrap_or(u32::MAX);
            training.retain(|step| step.sequence < limit);
        }
        let test = load(Split::Test)?;
        for (steps, what) in [(&training, "training steps"), (&test, "test steps")] {
            if count(steps) == 0 {
                return Err(NetworkError::NoData(what));
            }
        }
        Ok(Self { training, test })
    }
}

/// Candidates with a valid placement.
fn count(steps: &[StepRecord]) -> u64 {
    let candidates = steps.iter().flat_map(|step| &step.candidates);
    candidates
        .filter(|candidate| candidate.best_value().is_finite())
        .count() as u64
}

/// A training under way.
struct Training<'a> {
    request: &'a TrainingRequest,
    data: &'a Data,
    dataset: &'a Dataset,
    device: tch::Device,
    network: Network,
    parameters: Parameters,
    optimiser: AdamW,
    state: State,
    saved: Instant,
}

impl<'a> Training<'a> {
    fn start(
        request: &'a TrainingRequest,
        dataset: &'a Dataset,
        data: &'a Data,
        device: tch::Device,
    ) -> Result<Self, NetworkError> {
        let settings = &request.settings;
        tch::manual_seed(settings.seed as i64);
        let (network, parameters) = Network::new(&settings.architecture, device)?;
        let mut optimiser = AdamW::new(&parameters, settings.weight_decay)?;
        let mut state = State {
            settings: settings.clone(),
            data_hash: dataset.hash().to_owned(),
            epoch: 0,
            batch: 0,
            updates: 0,
            loss_sum: 0.0,
            epochs: Vec::new(),
            training_s: 0.0,
        };
        let path = checkpoint::path(&request.folder);
        if path.exists() {
            if !request.resume {
                return Err(NetworkError::Unfinished { path });
            }
            state = checkpoint::load(&request.folder, &state, &parameters, &mut optimiser)?;
        }
        Ok(Self {
            request,
            data,
            dataset,
            device,
            network,
            parameters,
            optimiser,
            state,
            saved: Instant::now(),
        })
    }

    fn maker(&self) -> BatchMaker {
        BatchMaker::new(
            &self.dataset.settings().grid,
            self.dataset.items(),
            self.request.settings.architecture.stride(),
            self.request.settings.loss == Loss::Mse,
        )
    }

    /// Trains until the end of the epoch under way.
    fn epoch(&mut self, watch: &mut dyn FnMut(TrainingEvent)) -> Result<EpochReport, NetworkError> {
        let settings = &self.request.settings;
        let plans = shuffled(self.data.training.len(), settings, self.state.epoch);
        let per_epoch = plans.len() as u64;
        let total = per_epoch * settings.epochs as u64;
        let left = plans.get(self.state.batch..).unwrap_or(&[]).to_vec();
        let (mut started, began) = (Instant::now(), Instant::now());
        let maker = self.maker();
        self.network.set_training(true);
        let waited = std::thread::scope(|scope| -> Result<Duration, NetworkError> {
            let mut loader = Loader::start(scope, maker, &self.data.training, left.clone());
            for _ in &left {
                let batch = loader.next()?;
                let done = self.state.epoch as u64 * per_epoch + self.state.batch as u64;
                let rate = learning_rate(settings.learning_rate, done, total);
                self.state.loss_sum += self.learn(&batch, rate)?;
                self.state.batch += 1;
                self.state.training_s += started.elapsed().as_secs_f64();
                started = Instant::now();
                watch(TrainingEvent::Batch {
                    done: done + 1,
                    total,
                    loss: self.state.loss_sum / self.state.batch as f64,
                });
                if self.saved.elapsed() > CHECKPOINT_INTERVAL {
                    self.save()?;
                }
            }
            Ok(loader.waited())
        })?;
        let training_loss = self.state.loss_sum / (per_epoch as f64).max(1.0);
        let spent = began.elapsed().as_secs_f64().max(f64::MIN_POSITIVE);
        let (test_loss, accuracy) = self.evaluate()?;
        self.state.epoch += 1;
        self.state.batch = 0;
        self.state.loss_sum = 0.0;
        let report = EpochReport {
            epoch: self.state.epoch,
            training_loss,
            test_loss,
            accuracy,
            training_s: self.state.training_s,
            waiting_share: waited.as_secs_f64() / spent,
        };
        self.state.epochs.push(report.clone());
        self.save()?;
        Ok(report)
    }

    /// One update from one batch; gives its loss.
    fn learn(&mut self, batch: &Batch, rate: f64) -> Result<f64, NetworkError> {
        let settings = &self.request.settings;
        let tensors = batch.to(self.device)?;
        let scores = forward(&self.network, &tensors)?;
        let loss = loss(&scores, &tensors.labels, settings.loss, settings.margin)?;
        let value = loss.f_double_value(&[])?;
        if !value.is_finite() {
            return Err(self.keep_batch(&tensors)?);
        }
        loss.f_backward()?;
        self.optimiser.update(&self.parameters, rate)?;
        self.state.updates = self.optimiser.updates;
        Ok(value)
    }

    /// Keeps a batch whose loss is no number.
    fn keep_batch(&self, tensors: &BatchTensors) -> Result<NetworkError, NetworkError> {
        let kept = self.request.folder.join("bad-batch.safetensors");
        let named = tensors.named()?;
        let plain = all_to_plain(named.iter().map(|(name, tensor)| (*name, tensor)))?;
        write_whole(&kept, &to_bytes(&plain, None)?)?;
        Ok(NetworkError::LossNotFinite {
            epoch: self.state.epoch + 1,
            batch: self.state.batch,
            kept,
        })
    }

    fn save(&mut self) -> Result<(), NetworkError> {
        self.saved = Instant::now();
        let folder = &self.request.folder;
        checkpoint::save(folder, &self.state, &self.parameters, &self.optimiser)
    }

    /// How well the network does on the test split, on which it was not trained: its loss and accuracy.
    fn evaluate(&mut self) -> Result<(f64, Vec<Accuracy>), NetworkError> {
        self.network.set_training(false);
        let settings = &self.request.settings;
        let steps = &self.data.test;
        let plans = in_order(steps.len(), EVALUATION_BATCH);
        let batches = plans.len();
        let mut all_ranks: Vec<(i64, f64)> = Vec::new();
        let mut loss_sum = 0.0;
        std::thread::scope(|scope| -> Result<(), NetworkError> {
            let mut loader = Loader::start(scope, self.maker(), steps, plans);
            for _ in 0..batches {
                let batch = loader.next()?;
                no_grad(|| -> Result<(), NetworkError> {
                    let tensors = batch.to(self.device)?;
                    let scores = forward(&self.network, &tensors)?;
                    let loss = loss(&scores, &tensors.labels, settings.loss, settings.margin)?;
                    loss_sum += loss.f_double_value(&[])? * batch.len() as f64;
                    let ranks = ranks(&scores, &tensors.labels)?;
                    let possible = tensors.labels.possible;
                    all_ranks.extend(ranks.into_iter().map(|rank| (rank, possible)));
                    Ok(())
                })?;
            }
            Ok(())
        })?;
        let accuracy = ACCURACY_PERCENTS.map(|percent| accuracy(&all_ranks, percent));
        let loss = loss_sum / (steps.len() as f64).max(1.0);
        Ok((loss, accuracy.to_vec()))
    }

    /// Writes the model and its card.
    fn finish(mut self) -> Result<ModelCard, NetworkError> {
        let accuracy = match self.state.epochs.last() {
            Some(report) => report.accuracy.clone(),
            None => self.evaluate()?.1,
        };
        let bytes = to_bytes(&all_to_plain(self.parameters.tensors())?, None)?;
        let data = self.dataset.settings();
        let container = data.grid.container();
        let trained = self.parameters.trained();
        let card = ModelCard {
            format: FORMAT,
            architecture: self.request.settings.architecture.clone(),
            parameters: trained.map(|(_, tensor)| tensor.numel() as u64).sum(),
            weights_blake3: blake3::hash(&bytes).to_hex().to_string(),
            data: DataFacts {
                hash: self.dataset.hash().to_owned(),
                catalogue_hash: data.catalogue_hash.clone(),
                cell_m: data.grid.resolution().cell_m(),
                height_unit_m: data.grid.resolution().height_unit_m(),
                yaws: data.grid.resolution().yaws().count(),
                container_m: [container.x_m, container.y_m, container.z_m],
                training_candidates: count(&self.data.training),
                test_candidates: count(&self.data.test),
            },
            training: self.request.settings.clone(),
            device: self.request.device,
            training_s: self.state.training_s,
            epoch: self.state.epoch,
            accuracy,
            versions: Versions {
                ppnpack: env!("CARGO_PKG_VERSION").to_owned(),
                libtorch: runtime::LIBTORCH_VERSION.to_owned(),
            },
        };
        let model = self.request.folder.join(MODEL_FILE);
        write_card(&model.with_extension("json"), &card)?;
        write_whole(&model, &bytes)?;
        Ok(card)
    }
}

fn write_card(path: &Path, card: &ModelCard) -> Result<(), NetworkError> {
    let text = serde_json::to_vec_pretty(card).map_err(|error| damaged(path, &error))?;
    Ok(write_whole(path, &text)?)
}

/// Scores of a batch, `[N, R, L]`.
fn forward(network: &Network, batch: &BatchTensors) -> Result<Tensor, NetworkError> {
    let (steps, maps) = batch.shape;
    let containers = network.encode_containers(&batch.containers)?;
    let views = network.encode_views(&batch.views)?;
    let chosen = views.iter().map(|features| {
        let (_, channels, side, _) = features.size4()?;
        let chosen = features.f_index_select(0, &batch.slots)?;
        chosen.f_view([steps, maps, channels, side, side])
    });
    let chosen: Vec<Tensor> = chosen.collect::<Result<_, TchError>>()?;
    let resting = network.architecture().resting_heights;
    let resting = resting.then_some(&batch.resting);
    let scores = network.score(&network.fuse(&containers, &chosen)?, resting)?;
    Ok(scores.f_view_as(&batch.labels.fits)?)
}

/// The share of candidates whose rank lies within so many percent of their possible placements.
fn accuracy(ranks: &[(i64, f64)], percent: f64) -> Accuracy {
    let within = ranks
        .iter()
        .filter(|(rank, possible)| (*rank as f64) < (possible * percent / 100.0).ceil());
    let share = within.count() as f64 / (ranks.len() as f64).max(1.0);
    Accuracy { percent, share }
}
