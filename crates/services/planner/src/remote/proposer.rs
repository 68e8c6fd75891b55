//! Proposals of the network, from a ppn service.

use std::time::{Duration, Instant};

use ppnpack_packing::item::Item;
use ppnpack_packing::proposals::{Percent, Proposals, Proposer};
use ppnpack_packing::step::{StageError, StepInput};
use ppnpack_service::rpc::CallError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Instance;
use ppnpack_wire::{convert, v1};

use super::items::ItemMessages;
use super::peers::Peers;

/// After a failure the service is not asked again for this long: a service that hangs costs the time limit each time.
const PAUSE: Duration = Duration::from_secs(1);

/// Asks a ppn service for the placements with the best scores.
pub(crate) struct RemoteProposer {
    peers: Peers,
    share: Percent,
    items: ItemMessages,
    failed: Option<Failed>,
}

/// Who failed, when and how.
struct Failed {
    instance: Instance,
    at: Instant,
    reason: String,
}

impl RemoteProposer {
    pub(crate) fn new(peers: Peers, share: Percent) -> Self {
        Self {
            peers,
            share,
            items: ItemMessages::default(),
            failed: None,
        }
    }

    /// The instance that serves this cell: the same as long as the same ones are alive.
    fn instance(&self) -> Result<Instance, StageError> {
        let alive = self.peers.alive.instances();
        let cell = self.peers.cell.as_str();
        let sum: usize = cell.bytes().map(usize::from).sum();
        let chosen = alive.get(sum % alive.len().max(1)).cloned();
        let chosen = chosen.ok_or("no ppn service is alive")?;
        match &self.failed {
            Some(failed) if failed.instance == chosen && failed.at.elapsed() < PAUSE => {
                Err(failed.reason.clone().into())
            }
            _ => Ok(chosen),
        }
    }

    fn ask(
        &mut self,
        instance: &Instance,
        input: &StepInput<'_>,
        ids: &[ItemId],
        deadline: Instant,
    ) -> Result<v1::ProposeReply, CallError> {
        let items = || input.candidates.iter().map(|candidate| &*candidate.item);
        let mut scene = convert::scene::write(input.grid, input.scene);
        scene.surface = None;
        let mut request = v1::ProposeRequest {
            scene: Some(scene),
            item_ids: ids.iter().map(|id| id.to_bytes()).collect(),
            items: self.items.unsent(instance, items()),
            percent: self.share.percent(),
            ..v1::ProposeRequest::default()
        };
        let Peers { cell, client, .. } = &self.peers;
        let asked = match client.call_instance(cell, instance, request.clone(), deadline) {
            Err(error) if error.status() == Some(v1::Status::MissingItems) => {
                self.items.forget(instance);
                request.items = self.items.unsent(instance, items());
                client.call_instance(cell, instance, request, deadline)
            }
            asked => asked,
        };
        if asked.is_ok() {
            self.items.has(instance, ids);
        }
        asked
    }
}

impl Proposer for RemoteProposer {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        let instance = self.instance()?;
        let now = Instant::now();
        let deadline = self.peers.deadline(input);
        let items: Vec<&Item> = input.candidates.iter().map(|held| &*held.item).collect();
        let ids = self.items.ids(items.into_iter());
        let asked = self.ask(&instance, input, &ids, deadline);
        let filled = asked
            .map_err(|error| error.to_string())
            .and_then(|reply| fill(&reply, input.candidates.len(), proposals));
        if let Err(reason) = filled {
            let reason = format!("ppn service {instance}: {reason}");
            self.failed = Some(Failed {
                instance,
                at: now,
                reason: reason.clone(),
            });
            return Err(reason.into());
        }
        self.failed = None;
        Ok(())
    }
}

fn fill(
    reply: &v1::ProposeReply,
    candidates: usize,
    proposals: &mut Proposals,
) -> Result<(), String> {
    proposals.clear();
    if reply.proposals.len() != candidates {
        return Err(format!(
            "it answered for {} of {candidates} items",
            reply.proposals.len()
        ));
    }
    for placements in &reply.proposals {
        let placements = convert::placement::read_all("proposals", placements)
            .map_err(|error| error.to_string())?;
        proposals.push(placements);
    }
    Ok(())
}
