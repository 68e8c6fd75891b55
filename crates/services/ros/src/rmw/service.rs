//! Services, and requests that wait for their answers.

use ppnpack_service::clock::now_ns;
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::query::{Query, Queryable};

use super::cdr;
use super::keys::{self, Name, Qos};
use super::messages::Service;
use super::node::{Endpoint, Node};
use crate::error::RosError;

const MAX_REQUEST_BYTES: usize = 4 << 20;

/// The attachment of a message or a request: its number, when it was sent, and by whom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Attachment([u8; 33]);

impl Attachment {
    /// Makes that of a message by its number and its endpoint's name.
    pub(super) fn new(sequence: i64, gid: [u8; 16]) -> Self {
        let mut bytes = [0; 33];
        bytes[..8].copy_from_slice(&sequence.to_le_bytes());
        // The length of the name.
        bytes[16] = 16;
        bytes[17..].copy_from_slice(&gid);
        Self(bytes)
    }

    /// Gives that of an answer: its request's. Who sends none does not tell answers apart.
    fn of_request(request: Option<&ZBytes>) -> Self {
        let bytes = request.and_then(|request| request.to_bytes().as_ref().try_into().ok());
        bytes.map_or_else(|| Self::new(0, [0; 16]), Self)
    }

    /// Gives its bytes, as of something that is sent now.
    pub(super) fn sent_now(mut self) -> Vec<u8> {
        self.0[8..16].copy_from_slice(&now_ns().to_le_bytes());
        self.0.to_vec()
    }
}

/// A service that is answered, until it is dropped.
pub(crate) struct Server {
    _queryable: Queryable<()>,
    _endpoint: Endpoint,
}

/// A request that waits for its answer. Where it is dropped, whoever asked waits in vain until
/// their own time is up.
pub(crate) struct Request<S> {
    query: Query,
    key: String,
    pub(crate) message: S,
}

impl<S: Service> Request<S> {
    pub(crate) fn answer(self, response: &S::Response) {
        let attachment = Attachment::of_request(self.query.attachment()).sent_now();
        let sent = cdr::encode(response).and_then(|payload| {
            let reply = self.query.reply(&self.key, payload).attachment(attachment);
            let sent = reply.wait();
            sent.map_err(|error| RosError::zenoh(&self.key, &error))
        });
        if let Err(error) = sent {
            tracing::debug!(%error, "an answer was not sent");
        }
    }
}

/// Reads what is asked; it has a bound.
fn read<S: Service>(query: &Query) -> Result<S, RosError> {
    let payload = query.payload().cloned().unwrap_or_default();
    match payload.len() {
        0..=MAX_REQUEST_BYTES => cdr::decode(&payload.to_bytes()),
        bytes => Err(RosError::message::<S>(format_args!(
            "{bytes} bytes where {MAX_REQUEST_BYTES} are possible"
        ))),
    }
}

impl Node {
    /// Calls `on_request` with every request of a service. It runs on Zenoh's thread: it must only
    /// hand the request over, to something with a bound, or answer at once. Who asks what cannot be
    /// read is told so.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub(crate) fn serve<S: Service>(
        &self,
        name: &Name,
        on_request: impl Fn(Request<S>) + Send + Sync + 'static,
    ) -> Result<Server, RosError> {
        let of = S::key();
        let key = keys::data(self.key.domain, name, &of);
        let answered = key.clone();
        let callback = move |query: Query| match read(&query) {
            Ok(message) => on_request(Request {
                query,
                key: answered.clone(),
                message,
            }),
            Err(error) => {
                tracing::debug!(key = answered, %error, "malformed request refused");
                if let Err(error) = query.reply_err(error.to_string()).wait() {
                    tracing::debug!(key = answered, %error, "a refusal was not sent");
                }
            }
        };
        let declared = self.session.declare_queryable(key.clone()).complete(true);
        let declared = declared.callback(callback).wait();
        Ok(Server {
            _queryable: declared.map_err(|error| RosError::zenoh(&key, &error))?,
            _endpoint: self.endpoint(keys::SERVER, name, &of, Qos::Services)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_has_the_attachment_of_its_request_but_for_the_time() {
        let attachment = Attachment::new(7, *b"0123456789abcdef");
        let bytes = attachment.sent_now();
        let expected: [&[u8]; 2] = [&[7, 0, 0, 0, 0, 0, 0, 0], b"\x100123456789abcdef"];
        assert_eq!([&bytes[..8], &bytes[16..]], expected);
        assert_ne!(bytes[8..16], [0; 8]);
        let answered = Attachment::of_request(Some(&ZBytes::from(bytes.clone())));
        assert_eq!(answered.0[..], bytes);
        for length in 0..bytes.len() {
            let cut = ZBytes::from(bytes[..length].to_vec());
            assert_eq!(
                Attachment::of_request(Some(&cut)),
                Attachment::new(0, [0; 16])
            );
        }
    }
}
