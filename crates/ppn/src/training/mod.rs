//! Training: from a dataset to a model.

mod batch;
mod checkpoint;
mod data;
mod evaluation;
mod loader;
mod loss;
mod optimiser;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use ppnpack_dataset::{Dataset, StepRecord};
use ppnpack_files::write_whole;
use ppnpack_model::accuracy::Question;
use ppnpack_model::card::{DataFacts, FORMAT, ModelCard, Versions};
use ppnpack_model::report::{EpochReport, Evaluation, TrainingEvent};
use ppnpack_model::settings::{Loss, TrainingRequest};
use ppnpack_model::weights::{WeightTensor, to_bytes};
use tch::{TchError, Tensor};

use crate::error::NetworkError;
use crate::files::{all_to_plain, copy_into};
use crate::network::{Network, Parameters};
use crate::runtime;
use batch::{Batch, BatchMaker, BatchTensors, Regression};
pub use checkpoint::CHECKPOINT_FILE;
use checkpoint::{State, damaged};
use data::{Data, count};
use evaluation::evaluate;
use loader::{Loader, Preparation, shuffled};
use loss::loss;
use optimiser::{AdamW, learning_rate};

/// Name of the model that a training leaves in its folder.
pub const MODEL_FILE: &str = "model.safetensors";

/// Time between checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(60);

/// Trains a network, or goes on training; leaves the model, its card and a checkpoint in the
/// request's folder. Where there is a validation split, the model has the weights of the epoch that
/// does best there; else those of the last.
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
        return Err(NetworkError::Other(
            "--loss mse needs a dataset with values: make it with `ppnpack dataset --values`"
                .to_owned(),
        ));
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
    /// The weights of the best epoch so far, where the validation split tells which that is.
    best: Option<BTreeMap<String, WeightTensor>>,
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
        let mut best = None;
        let path = checkpoint::path(&request.folder);
        if path.exists() {
            if !request.resume {
                return Err(NetworkError::Other(format!(
                    "{} is the checkpoint of a training: go on with --resume, or choose another --out",
                    path.display()
                )));
            }
            let found = checkpoint::load(&request.folder, &state, &parameters, &mut optimiser)?;
            (state, best) = found;
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
            best,
            saved: Instant::now(),
        })
    }

    fn preparation(&self) -> Preparation {
        let settings = &self.request.settings;
        let regression = Regression {
            cut_off: settings.cut_off as f32,
        };
        let maker = BatchMaker::new(
            &self.dataset.settings().grid,
            self.dataset.items(),
            settings.architecture.stride(),
            (settings.loss == Loss::Mse).then_some(regression),
        );
        Preparation::new(maker, self.device, self.request.threads)
    }

    /// Trains until the end of the epoch under way.
    fn epoch(&mut self, watch: &mut dyn FnMut(TrainingEvent)) -> Result<EpochReport, NetworkError> {
        let settings = &self.request.settings;
        let plans = shuffled(self.data.training.len(), settings, self.state.epoch);
        let per_epoch = plans.len() as u64;
        let total = per_epoch * settings.epochs as u64;
        let left = plans.get(self.state.batch..).unwrap_or(&[]).to_vec();
        let (mut started, began) = (Instant::now(), Instant::now());
        let preparation = self.preparation();
        self.network.set_training(true);
        let waited = std::thread::scope(|scope| -> Result<Duration, NetworkError> {
            let mut loader = Loader::start(scope, &preparation, &self.data.training, &left);
            for _ in &left {
                let batch = loader.next()?;
                let done = self.state.epoch as u64 * per_epoch + self.state.batch as u64;
                let peak = settings.learning_rate;
                let rate = learning_rate(settings.schedule, peak, done, total);
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
        let held_out = &self.data.validation;
        let validation = self.evaluate(!held_out.is_empty(), held_out)?;
        self.state.epoch += 1;
        self.state.batch = 0;
        self.state.loss_sum = 0.0;
        let report = EpochReport {
            epoch: self.state.epoch,
            training_loss,
            validation,
            training_s: self.state.training_s,
            waiting_share: waited.as_secs_f64() / spent,
        };
        self.state.epochs.push(report.clone());
        if report.validation.is_some() && self.state.best_epoch() == Some(self.state.epoch) {
            self.best = Some(all_to_plain(self.parameters.tensors())?);
        }
        self.save()?;
        Ok(report)
    }

    /// One update from one batch; gives its loss.
    fn learn(&mut self, batch: &Batch, rate: f64) -> Result<f64, NetworkError> {
        let settings = &self.request.settings;
        let tensors = batch.to(self.device)?;
        let scores = forward(&self.network, &tensors)?;
        let loss = loss(&scores, &tensors.labels, settings)?;
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
        Ok(NetworkError::Other(format!(
            "the loss of batch {} of epoch {} is not finite; the batch is kept in {}: try a lower --learning-rate",
            self.state.batch,
            self.state.epoch + 1,
            kept.display()
        )))
    }

    fn save(&mut self) -> Result<(), NetworkError> {
        self.saved = Instant::now();
        let folder = &self.request.folder;
        let best = self.best.as_ref();
        checkpoint::save(folder, &self.state, &self.parameters, &self.optimiser, best)
    }

    /// Evaluates the network on these steps, where they are wanted.
    fn evaluate(
        &mut self,
        is_wanted: bool,
        steps: &[StepRecord],
    ) -> Result<Option<Evaluation>, NetworkError> {
        if !is_wanted {
            return Ok(None);
        }
        let (settings, preparation) = (&self.request.settings, self.preparation());
        let network = &mut self.network;
        evaluate(network, self.device, settings, &preparation, steps).map(Some)
    }

    /// Writes the model, with the weights of the best epoch where there is one, and its card.
    fn finish(mut self) -> Result<ModelCard, NetworkError> {
        for (name, values) in self.best.iter().flatten() {
            if let Some(tensor) = self.parameters.tensors().get(name) {
                copy_into("the best epoch", name, values, tensor)?;
            }
        }
        let epoch = self.state.best_epoch().unwrap_or(self.state.epoch);
        let mut reports = self.state.epochs.iter();
        let chosen = reports.find(|report| report.epoch == epoch);
        let validation = chosen.and_then(|report| report.validation.clone());
        let test = self.evaluate(self.request.look_at_test, &self.data.test)?;
        let test = test.map(|test| test.accuracies);
        let proposed = test.as_ref().map(|test| test.of(Question::Proposed));
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
                validation_candidates: count(&self.data.validation),
                test_candidates: count(&self.data.test),
            },
            training: self.request.settings.clone(),
            device: self.request.device,
            training_s: self.state.training_s,
            epoch,
            accuracy: proposed.map(<[_]>::to_vec).unwrap_or_default(),
            validation: validation.map(|validation| validation.accuracies),
            test,
            versions: Versions {
                ppnpack: env!("CARGO_PKG_VERSION").to_owned(),
                libtorch: runtime::LIBTORCH_VERSION.to_owned(),
            },
        };
        let model = self.request.folder.join(MODEL_FILE);
        let path = model.with_extension("json");
        let text = serde_json::to_vec_pretty(&card).map_err(|error| damaged(&path, &error))?;
        write_whole(&path, &text)?;
        write_whole(&model, &bytes)?;
        Ok(card)
    }
}

/// Scores a batch, `[N, R, L]`.
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
