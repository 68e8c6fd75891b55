//! The channels of a cell, each read only while somebody looks at it.

use std::borrow::Cow;
use std::sync::{Arc, Mutex};

use foxglove::messages::SceneUpdate;
use foxglove::{Context, PartialMetadata, RawChannel, Schema};
use ppnpack_service::clock::now_ns;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::schemas::MessageSchema;
use prost::{DecodeError, Message};
use zenoh::Session;
use zenoh::bytes::ZBytes;

use crate::drawings::{self, Drawing};
use crate::error::ViewError;

/// The encoding of the messages of all channels, and of their schemas.
const PROTOBUF: &str = "protobuf";

/// The name of the scene of the last step, beside those of the streams.
const PLANNED_SCENE: &str = "planned_scene";

/// The work that a message of a stream is given to. It runs on Zenoh's thread.
type OnPayload = dyn Fn(Cell, ZBytes) + Send + Sync;

/// A channel, and the stream that feeds it.
pub(crate) struct StreamChannel {
    cell: Cell,
    stream: Stream,
    channel: Arc<RawChannel>,
    on_payload: Arc<OnPayload>,
    subscription: Option<Subscription>,
}

impl StreamChannel {
    /// Makes the channel that passes a stream on as it comes.
    pub(crate) fn new(
        context: &Arc<Context>,
        cell: &Cell,
        stream: Stream,
    ) -> Result<Self, ViewError> {
        let schema = MessageSchema::of_stream(stream);
        let channel = channel(context, cell.as_str(), stream.as_str(), schema)?;
        let to = Arc::clone(&channel);
        let pass_on = move |_, payload: ZBytes| log(&to, &payload.to_bytes());
        Ok(Self::fed(cell, stream, channel, pass_on))
    }

    /// Makes the channel with the pictures of a stream.
    pub(crate) fn drawn(
        context: &Arc<Context>,
        cell: &Cell,
        drawing: &Drawing,
    ) -> Result<Self, ViewError> {
        let channel = channel(context, cell.as_str(), drawing.name, Ok((drawing.schema)()))?;
        let (to, draw) = (Arc::clone(&channel), drawing.draw);
        let show = move |cell: Cell, payload: ZBytes| match draw(&cell, &payload.to_bytes()) {
            Ok(picture) => log(&to, &picture),
            Err(error) => tracing::debug!(%cell, %error, "not drawn"),
        };
        Ok(Self::fed(cell, drawing.stream, channel, show))
    }

    fn fed(
        cell: &Cell,
        stream: Stream,
        channel: Arc<RawChannel>,
        on_payload: impl Fn(Cell, ZBytes) + Send + Sync + 'static,
    ) -> Self {
        Self {
            cell: cell.clone(),
            stream,
            channel,
            on_payload: Arc::new(on_payload),
            subscription: None,
        }
    }

    /// Reads the stream while somebody looks at the channel.
    pub(crate) fn follow(&mut self, session: &Session) -> Result<(), ViewError> {
        let is_seen = self.channel.has_sinks();
        if is_seen != self.subscription.is_some() {
            let on_payload = Arc::clone(&self.on_payload);
            let give = move |cell, payload| on_payload(cell, payload);
            let subscribe =
                || stream::subscribe_payloads(session, Some(&self.cell), self.stream, give);
            self.subscription = is_seen.then(subscribe).transpose()?;
        }
        Ok(())
    }
}

pub(crate) struct SceneChannel {
    records: StreamChannel,
    /// The newest record, until it is drawn.
    newest: Arc<Mutex<Option<ZBytes>>>,
}

impl SceneChannel {
    pub(crate) fn new(context: &Arc<Context>, cell: &Cell) -> Result<Self, ViewError> {
        let schema = drawings::schema::<SceneUpdate>();
        let channel = channel(context, cell.as_str(), PLANNED_SCENE, Ok(schema))?;
        let newest: Arc<Mutex<Option<ZBytes>>> = Arc::default();
        let slot = Arc::clone(&newest);
        let keep = move |_, payload| *lock(&slot) = Some(payload);
        Ok(Self {
            records: StreamChannel::fed(cell, Stream::Record, channel, keep),
            newest,
        })
    }

    /// Reads the records while somebody looks at the scene. Gives a new one.
    pub(crate) fn follow(&mut self, session: &Session) -> Result<Option<ZBytes>, ViewError> {
        self.records.follow(session)?;
        Ok(lock(&self.newest).take())
    }

    pub(crate) fn show(&self, scene: &SceneUpdate) {
        log(&self.records.channel, &scene.encode_to_vec());
    }
}

pub(crate) fn channel(
    context: &Arc<Context>,
    cell: &str,
    name: &str,
    schema: Result<MessageSchema, DecodeError>,
) -> Result<Arc<RawChannel>, ViewError> {
    let schema = schema.map_err(|error| ViewError::Channel(error.to_string()))?;
    let schema = Schema {
        name: schema.name,
        encoding: PROTOBUF.to_owned(),
        data: Cow::Owned(schema.descriptors),
    };
    let channel = context
        .channel_builder(format!("/{cell}/{name}"))
        .message_encoding(PROTOBUF)
        .schema(schema)
        .build_raw();
    channel.map_err(|error| ViewError::Channel(error.to_string()))
}

/// Puts a message into the queues of the viewers.
pub(crate) fn log(channel: &RawChannel, payload: &[u8]) {
    channel.log_with_meta(payload, PartialMetadata::with_log_time(now_ns()));
}
