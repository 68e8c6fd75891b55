//! The cells that are there, and what is looked at of them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use foxglove::Context;
use ppnpack_service::alive;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};
use zenoh::Session;

use crate::channels::{SceneChannel, StreamChannel};
use crate::drawings::DRAWINGS;
use crate::error::ViewError;
use crate::processes::HealthChannel;
use crate::scene::PlannedScenes;

/// How often it is looked for cells.
const LOOKED_FOR_EVERY: Duration = Duration::from_secs(1);

/// How long the answers to that may take.
const PATIENCE: Duration = Duration::from_millis(500);

/// Cells and containers that are served at most.
const MOST_CELLS: usize = 1_000;

/// The cells and their channels.
pub(crate) struct Cells {
    session: Session,
    context: Arc<Context>,
    cells: BTreeMap<Cell, CellChannels>,
    scenes: PlannedScenes,
    health: HealthChannel,
    looked_at: Option<Instant>,
}

struct CellChannels {
    streams: Vec<StreamChannel>,
    scene: SceneChannel,
}

impl Cells {
    pub(crate) fn new(session: &Session, context: Arc<Context>) -> Result<Self, ViewError> {
        Ok(Self {
            session: session.clone(),
            cells: BTreeMap::new(),
            scenes: PlannedScenes::new(session),
            health: HealthChannel::new(&context)?,
            context,
            looked_at: None,
        })
    }

    /// Looks which cells there are and what is looked at, and draws what is new.
    pub(crate) fn advance(&mut self) -> Result<(), ViewError> {
        let now = Instant::now();
        if self.looked_at.is_none_or(|at| now - at >= LOOKED_FOR_EVERY) {
            self.looked_at = Some(now);
            self.look(now + PATIENCE)?;
            self.health.follow(&self.session)?;
        }
        for (cell, channels) in &mut self.cells {
            for stream in &mut channels.streams {
                stream.follow(&self.session)?;
            }
            let Some(record) = channels.scene.follow(&self.session)? else {
                continue;
            };
            let record: Result<v1::PlanningRecord, _> =
                decode(&record.to_bytes(), MAX_MESSAGE_BYTES);
            let record = record.map_err(|error| error.to_string());
            match record.and_then(|record| self.scenes.draw(cell, &record)) {
                Ok(scene) => channels.scene.show(&scene),
                Err(error) => tracing::warn!(%cell, error, "a step is not drawn"),
            }
        }
        Ok(())
    }

    /// Adds the channels of cells that are new.
    fn look(&mut self, deadline: Instant) -> Result<(), ViewError> {
        let found = alive::find(&self.session, deadline)?;
        for cell in found.into_iter().flat_map(|found| found.cells) {
            if self.cells.len() >= MOST_CELLS || self.cells.contains_key(&cell) {
                continue;
            }
            let streams = Stream::ALL.iter().copied();
            let streams = streams.map(|stream| StreamChannel::new(&self.context, &cell, stream));
            let drawn = DRAWINGS.iter();
            let drawn = drawn.map(|drawing| StreamChannel::drawn(&self.context, &cell, drawing));
            let channels = CellChannels {
                streams: streams.chain(drawn).collect::<Result<_, _>>()?,
                scene: SceneChannel::new(&self.context, &cell)?,
            };
            self.cells.insert(cell, channels);
        }
        Ok(())
    }
}
