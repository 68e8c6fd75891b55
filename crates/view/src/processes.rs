//! The channels of processes, of whatever cell: what they log, and how they are. Each is fed only while somebody looks at it.

use std::sync::Arc;
use std::time::Duration;

use foxglove::{Context, RawChannel};
use ppnpack_service::stream::Subscription;
use ppnpack_service::{log_stream, survey};
use ppnpack_wire::keys::ALL_CELLS;
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::v1;
use prost::Message;
use zenoh::Session;
use zenoh::bytes::ZBytes;

use crate::channels::{channel, log};
use crate::error::ViewError;

/// How long all services may take to say how they are.
const PATIENCE: Duration = Duration::from_millis(500);

/// What processes log.
pub(crate) struct LogChannel {
    channel: Arc<RawChannel>,
    subscription: Option<Subscription>,
}

impl LogChannel {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, ViewError> {
        Ok(Self {
            channel: channel(context, ALL_CELLS, "log", MessageSchema::of_log())?,
            subscription: None,
        })
    }

    /// Reads the logs while somebody looks at them.
    pub(crate) fn follow(&mut self, session: &Session) -> Result<(), ViewError> {
        match (self.channel.has_sinks(), &self.subscription) {
            (true, None) => {
                let channel = Arc::clone(&self.channel);
                let pass_on = move |line: ZBytes| log(&channel, &line.to_bytes());
                self.subscription = Some(log_stream::subscribe(session, pass_on)?);
            }
            (false, Some(_)) => self.subscription = None,
            _ => {}
        }
        Ok(())
    }
}

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
