//! Streams of which each message is passed on, and those that are read only while somebody subscribes what is made of them.

use ppnpack_ros::description::Message;
use ppnpack_ros::{Publisher, RosError};
use ppnpack_service::process::Process;
use ppnpack_service::stream::{self, Latest, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, WireError};

use crate::cells::Common;
use crate::error::FaceError;

/// Passes each message of a stream on. It runs on Zenoh's thread: `pass_on` waits for nothing.
pub(super) fn each<M: prost::Message + prost::Name + Default + 'static>(
    common: &Common,
    cell: &Cell,
    stream: Stream,
    pass_on: impl Fn(&Cell, &M) -> Result<(), RosError> + Send + Sync + 'static,
) -> Result<Subscription, FaceError> {
    let own = cell.clone();
    let on_message = move |_, message: M| {
        if let Err(error) = pass_on(&own, &message) {
            tracing::debug!(cell = %own, %stream, %error, "not passed on");
        }
    };
    let session = common.process.session();
    let (cell, limit) = (Some(cell), MAX_MESSAGE_BYTES);
    Ok(stream::subscribe(session, cell, stream, limit, on_message)?)
}

/// A stream of a cell, of which the newest message becomes one of ROS while somebody reads that.
pub(crate) struct Followed<M, T> {
    cell: Cell,
    stream: Stream,
    latest: Option<Latest<M>>,
    publisher: Publisher<T>,
}

impl<M: prost::Message + prost::Name + Default, T: Message> Followed<M, T> {
    pub(crate) fn new(cell: &Cell, stream: Stream, publisher: Publisher<T>) -> Self {
        Self {
            cell: cell.clone(),
            stream,
            latest: None,
            publisher,
        }
    }

    /// The newest message that was not taken yet, where somebody reads what is made of it.
    pub(crate) fn newest(&mut self, process: &Process) -> Result<Option<M>, FaceError> {
        match (self.publisher.has_readers(), &self.latest) {
            (true, None) => {
                let (cell, stream) = (&self.cell, self.stream);
                let latest = Latest::subscribe(process, cell, stream, MAX_MESSAGE_BYTES)?;
                self.latest = Some(latest);
            }
            (false, Some(_)) => {
                self.latest = None;
                // What comes while nobody reads is not heard of: whoever comes next is not given what was so before.
                self.publisher.forget();
            }
            _ => {}
        }
        let arrived = self.latest.as_ref().and_then(Latest::take);
        // One that is malformed is counted where it is read.
        Ok(arrived.and_then(|arrived| arrived.message.ok()))
    }

    /// Passes on what was made of a message; where nothing could be, says so.
    pub(crate) fn pass_on(&self, made: Result<T, WireError>) -> Result<(), FaceError> {
        match made {
            Ok(message) => self.publisher.publish(&message)?,
            Err(error) => {
                tracing::debug!(cell = %self.cell, stream = %self.stream, %error, "not passed on");
            }
        }
        Ok(())
    }
}
