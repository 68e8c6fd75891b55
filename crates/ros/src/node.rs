//! Nodes: what others see of a program.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, AtomicU32, Ordering};

use sha2::{Digest, Sha256};
use zenoh::key_expr::KeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::query::Query;
use zenoh::{Session, Wait};

use crate::attachment::Gid;
use crate::description::Message;
use crate::error::RosError;
use crate::keys::{self, Kind, NodeKey, TypeKey};
use crate::latched::Latched;
use crate::names::Name;
use crate::publisher::Publisher;
use crate::qos::Qos;
use crate::service::{Request, Server, Service};

/// Numbers nodes and endpoints; no two of a session have the same.
static NUMBERS: AtomicU32 = AtomicU32::new(0);

/// A node. Clones share it; it is there until the last of them is dropped.
#[derive(Clone)]
pub struct Node {
    inner: Arc<Inner>,
}

struct Inner {
    session: Session,
    key: NodeKey,
    _token: LivelinessToken,
}

/// What stands for an endpoint.
struct Endpoint {
    id: u32,
    gid: Gid,
    token: LivelinessToken,
}

impl Node {
    /// A node of this name in a domain.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub fn new(session: &Session, domain: u32, name: &Name) -> Result<Self, RosError> {
        let key = NodeKey {
            domain,
            session: session.zid().to_string(),
            id: next_number(),
            name: name.clone(),
        };
        let inner = Inner {
            _token: declare(session, &key.token())?,
            session: session.clone(),
            key,
        };
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// A publisher of a topic.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub fn publisher<M: Message>(&self, topic: &Name, qos: Qos) -> Result<Publisher<M>, RosError> {
        let of = TypeKey::of_message::<M>();
        let key = key_expr(&keys::data(self.domain(), topic, &of))?;
        let session = &self.inner.session;
        let publisher = session
            .declare_publisher(key.clone())
            .congestion_control(CongestionControl::Drop)
            .wait()
            .map_err(|error| RosError::zenoh(format!("declaring {key}"), &error))?;
        let endpoint = self.endpoint(Kind::Publisher, topic, &of, qos)?;
        let latched = qos
            .is_latched
            .then(|| Latched::new(session, &key, endpoint.id));
        Ok(Publisher {
            publisher,
            latched: latched.transpose()?,
            gid: endpoint.gid,
            sequence: AtomicI64::new(1),
            _token: endpoint.token,
            message: PhantomData,
        })
    }

    /// Calls `on_request` with every request of a service. It runs on Zenoh's thread: it must only hand the request over, to something
    /// with a bound, or answer at once.
    ///
    /// # Errors
    /// [`RosError::Zenoh`] where the session is closed.
    pub fn serve<S: Service>(
        &self,
        name: &Name,
        on_request: impl Fn(Request<S>) + Send + Sync + 'static,
    ) -> Result<Server, RosError> {
        let of = TypeKey::of_service::<S>();
        let key = key_expr(&keys::data(self.domain(), name, &of))?;
        let answered = key.clone();
        let callback = move |query: Query| {
            if let Some(request) = Request::read(query, answered.clone()) {
                on_request(request);
            }
        };
        let queryable = self
            .inner
            .session
            .declare_queryable(key.clone())
            .complete(true)
            .callback(callback)
            .wait()
            .map_err(|error| RosError::zenoh(format!("declaring {key}"), &error))?;
        Ok(Server {
            _queryable: queryable,
            _token: self.endpoint(Kind::Server, name, &of, Qos::EVENTS)?.token,
        })
    }

    fn domain(&self) -> u32 {
        self.inner.key.domain
    }

    /// Says that an endpoint is there.
    fn endpoint(
        &self,
        kind: Kind,
        topic: &Name,
        of: &TypeKey,
        qos: Qos,
    ) -> Result<Endpoint, RosError> {
        let id = next_number();
        let token = self.inner.key.endpoint(id, kind, topic, of, qos);
        let digest: [u8; 32] = Sha256::digest(&token).into();
        Ok(Endpoint {
            id,
            // Any name will do that no other endpoint has.
            gid: digest.first_chunk().copied().unwrap_or_default(),
            token: declare(&self.inner.session, &token)?,
        })
    }
}

fn next_number() -> u32 {
    NUMBERS.fetch_add(1, Ordering::Relaxed)
}

fn declare(session: &Session, token: &str) -> Result<LivelinessToken, RosError> {
    let declared = session.liveliness().declare_token(token.to_owned()).wait();
    declared.map_err(|error| RosError::zenoh(format!("declaring {token}"), &error))
}

fn key_expr(key: &str) -> Result<KeyExpr<'static>, RosError> {
    KeyExpr::try_from(key.to_owned())
        .map_err(|error| RosError::zenoh(format!("'{key}' as a key"), &error))
}
