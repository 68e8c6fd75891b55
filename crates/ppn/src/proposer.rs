//! Proposing placements with a network.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};

use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Heightmap;
use ppnpack_packing::item::Item;
use ppnpack_packing::placement::Placement;
use ppnpack_packing::proposals::{Percent, Proposals, Proposer};
use ppnpack_packing::step::{StageError, StepInput};

use crate::error::NetworkError;
use crate::inference::Inference;

/// A step to propose for, and where the answer goes.
struct Request {
    heightmap: Heightmap,
    items: Vec<Arc<Item>>,
    answer: Sender<Result<Vec<Vec<Placement>>, NetworkError>>,
}

/// Proposes the placements that a network scores best: `K` % of all placements `|P|` of a candidate, its yaws times
/// the container's cells, among those that stay below the rim.
///
/// The model lives on a thread of its own, which computes with one thread on the processor. Proposals are sorted by
/// increasing score.
#[derive(Debug)]
pub struct NetworkProposer {
    requests: Option<Sender<Request>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl NetworkProposer {
    /// Loads a model for a grid and warms it up. The features of `items` are computed at once; those of others when
    /// they are first seen.
    ///
    /// # Errors
    /// [`NetworkError`] where the weights do not fit their architecture or the device is not there.
    pub fn new(
        model: &Model,
        grid: &Grid,
        share: Percent,
        device: Device,
        items: &[Arc<Item>],
    ) -> Result<Self, NetworkError> {
        let (requests, received) = channel();
        let (ready, is_ready) = sync_channel(1);
        let (model, grid, items) = (model.clone(), grid.clone(), items.to_vec());
        let thread = std::thread::Builder::new()
            .name("network".to_owned())
            .spawn(move || {
                // Set for the thread that calls libtorch: two threads on busy cores stall each other.
                tch::set_num_threads(1);
                match start(&model, &grid, device, &items) {
                    Ok(inference) => {
                        if ready.send(Ok(())).is_ok() {
                            serve(inference, share, &received);
                        }
                    }
                    // Whoever waits gets the error; nobody else can use it.
                    Err(error) => drop(ready.send(Err(error))),
                }
            })
            .map_err(|_| NetworkError::Thread)?;
        is_ready.recv().map_err(|_| NetworkError::Thread)??;
        Ok(Self {
            requests: Some(requests),
            thread: Some(thread),
        })
    }

    fn ask(&self, input: &StepInput<'_>) -> Result<Vec<Vec<Placement>>, NetworkError> {
        let (answer, answered) = channel();
        let items = input.candidates.iter();
        let request = Request {
            heightmap: input.scene.heightmap().clone(),
            items: items.map(|candidate| candidate.item.clone()).collect(),
            answer,
        };
        let requests = self.requests.as_ref().ok_or(NetworkError::Thread)?;
        requests.send(request).map_err(|_| NetworkError::Thread)?;
        answered.recv().map_err(|_| NetworkError::Thread)?
    }
}

impl Proposer for NetworkProposer {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        proposals.clear();
        for placements in self.ask(input)? {
            proposals.push(placements);
        }
        Ok(())
    }
}

impl Drop for NetworkProposer {
    fn drop(&mut self) {
        // Closing the channel ends the thread.
        self.requests = None;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the network's thread panicked");
        }
    }
}

fn start(
    model: &Model,
    grid: &Grid,
    device: Device,
    items: &[Arc<Item>],
) -> Result<Inference, NetworkError> {
    let mut inference = Inference::new(model, grid, device)?.warmed_up()?;
    inference.prepare(items)?;
    Ok(inference)
}

/// Answers requests until the channel closes. One at a time is under way, as a planner waits for each.
fn serve(mut inference: Inference, share: Percent, requests: &Receiver<Request>) {
    while let Ok(request) = requests.recv() {
        let items: Vec<&Item> = request.items.iter().map(|item| &**item).collect();
        let best = inference.best(&request.heightmap, &items, share);
        if request.answer.send(best).is_err() {
            tracing::warn!("nobody waits for the proposals any more");
        }
    }
}
