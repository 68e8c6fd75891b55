//! Services, and requests that wait for their answers.

use zenoh::Wait;
use zenoh::key_expr::KeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{Query, Queryable};

use crate::attachment::Attachment;
use crate::cdr;
use crate::description::Message;
use crate::error::RosError;

/// The largest request, in bytes.
const MAX_REQUEST_BYTES: usize = 4 << 20;

/// A service: what is asked, and what is answered.
pub trait Service: Send + Sync + 'static {
    /// What is asked.
    type Request: Message;

    /// What is answered.
    type Response: Message;

    /// Its name, such as `std_srvs/srv/Trigger`.
    fn type_name() -> String;
}

/// A service that is answered, until it is dropped.
pub struct Server {
    pub(crate) _queryable: Queryable<()>,
    pub(crate) _token: LivelinessToken,
}

/// A request that waits for its answer. Dropped without one, whoever asked waits in vain until their own time is up.
pub struct Request<S: Service> {
    query: Query,
    key: KeyExpr<'static>,
    attachment: Attachment,
    message: S::Request,
}

impl<S: Service> Request<S> {
    /// Reads what was asked; where it cannot be read, whoever asked is told.
    pub(crate) fn read(query: Query, key: KeyExpr<'static>) -> Option<Self> {
        match message::<S>(&query) {
            Ok(message) => Some(Self {
                // Who sends none does not tell answers apart.
                attachment: query
                    .attachment()
                    .and_then(Attachment::read)
                    .unwrap_or(Attachment {
                        sequence: 0,
                        sent_at_ns: 0,
                        gid: [0; 16],
                    }),
                query,
                key,
                message,
            }),
            Err(error) => {
                tracing::debug!(%key, %error, "malformed request refused");
                let refused = query.reply_err(error.to_string()).wait();
                if let Err(error) = refused {
                    tracing::debug!(%key, %error, "a refusal was not sent");
                }
                None
            }
        }
    }

    /// What is asked.
    pub fn message(&self) -> &S::Request {
        &self.message
    }

    /// Answers.
    pub fn answer(self, response: &S::Response) {
        let Attachment { sequence, gid, .. } = self.attachment;
        let attachment = Attachment::now(sequence, gid).to_bytes();
        let sent = cdr::encode(response).and_then(|payload| {
            let reply = self.query.reply(&self.key, payload);
            let sent = reply.attachment(attachment).wait();
            sent.map_err(|error| RosError::zenoh("answering", &error))
        });
        if let Err(error) = sent {
            tracing::debug!(key = %self.key, %error, "an answer was not sent");
        }
    }
}

fn message<S: Service>(query: &Query) -> Result<S::Request, RosError> {
    let empty = || RosError::Malformed {
        type_name: S::Request::type_name(),
        reason: "there is no payload".to_owned(),
    };
    let payload = query.payload().ok_or_else(empty)?;
    let bytes = payload.len();
    if bytes > MAX_REQUEST_BYTES {
        return Err(RosError::TooLarge {
            type_name: S::Request::type_name(),
            bytes,
            limit: MAX_REQUEST_BYTES,
        });
    }
    cdr::decode(&payload.to_bytes())
}
