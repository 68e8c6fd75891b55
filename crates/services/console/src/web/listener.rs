//! Connections, of which there is a bounded number, and of which none is kept that nobody uses.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Router;
use axum::extract::Request;
use axum::serve::Listener;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use ppnpack_service::sync::lock;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::{Instant, Sleep, sleep};

/// Connections at most: where there are as many, one gives way to each that comes.
const MOST_CONNECTIONS: usize = 256;

/// How long a connection may take to ask for something: from its beginning, or from the answer
/// before.
pub(super) const MOST_HEAD: Duration = Duration::from_secs(5);

/// How long nothing may come or go on a connection before it is closed: longer than any control
/// takes. Pages are told something every second; one that has gone without a word, as a tablet that
/// sleeps, takes nothing any more.
const MOST_IDLE: Duration = Duration::from_secs(60);

/// The use of a connection. Of two the lesser gives way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    stage: Stage,
    /// When it began, or the last of an answer went.
    since: Instant,
}

/// How far a connection has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// Nothing was asked for.
    Silent,
    /// A request is answered, or its answer is on its way.
    Answered,
    /// A request is being done.
    Asked,
}

type Shared = Arc<Mutex<Use>>;

struct Open {
    used: Shared,
    task: AbortHandle,
}

/// Serves a router to all who connect, as long as the runtime lives.
pub(super) async fn serve(mut listener: TcpListener, router: Router, most_head: Duration) {
    let router = TowerToHyperService::new(router);
    let mut open: Vec<Open> = Vec::new();
    loop {
        let (stream, _) = Listener::accept(&mut listener).await;
        open.retain(|one| !one.task.is_finished());
        if open.len() >= MOST_CONNECTIONS {
            let uses = open.iter().map(|one| *lock(&one.used)).enumerate();
            if let Some((least, _)) = uses.min_by_key(|(_, used)| *used) {
                open.swap_remove(least).task.abort();
            }
        }
        let used = Arc::new(Mutex::new(Use {
            stage: Stage::Silent,
            since: Instant::now(),
        }));
        let answering = answer(stream, Arc::clone(&used), router.clone(), most_head);
        let task = tokio::spawn(answering).abort_handle();
        open.push(Open { used, task });
    }
}

/// Answers what is asked on a connection until it ends.
async fn answer(
    stream: TcpStream,
    used: Shared,
    router: TowerToHyperService<Router>,
    most_head: Duration,
) {
    // A change is to be seen at once; where that is not possible, a little later.
    stream.set_nodelay(true).ok();
    let connection = Connection {
        stream,
        used: Arc::clone(&used),
        idle: Box::pin(sleep(MOST_IDLE)),
    };
    let service = service_fn(move |request: Request<Incoming>| {
        lock(&used).stage = Stage::Asked;
        let (used, done) = (Arc::clone(&used), router.call(request));
        async move {
            let answer = done.await;
            *lock(&used) = Use {
                stage: Stage::Answered,
                since: Instant::now(),
            };
            answer
        }
    });
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(most_head)
        .serve_connection(TokioIo::new(connection), service)
        .await;
    if let Err(error) = served {
        tracing::debug!(%error, "a connection ended");
    }
}

/// The stream of a connection, which fails once nobody uses it.
struct Connection {
    stream: TcpStream,
    used: Shared,
    /// Ends once nothing has come or gone for too long.
    idle: Pin<Box<Sleep>>,
}

impl Connection {
    /// Notes that something has come or gone.
    fn touch(&mut self) {
        self.idle.as_mut().reset(Instant::now() + MOST_IDLE);
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        if read.is_ready() {
            self.touch();
            return read;
        }
        let over = self.idle.as_mut().poll(context);
        over.map(|()| Err(io::ErrorKind::TimedOut.into()))
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        if written.is_ready() {
            self.touch();
            lock(&self.used).since = Instant::now();
        }
        written
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{ErrorKind, Read, Write};
    use std::net::{Ipv4Addr, SocketAddr, TcpStream};

    use axum::routing::get;
    use tokio::runtime::Runtime;

    use super::*;

    /// The longest that anything here may take.
    const PATIENCE: Duration = Duration::from_secs(60);

    /// A page that says "held", as long as the runtime lives.
    fn page(most_head: Duration) -> (Runtime, SocketAddr) {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .unwrap();
        let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
        let listener = runtime.block_on(listener).unwrap();
        let address = listener.local_addr().unwrap();
        let router = Router::new().route("/hold", get(|| async { "held" }));
        runtime.spawn(serve(listener, router, most_head));
        (runtime, address)
    }

    fn send(address: SocketAddr, text: &str) -> TcpStream {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(text.as_bytes()).unwrap();
        stream
    }

    fn assert_closed(mut stream: TcpStream) {
        let ended = stream.read_to_end(&mut Vec::new());
        let is_reset = |error: io::Error| error.kind() == ErrorKind::ConnectionReset;
        assert!(ended.is_ok() || ended.is_err_and(is_reset));
    }

    #[test]
    fn connections_on_which_nobody_asks_give_way() {
        let (_runtime, address) = page(PATIENCE * 60);
        let halves: Vec<_> = (0..300).map(|_| send(address, "GET /hold HT")).collect();
        let asked = "GET /hold HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";
        let mut answer = String::new();
        send(address, asked).read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200 ") && answer.ends_with("held"));
        assert_closed(halves.into_iter().next().unwrap());
    }

    #[test]
    fn half_a_request_is_waited_for_only_so_long() {
        let (_runtime, address) = page(Duration::from_millis(50));
        assert_closed(send(address, "GET /hold HT"));
        let asked = "GET /hold HTTP/1.1\r\nHost: a\r\n\r\n";
        assert_closed(send(address, asked));
    }

    #[test]
    fn what_is_being_done_gives_way_last_and_the_oldest_first() {
        let now = Instant::now();
        let of = |stage, age_s| Use {
            stage,
            since: now - Duration::from_secs(age_s),
        };
        let in_order = [
            of(Stage::Silent, 1),
            of(Stage::Silent, 0),
            of(Stage::Answered, 9),
            of(Stage::Answered, 0),
            of(Stage::Asked, 9),
        ];
        assert!(in_order.is_sorted());
    }
}
