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
use prost::Message;
use zenoh::Session;
use zenoh::bytes::ZBytes;

use crate::drawings::{self, Draw, Drawing};
use crate::error::ViewError;

/// What the messages of all channels are encoded in, and their schemas.
const PROTOBUF: &str = "protobuf";

/// The name of the scene of the last step, beside those of the streams.
const PLANNED_SCENE: &str = "planned_scene";

/// A stream of a cell, passed on as it comes, or as a picture of it.
pub(crate) struct StreamChannel {
    cell: Cell,
    stream: Stream,
    channel: Arc<RawChannel>,
    draw: Option<Draw>,
    subscription: Option<Subscription>,
}

impl StreamChannel {
    pub(crate) fn new(
        context: &Arc<Context>,
        cell: &Cell,
        stream: Stream,
    ) -> Result<Self, ViewError> {
        let schema = MessageSchema::of_stream(stream);
        let schema = schema.map_err(|error| ViewError::Channel(error.to_string()))?;
        Ok(Self {
            channel: channel(context, cell.as_str(), stream.as_str(), schema)?,
            cell: cell.clone(),
            stream,
            draw: None,
            subscription: None,
        })
    }

    /// The channel with the pictures of a stream.
    pub(crate) fn drawn(
        context: &Arc<Context>,
        cell: &Cell,
        drawing: &Drawing,
    ) -> Result<Self, ViewError> {
        Ok(Self {
            channel: channel(context, cell.as_str(), drawing.name, (drawing.schema)())?,
            cell: cell.clone(),
            stream: drawing.stream,
            draw: Some(drawing.draw),
            subscription: None,
        })
    }

    /// Reads the stream while somebody looks at it.
    pub(crate) fn follow(&mut self, session: &Session) -> Result<(), ViewError> {
        match (self.channel.has_sinks(), &self.subscription) {
            (true, None) => {
                let (channel, draw) = (Arc::clone(&self.channel), self.draw);
                // It only puts the message, or its picture, into the viewers' queues.
                let pass_on = move |cell: Cell, payload: ZBytes| {
                    let payload = payload.to_bytes();
                    match draw.map(|draw| draw(&cell, &payload)) {
                        None => log(&channel, &payload),
                        Some(Ok(picture)) => log(&channel, &picture),
                        Some(Err(error)) => tracing::debug!(%cell, %error, "not drawn"),
                    }
                };
                let subscription =
                    stream::subscribe_payloads(session, Some(&self.cell), self.stream, pass_on)?;
                self.subscription = Some(subscription);
            }
            (false, Some(_)) => self.subscription = None,
            _ => {}
        }
        Ok(())
    }
}

/// The scene of the last step.
pub(crate) struct SceneChannel {
    cell: Cell,
    channel: Arc<RawChannel>,
    /// The newest record, until it is drawn.
    newest: Arc<Mutex<Option<ZBytes>>>,
    subscription: Option<Subscription>,
}

impl SceneChannel {
    pub(crate) fn new(context: &Arc<Context>, cell: &Cell) -> Result<Self, ViewError> {
        let schema = drawings::schema::<SceneUpdate>();
        Ok(Self {
            channel: channel(context, cell.as_str(), PLANNED_SCENE, schema)?,
            cell: cell.clone(),
            newest: Arc::default(),
            subscription: None,
        })
    }

    /// Reads the records while somebody looks at the scene. Gives a new one.
    pub(crate) fn follow(&mut self, session: &Session) -> Result<Option<ZBytes>, ViewError> {
        match (self.channel.has_sinks(), &self.subscription) {
            (true, None) => {
                let newest = Arc::clone(&self.newest);
                let keep = move |_, payload| *lock(&newest) = Some(payload);
                let records =
                    stream::subscribe_payloads(session, Some(&self.cell), Stream::Record, keep)?;
                self.subscription = Some(records);
            }
            (false, Some(_)) => self.subscription = None,
            _ => {}
        }
        Ok(lock(&self.newest).take())
    }

    /// Shows a scene.
    pub(crate) fn show(&self, scene: &SceneUpdate) {
        log(&self.channel, &scene.encode_to_vec());
    }
}

/// A channel of a cell, or of all.
pub(crate) fn channel(
    context: &Arc<Context>,
    cell: &str,
    name: &str,
    schema: MessageSchema,
) -> Result<Arc<RawChannel>, ViewError> {
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

/// Puts a message into the queues of who looks.
pub(crate) fn log(channel: &RawChannel, payload: &[u8]) {
    channel.log_with_meta(payload, PartialMetadata::with_log_time(now_ns()));
}
