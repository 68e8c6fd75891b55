//! Proposals of the network, from a ppn service.

use std::time::{Duration, Instant};

use ppnpack_packing::ranking::proposals::{Percent, Proposals, Proposer};
use ppnpack_packing::ranking::step::{StageError, StepInput};
use ppnpack_wire::keys::Instance;
use ppnpack_wire::{convert, v1};

use super::items::ItemMessages;
use super::peers::Peers;

/// Time for which a service that failed is not asked: one that hangs costs its limit each time.
const PAUSE: Duration = Duration::from_secs(1);

/// Asks a ppn service for the placements with the best scores.
pub(crate) struct RemoteProposer {
    peers: Peers,
    share: Percent,
    items: ItemMessages,
    failed: Option<Failed>,
}

/// An instance that failed, when and how.
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

    fn instance(&self) -> Result<Instance, StageError> {
        let chosen = self.peers.chosen().ok_or("no ppn service is alive")?;
        match &self.failed {
            Some(failed) if failed.instance == chosen && failed.at.elapsed() < PAUSE => {
                Err(failed.reason.clone().into())
            }
            _ => Ok(chosen),
        }
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
        let mut scene = convert::scene::write(input.grid, input.scene);
        scene.surface = None;
        let percent = self.share.percent();
        let asked = self.items.ask(&self.peers, &instance, input, |ids, items| {
            v1::ProposeRequest {
                scene: Some(scene.clone()),
                item_ids: ids.iter().map(|id| id.to_bytes()).collect(),
                items,
                percent,
                ..v1::ProposeRequest::default()
            }
        });
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
