//! The cells that are there, and their channels.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use foxglove::{Context, RawChannel};
use ppnpack_service::{alive, survey};
use ppnpack_wire::keys::{ALL_CELLS, Cell, Stream};
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};
use prost::Message;
use zenoh::Session;

use crate::channels::{SceneChannel, StreamChannel, channel, log};
use crate::drawings::DRAWINGS;
use crate::error::ViewError;
use crate::scene::PlannedScenes;

/// How often it is looked for cells, and services are asked for their health.
const LOOKED_FOR_EVERY: Duration = Duration::from_secs(1);

/// How long the answers to each of these may take.
const PATIENCE: Duration = Duration::from_millis(500);

const MOST_CELLS: usize = 1_000;

pub(crate) struct Cells {
    session: Session,
    context: Arc<Context>,
    cells: BTreeMap<Cell, CellChannels>,
    scenes: PlannedScenes,
    health: Arc<RawChannel>,
    looked_at: Option<Instant>,
}

struct CellChannels {
    streams: Vec<StreamChannel>,
    scene: SceneChannel,
}

impl Cells {
    pub(crate) fn new(session: &Session, context: Arc<Context>) -> Result<Self, ViewError> {
        let schema = MessageSchema::of::<v1::HealthReply>();
        Ok(Self {
            session: session.clone(),
            cells: BTreeMap::new(),
            scenes: PlannedScenes::new(session),
            health: channel(&context, ALL_CELLS, "health", schema)?,
            context,
            looked_at: None,
        })
    }

    /// Looks for cells and for viewers, and draws new steps.
    pub(crate) fn advance(&mut self) -> Result<(), ViewError> {
        let now = Instant::now();
        if self.looked_at.is_none_or(|at| now - at >= LOOKED_FOR_EVERY) {
            self.looked_at = Some(now);
            self.look(now + PATIENCE)?;
            self.show_health()?;
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

    /// Asks all services for their health once, if somebody looks.
    fn show_health(&self) -> Result<(), ViewError> {
        if self.health.has_sinks() {
            for reply in survey::health(&self.session, PATIENCE)? {
                log(&self.health, &reply.encode_to_vec());
            }
        }
        Ok(())
    }
}
