//! How good a network is that was trained before.

use std::cell::RefCell;

use ppnpack_dataset::{Dataset, Split};
use ppnpack_model::accuracy::Accuracies;
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Loss, MeasurementRequest, TrainingSettings};
use ppnpack_model::weights::Model;

use super::batch::BatchMaker;
use super::data::count;
use super::evaluation::evaluate;
use super::loader::Preparation;
use crate::error::NetworkError;
use crate::files::network_of;
use crate::runtime;

/// How often a model has the optimum among its best-scored placements, on the test split of a dataset.
///
/// # Errors
/// [`NetworkError`] where the data or the model cannot be used.
pub fn measure(
    model: &Model,
    request: &MeasurementRequest,
    watch: &mut dyn FnMut(TrainingEvent),
) -> Result<Accuracies, NetworkError> {
    let device = runtime::device(request.device)?;
    tch::set_num_threads(request.threads.max(1) as i32);
    let mut network = network_of(model, device)?;
    let dataset = Dataset::open(&request.dataset)?;
    let watch = RefCell::new(watch);
    let progress = |done, total| watch.borrow_mut()(TrainingEvent::Reading { done, total });
    let steps = dataset.load(Split::Test, false, &progress)?;
    if count(&steps) == 0 {
        return Err(NetworkError::NoData("test steps"));
    }
    let stride = model.card().architecture.stride();
    let maker = BatchMaker::new(&dataset.settings().grid, dataset.items(), stride, None);
    let preparation = Preparation::new(maker, device, request.threads);
    // Accuracy asks for the optima alone, which every dataset has; regression's loss would ask for values.
    let settings = TrainingSettings {
        loss: Loss::Ranking,
        ..model.card().training.clone()
    };
    let found = evaluate(&mut network, device, &settings, &preparation, &steps)?;
    Ok(found.accuracies)
}
