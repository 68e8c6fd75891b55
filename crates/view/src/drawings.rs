//! Streams as pictures, in schemas that Foxglove draws.

use foxglove::messages;
use ppnpack_service::clock::now_ns;
use ppnpack_wire::convert::{cloud, scene};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::{MAX_CLOUD_BYTES, MAX_MESSAGE_BYTES, WireError, debug, decode, v1};
use prost::Message;

/// Makes a picture of a message of a cell.
pub(crate) type Draw = fn(&Cell, &[u8]) -> Result<Vec<u8>, WireError>;

/// How a stream is drawn.
pub(crate) struct Drawing {
    pub(crate) stream: Stream,
    /// The name of the channel with the pictures.
    pub(crate) name: &'static str,
    pub(crate) schema: fn() -> MessageSchema,
    pub(crate) draw: Draw,
}

/// All streams that are drawn.
pub(crate) static DRAWINGS: [Drawing; 3] = [
    Drawing {
        stream: Stream::Heightmap,
        name: "drawn_heightmap",
        schema: MessageSchema::of_foxglove::<messages::Grid>,
        draw: heightmap,
    },
    Drawing {
        stream: Stream::Cloud,
        name: "drawn_cloud",
        schema: MessageSchema::of_foxglove::<messages::PointCloud>,
        draw: cloud,
    },
    Drawing {
        stream: Stream::State,
        name: "drawn_state",
        schema: MessageSchema::of_foxglove::<messages::SceneUpdate>,
        draw: state,
    },
];

fn heightmap(cell: &Cell, payload: &[u8]) -> Result<Vec<u8>, WireError> {
    let message: v1::Heightmap = decode(payload, MAX_MESSAGE_BYTES)?;
    let (grid, scene) = scene::read_required("scene", message.scene.as_ref())?;
    let picture = debug::heightmap(cell, message.captured_at_ns, &grid, scene.heightmap());
    Ok(picture.encode_to_vec())
}

fn cloud(cell: &Cell, payload: &[u8]) -> Result<Vec<u8>, WireError> {
    let message: v1::PointCloud = decode(payload, MAX_CLOUD_BYTES)?;
    Ok(debug::cloud(cell, &cloud::read(&message)?).encode_to_vec())
}

fn state(cell: &Cell, payload: &[u8]) -> Result<Vec<u8>, WireError> {
    let message: v1::CellState = decode(payload, MAX_MESSAGE_BYTES)?;
    let at_ns = i64::try_from(now_ns()).unwrap_or(i64::MAX);
    Ok(debug::state(cell, at_ns, &message).encode_to_vec())
}
