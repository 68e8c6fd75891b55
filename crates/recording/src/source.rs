//! The streams of cells, as they come.

use std::sync::Arc;

use ppnpack_service::ServiceError;
use ppnpack_service::clock::now_ns;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use zenoh::Session;
use zenoh::bytes::ZBytes;

use crate::queue::{Entry, Queue, Sample};
use crate::shapes::RecordInlet;
use crate::topic::Topic;

/// Puts what these cells publish into a queue, of all cells where none is named; records go where their shapes are fetched.
pub(crate) fn subscribe(
    session: &Session,
    cells: &[Cell],
    streams: &[Stream],
    queue: &Arc<Queue>,
    records: &RecordInlet,
) -> Result<Vec<Subscription>, ServiceError> {
    let mut subscriptions = Vec::new();
    for cell in stream::each_or_all(cells) {
        for stream in streams.iter().copied() {
            let (queue, records) = (Arc::clone(queue), records.clone());
            let on_payload = move |cell: Cell, payload: ZBytes| {
                let sample = Sample {
                    topic: Topic::Stream(cell, stream),
                    at_ns: now_ns(),
                    payload,
                };
                match stream {
                    Stream::Record => records.push(sample),
                    _ => queue.push(Entry::new(sample)),
                }
            };
            let subscription = stream::subscribe_payloads(session, cell, stream, on_payload);
            subscriptions.push(subscription?);
        }
    }
    Ok(subscriptions)
}
