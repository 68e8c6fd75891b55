//! The channel of the services' health, fed only while somebody looks at it.

use std::sync::Arc;
use std::time::Duration;

use foxglove::{Context, RawChannel};
use ppnpack_service::survey;
use ppnpack_wire::keys::ALL_CELLS;
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::v1;
use prost::Message;
use zenoh::Session;

use crate::channels::{channel, log};
use crate::error::ViewError;

/// How long all services may take to say how they are.
const PATIENCE: Duration = Duration::from_millis(500);

/// What services say of their health, a message for each.
pub(crate) struct HealthChannel {
    channel: Arc<RawChannel>,
}

impl HealthChannel {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, ViewError> {
        let schema = MessageSchema::of::<v1::HealthReply>();
        let schema = schema.map_err(|error| ViewError::Channel(error.to_string()))?;
        Ok(Self {
            channel: channel(context, ALL_CELLS, "health", schema)?,
        })
    }

    /// Asks all services once, if somebody looks.
    pub(crate) fn follow(&self, session: &Session) -> Result<(), ViewError> {
        if !self.channel.has_sinks() {
            return Ok(());
        }
        for reply in survey::health(session, PATIENCE)? {
            log(&self.channel, &reply.encode_to_vec());
        }
        Ok(())
    }
}
