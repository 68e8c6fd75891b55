//! Access: the requests that are answered, and the controls that are carried out.
//!
//! Pages of other origins are kept out by the host that a browser asks for, so that no name of
//! somebody else can lead here, by what the browser says of the site that asks, and by the origin
//! of a control. Controls ask for a token besides.

use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::http::header::{
    AUTHORIZATION, CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, HeaderMap,
    HeaderName, HeaderValue, ORIGIN, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use ppnpack_service::configuration::Secret;
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep};

use super::Served;
use super::failure::Failure;
use crate::settings::NO_TOKEN;

/// The policy of a page: it may run its own files, and asks for nothing elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// How long the answer to a wrong token takes; the next waits for it.
const WRONG_TOKEN: Duration = Duration::from_millis(200);

/// Minimum time between two lines of the log about wrong tokens.
const TOLD: Duration = Duration::from_secs(1);

/// The token and the names of the server.
pub(crate) struct Access {
    /// The hash of the token, which is compared in a time that tells nothing of it; none where
    /// controls are off.
    token: Option<blake3::Hash>,
    /// The names of the server, beside its addresses.
    hosts: Vec<String>,
    /// Wrong tokens that the log has not told of.
    wrong: AtomicU64,
    /// The time when the log told of some. A wrong token is answered under this lock.
    told: Mutex<Option<Instant>>,
}

impl Access {
    pub(crate) fn new(token: Option<&Secret>, hosts: &[String]) -> Self {
        let hash = |token: &Secret| blake3::hash(token.reveal().as_bytes());
        Self {
            token: token.map(hash),
            hosts: hosts.to_vec(),
            wrong: AtomicU64::default(),
            told: Mutex::default(),
        }
    }

    fn check_host(&self, headers: &HeaderMap) -> Result<(), Failure> {
        let host = text(headers, HOST).unwrap_or_default();
        if self.is_own(name_of(host)) {
            return Ok(());
        }
        let text = format!("'{host}' is no name of this server: add it to service.hosts");
        Err(Failure::forbidden("other_host", text))
    }

    fn is_own(&self, name: &str) -> bool {
        let is_local = name.eq_ignore_ascii_case("localhost");
        name.parse::<IpAddr>().is_ok() || is_local || self.is_named(name)
    }

    fn is_named(&self, name: &str) -> bool {
        let mut hosts = self.hosts.iter();
        hosts.any(|host| host.eq_ignore_ascii_case(name))
    }

    /// Refuses a control that may not be made. Wrong tokens are refused one after the other,
    /// slowly; nobody else waits.
    pub(super) async fn admit(&self, headers: &HeaderMap) -> Result<(), Failure> {
        let checked = self.check_control(headers);
        if let Err(failure) = &checked
            && failure.is_of_token()
        {
            self.wrong.fetch_add(1, Ordering::Relaxed);
            let mut told = self.told.lock().await;
            sleep(WRONG_TOKEN).await;
            if told.is_none_or(|told| told.elapsed() >= TOLD) {
                let tries = self.wrong.swap(0, Ordering::Relaxed);
                tracing::warn!(tries, "controls without the token");
                *told = Some(Instant::now());
            }
        }
        checked
    }

    fn check_control(&self, headers: &HeaderMap) -> Result<(), Failure> {
        self.check_origin(headers)?;
        let off = || Failure::forbidden("controls_off", NO_TOKEN);
        let token = self.token.as_ref().ok_or_else(off)?;
        let given = text(headers, AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer "));
        // Hashes are compared in constant time.
        if given.is_none_or(|given| blake3::hash(given.as_bytes()) != *token) {
            return Err(Failure::token());
        }
        check_type(headers)
    }

    /// Refuses a control from a page of another origin. A client that is no page has none. The page
    /// itself has TLS only behind a proxy, whose name is configured.
    fn check_origin(&self, headers: &HeaderMap) -> Result<(), Failure> {
        let Some(origin) = headers.get(ORIGIN) else {
            return Ok(());
        };
        let origin = origin.to_str().unwrap_or_default().split_once("://");
        let host = text(headers, HOST).unwrap_or_default();
        let is_own = |(scheme, from): (&str, &str)| {
            let is_possible = scheme == "http" || scheme == "https" && self.is_named(name_of(host));
            is_possible && from.eq_ignore_ascii_case(host)
        };
        if origin.is_some_and(is_own) {
            return Ok(());
        }
        let text = "this came from a page of another origin";
        Err(Failure::forbidden("other_origin", text))
    }
}

/// Gives the name in an authority, without its port.
fn name_of(authority: &str) -> &str {
    if let Some(rest) = authority.strip_prefix('[') {
        return rest.split_once(']').map_or("", |(address, _)| address);
    }
    authority.split(':').next().unwrap_or_default()
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    headers.get(name)?.to_str().ok()
}

/// Refuses a request from a page of another site. It could not read the answer, but could take up
/// all pages that may be connected, or a planner's time. A link from there may lead to the page and
/// its files. A client that is no browser says nothing of this.
fn check_site(path: &str, headers: &HeaderMap) -> Result<(), Failure> {
    let said = |name: &'static str| text(headers, HeaderName::from_static(name));
    let is_foreign = matches!(said("sec-fetch-site"), Some("cross-site" | "same-site"));
    let is_link = said("sec-fetch-mode") == Some("navigate") && !path.starts_with("/api");
    if !is_foreign || is_link {
        return Ok(());
    }
    let text = "this was asked for by a page of another site";
    Err(Failure::forbidden("other_origin", text))
}

fn check_type(headers: &HeaderMap) -> Result<(), Failure> {
    let given = text(headers, CONTENT_TYPE).unwrap_or_default();
    let kind = given.split(';').next().unwrap_or_default().trim();
    if kind.eq_ignore_ascii_case("application/json") {
        return Ok(());
    }
    let text = "Content-Type: application/json is needed";
    let status = StatusCode::UNSUPPORTED_MEDIA_TYPE;
    Err(Failure::new(status, "not_json", text))
}

/// Looks at every request before it is answered, and gives every answer the headers that keep a
/// page to itself.
pub(super) async fn guard(
    State(served): State<Arc<Served>>,
    request: Request,
    next: Next,
) -> Response {
    let (path, asked) = (request.uri().path(), request.headers());
    let checked = served.access.check_host(asked);
    let mut response = match checked.and_then(|()| check_site(path, asked)) {
        Ok(()) => next.run(request).await,
        Err(failure) => failure.into_response(),
    };
    let headers = response.headers_mut();
    let resources = HeaderName::from_static("cross-origin-resource-policy");
    for (name, value) in [
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (resources, "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    let unless_said = headers.entry(CACHE_CONTROL);
    unless_said.or_insert(HeaderValue::from_static("no-store"));
    response
}

#[cfg(test)]
mod tests {
    use futures_util::future::join;

    use super::*;

    const TOKEN: &str = "0123456789abcdef";

    fn access(token: Option<&str>) -> Access {
        let token = token.map(|token| Secret::from(token.to_owned()));
        Access::new(token.as_ref(), &["cell.example".to_owned()])
    }

    fn headers(pairs: &[(HeaderName, &str)]) -> HeaderMap {
        let pairs = pairs.iter().cloned();
        let pairs = pairs.map(|(name, value)| (name, value.parse().unwrap()));
        pairs.collect()
    }

    fn code(result: Result<(), Failure>) -> String {
        result.map_or_else(|failure| failure.code().to_owned(), |()| "ok".to_owned())
    }

    #[test]
    fn the_page_is_asked_for_by_addresses_and_its_own_names_alone() {
        let access = access(None);
        for (host, expected) in [
            ("127.0.0.1:8770", "ok"),
            ("[::1]:8770", "ok"),
            ("localhost", "ok"),
            ("LOCALHOST:1", "ok"),
            ("cell.example:443", "ok"),
            ("10.0.0.7", "ok"),
            ("evil.example", "other_host"),
            ("", "other_host"),
            ("127.0.0.1.evil.example", "other_host"),
            ("[::1", "other_host"),
            ("localhost.evil.example:8770", "other_host"),
        ] {
            let checked = access.check_host(&headers(&[(HOST, host)]));
            assert_eq!(code(checked), expected, "{host}");
        }
        assert_eq!(code(access.check_host(&HeaderMap::new())), "other_host");
    }

    #[test]
    fn pages_of_other_sites_ask_for_nothing_and_may_lead_here() {
        let from = |path, site, mode| {
            let names = ["sec-fetch-site", "sec-fetch-mode"].map(HeaderName::from_static);
            let [of_site, of_mode] = names;
            let headers = headers(&[(of_site, site), (of_mode, mode)]);
            code(check_site(path, &headers))
        };
        let events = "/api/events";
        assert_eq!(code(check_site(events, &HeaderMap::new())), "ok");
        for (path, site, mode, expected) in [
            (events, "same-origin", "cors", "ok"),
            (events, "none", "navigate", "ok"),
            ("/", "cross-site", "navigate", "ok"),
            ("/main.js", "same-site", "navigate", "ok"),
            (events, "cross-site", "navigate", "other_origin"),
            ("/", "cross-site", "no-cors", "other_origin"),
            (events, "same-site", "cors", "other_origin"),
        ] {
            assert_eq!(from(path, site, mode), expected, "{path} {site} {mode}");
        }
    }

    #[test]
    fn a_control_needs_its_own_origin_the_token_and_json() {
        let bearer = format!("Bearer {TOKEN}");
        let own = [(HOST, "127.0.0.1:1"), (ORIGIN, "http://127.0.0.1:1")];
        let check = |token, more: &[(HeaderName, &str)]| {
            let headers = headers(&[&own[..], more].concat());
            code(access(token).check_control(&headers))
        };
        let (right, json) = (bearer.as_str(), "application/json; charset=utf-8");
        let given = |given, kind| [(AUTHORIZATION, given), (CONTENT_TYPE, kind)];
        assert_eq!(check(None, &given(right, json)), "controls_off");
        assert_eq!(check(Some(TOKEN), &[]), "token");
        for (token, kind, expected) in [
            (right, json, "ok"),
            ("Bearer 0123456789abcdeF", json, "token"),
            ("Bearer ", json, "token"),
            (TOKEN, json, "token"),
            ("Basic 0123456789abcdef", json, "token"),
            (right, "", "not_json"),
            (right, "text/plain", "not_json"),
        ] {
            let checked = check(Some(TOKEN), &given(token, kind));
            assert_eq!(checked, expected, "{token} {kind}");
        }
        for (host, origin, expected) in [
            ("127.0.0.1:1", "http://evil.example", "other_origin"),
            ("127.0.0.1:1", "null", "other_origin"),
            ("127.0.0.1:1", "http://127.0.0.1:2", "other_origin"),
            ("127.0.0.1:1", "", "other_origin"),
            ("127.0.0.1:1", "https://127.0.0.1:1", "other_origin"),
            ("cell.example", "https://cell.example", "ok"),
            ("cell.example", "http://cell.example", "ok"),
            ("cell.example", "ftp://cell.example", "other_origin"),
        ] {
            let headers = headers(&[
                (HOST, host),
                (ORIGIN, origin),
                (AUTHORIZATION, right),
                (CONTENT_TYPE, json),
            ]);
            let checked = code(access(Some(TOKEN)).check_control(&headers));
            assert_eq!(checked, expected, "{host} {origin}");
        }
    }

    #[test]
    fn wrong_tokens_wait_for_one_another_and_hold_up_no_right_one() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .unwrap();
        let access = access(Some(TOKEN));
        let json = (CONTENT_TYPE, "application/json");
        let right = format!("Bearer {TOKEN}");
        let right = headers(&[(AUTHORIZATION, right.as_str()), json.clone()]);
        let wrong = headers(&[(AUTHORIZATION, "Bearer another-token"), json]);
        let guess = async || {
            assert_eq!(code(access.admit(&wrong).await), "token");
            Instant::now()
        };
        let began = Instant::now();
        let guesses = async { join(guess(), guess()).await };
        let admitted = async {
            assert_eq!(code(access.admit(&right).await), "ok");
            Instant::now()
        };
        let ((first, second), admitted) = runtime.block_on(join(guesses, admitted));
        assert!(admitted < first, "a right token waited for a wrong one");
        assert!(first - began >= WRONG_TOKEN && second - first >= WRONG_TOKEN);
        assert_eq!(access.wrong.load(Ordering::Relaxed), 0, "both are told of");
    }
}
