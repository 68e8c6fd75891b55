//! The last message of a topic, kept for who comes later: "transient local".
//!
//! A subscriber of such a topic asks for what was published before under `<key>/@adv/**`, and again when a publisher's token appears there;
//! so do those of `rmw_zenoh`, by the advanced subscribers of `zenoh-ext`.

use std::sync::{Arc, Mutex, PoisonError};

use zenoh::bytes::ZBytes;
use zenoh::key_expr::KeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use crate::error::RosError;

/// The last message of a topic.
pub(crate) struct Latched {
    last: Arc<Mutex<Option<Last>>>,
    _queryable: Queryable<()>,
    _token: LivelinessToken,
}

#[derive(Clone)]
struct Last {
    payload: ZBytes,
    attachment: Vec<u8>,
}

impl Latched {
    /// Keeps the last message of the topic of this key, of the publisher of this number.
    pub(crate) fn new(
        session: &Session,
        key: &KeyExpr<'static>,
        id: u32,
    ) -> Result<Self, RosError> {
        let last = Arc::new(Mutex::new(None::<Last>));
        let own = format!("{key}/@adv/pub/{}/{id}/_", session.zid());
        let failed = |error: zenoh::Error| RosError::zenoh(format!("declaring {own}"), &error);
        let callback = {
            let (last, key) = (Arc::clone(&last), key.clone());
            move |query: Query| {
                let kept = lock(&last).clone();
                if let Some(kept) = kept {
                    tell(&query, &key, kept);
                }
            }
        };
        let queryable = session.declare_queryable(own.clone()).callback(callback);
        let queryable = queryable.wait().map_err(failed)?;
        let token = session.liveliness().declare_token(own.clone()).wait();
        Ok(Self {
            last,
            _queryable: queryable,
            _token: token.map_err(failed)?,
        })
    }

    /// Keeps a message in place of the one before.
    pub(crate) fn keep(&self, payload: ZBytes, attachment: Vec<u8>) {
        *lock(&self.last) = Some(Last {
            payload,
            attachment,
        });
    }

    /// Whoever comes later is given nothing, until the next message.
    pub(crate) fn forget(&self) {
        *lock(&self.last) = None;
    }
}

fn tell(query: &Query, key: &KeyExpr<'static>, last: Last) {
    let reply = query.reply(key, last.payload);
    if let Err(error) = reply.attachment(last.attachment).wait() {
        tracing::debug!(%key, %error, "the last message was not sent");
    }
}

fn lock<T>(value: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}
