//! Publishers of topics.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicI64, Ordering};

use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;

use crate::attachment::{Attachment, Gid};
use crate::cdr;
use crate::description::Message;
use crate::error::RosError;
use crate::latched::Latched;

/// Publishes a topic, until it is dropped. It never waits for readers: a slow one, or a full link, loses messages.
pub struct Publisher<M> {
    pub(crate) publisher: zenoh::pubsub::Publisher<'static>,
    pub(crate) latched: Option<Latched>,
    pub(crate) gid: Gid,
    pub(crate) sequence: AtomicI64,
    pub(crate) _token: LivelinessToken,
    pub(crate) message: PhantomData<fn(M)>,
}

impl<M: Message> Publisher<M> {
    /// Publishes a message.
    ///
    /// # Errors
    /// [`RosError`] where it is too large for CDR, or the session is closed.
    pub fn publish(&self, message: &M) -> Result<(), RosError> {
        let payload = ZBytes::from(cdr::encode(message)?);
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed);
        let attachment = Attachment::now(sequence, self.gid).to_bytes();
        if let Some(latched) = &self.latched {
            latched.keep(payload.clone(), attachment.clone());
        }
        let put = self.publisher.put(payload).attachment(attachment);
        put.wait()
            .map_err(|error| RosError::zenoh("publishing", &error))
    }

    /// What was published last is so no longer: of a topic that is latched, whoever comes later is given nothing before the next message.
    pub fn forget(&self) {
        if let Some(latched) = &self.latched {
            latched.forget();
        }
    }

    /// Whether somebody subscribes the topic, as far as the session has heard.
    pub fn has_readers(&self) -> bool {
        let status = self.publisher.matching_status().wait();
        status.is_ok_and(|status| status.matching())
    }
}
