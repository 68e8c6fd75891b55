//! Nodes, and the topics that they publish.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicI64, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use ppnpack_service::sync::lock;
use sha2::{Digest, Sha256};
use zenoh::bytes::ZBytes;
use zenoh::key_expr::KeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use super::cdr;
use super::keys::{self, Name, NodeKey, Qos};
use super::messages::Typed;
use super::service::Attachment;
use crate::error::RosError;

/// A node: the face of a program towards others. A session has one.
pub(crate) struct Node {
    pub(super) session: Session,
    pub(super) key: NodeKey,
    /// Numbers its endpoints.
    numbers: AtomicU32,
    _token: LivelinessToken,
}

/// An endpoint, until it is dropped.
pub(super) struct Endpoint {
    id: u32,
    /// The name of it: any will do that no other endpoint has.
    gid: [u8; 16],
    _token: LivelinessToken,
}

impl Node {
    /// Declares a node of this name in a domain.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub(crate) fn new(session: &Session, domain: u32, name: &Name) -> Result<Self, RosError> {
        let key = NodeKey {
            domain,
            session: session.zid().to_string(),
            name: name.clone(),
        };
        Ok(Self {
            _token: declare(session, &key.token())?,
            session: session.clone(),
            key,
            numbers: AtomicU32::new(1),
        })
    }

    /// Declares a publisher of a topic.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub(crate) fn publisher<M: Typed>(
        &self,
        topic: &Name,
        qos: Qos,
    ) -> Result<Publisher<M>, RosError> {
        let of = M::key();
        let key = keys::data(self.key.domain, topic, &of);
        let publisher = self
            .session
            .declare_publisher(key.clone())
            .congestion_control(CongestionControl::Drop)
            .wait()
            .map_err(|error| RosError::zenoh(&key, &error))?;
        let endpoint = self.endpoint(keys::PUBLISHER, topic, &of, qos)?;
        let latch = || Latched::new(&self.session, publisher.key_expr(), endpoint.id);
        let latched = (qos == Qos::Latched).then(latch).transpose()?;
        Ok(Publisher {
            publisher,
            latched,
            endpoint,
            sequence: AtomicI64::new(1),
            message: PhantomData,
        })
    }

    /// Says that an endpoint is there.
    pub(super) fn endpoint(
        &self,
        kind: &str,
        topic: &Name,
        of: &str,
        qos: Qos,
    ) -> Result<Endpoint, RosError> {
        let id = self.numbers.fetch_add(1, Ordering::Relaxed);
        let token = self.key.endpoint(id, kind, topic, of, qos);
        let digest: [u8; 32] = Sha256::digest(&token).into();
        Ok(Endpoint {
            id,
            gid: digest.first_chunk().copied().unwrap_or_default(),
            _token: declare(&self.session, &token)?,
        })
    }
}

/// A publisher of a topic, until it is dropped. It never waits for readers: a slow one, or a full
/// link, loses messages.
pub(crate) struct Publisher<M> {
    publisher: zenoh::pubsub::Publisher<'static>,
    latched: Option<Latched>,
    endpoint: Endpoint,
    sequence: AtomicI64,
    message: PhantomData<fn(M)>,
}

impl<M: Typed> Publisher<M> {
    /// Publishes a message.
    ///
    /// # Errors
    /// [`RosError`] where it is too large for CDR, or the session is closed.
    pub(crate) fn publish(&self, message: &M) -> Result<(), RosError> {
        let payload = ZBytes::from(cdr::encode(message)?);
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed);
        let attachment = Attachment::new(sequence, self.endpoint.gid).sent_now();
        if let Some(latched) = &self.latched {
            *lock(&latched.last) = Some((payload.clone(), attachment.clone()));
        }
        let put = self.publisher.put(payload).attachment(attachment);
        put.wait()
            .map_err(|error| RosError::zenoh(self.publisher.key_expr(), &error))
    }
}

/// A message as it was sent, with its attachment.
type Sent = (ZBytes, Vec<u8>);

/// The last message of a topic, kept for who comes later: "transient local".
///
/// A subscriber of such a topic asks for what was published before under `<key>/@adv/**`, and again
/// when a publisher's token appears there; so do those of `rmw_zenoh`, by the advanced subscribers
/// of `zenoh-ext`.
struct Latched {
    last: Arc<Mutex<Option<Sent>>>,
    _queryable: Queryable<()>,
    _token: LivelinessToken,
}

impl Latched {
    /// Keeps the last message of the topic of this key, of the publisher of this number.
    fn new(session: &Session, key: &KeyExpr<'static>, id: u32) -> Result<Self, RosError> {
        let last = Arc::new(Mutex::new(None::<Sent>));
        let own = format!("{key}/@adv/pub/{}/{id}/_", session.zid());
        let (kept, of) = (Arc::clone(&last), key.clone());
        let tell = move |query: Query| {
            let Some((payload, attachment)) = lock(&kept).clone() else {
                return;
            };
            if let Err(error) = query.reply(&of, payload).attachment(attachment).wait() {
                tracing::debug!(key = %of, %error, "the last message was not sent");
            }
        };
        let queryable = session.declare_queryable(own.clone()).callback(tell).wait();
        Ok(Self {
            last,
            _queryable: queryable.map_err(|error| RosError::zenoh(&own, &error))?,
            _token: declare(session, &own)?,
        })
    }
}

fn declare(session: &Session, token: &str) -> Result<LivelinessToken, RosError> {
    let declared = session.liveliness().declare_token(token.to_owned()).wait();
    declared.map_err(|error| RosError::zenoh(token, &error))
}
