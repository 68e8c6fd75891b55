//! What a process logs, read by another session. One test: the log is the whole process's.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use ppnpack_service::embedded;
use ppnpack_service::log_stream;
use ppnpack_wire::debug::{Log, LogLevel};
use ppnpack_wire::keys::Instance;
use prost::Message;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

const PATIENCE: Duration = Duration::from_secs(20);

/// Logs this until a reader has a line of it: the process hears a little later that somebody reads.
fn logged_until_read(lines: &Receiver<Log>, log: impl Fn()) -> Log {
    let deadline = Instant::now() + PATIENCE;
    while Instant::now() < deadline {
        log();
        if let Ok(line) = lines.recv_timeout(Duration::from_millis(50)) {
            return line;
        }
    }
    panic!("no line came");
}

#[test]
fn lines_are_published_with_their_fields_while_somebody_reads() {
    tracing_subscriber::registry()
        .with(log_stream::layer())
        .init();
    let hub = embedded::hub().unwrap();
    let session = embedded::session(&hub).unwrap();
    let name = Instance::new("planner-1").unwrap();
    let published = log_stream::publish(&session, &name).unwrap();
    assert!(
        log_stream::publish(&session, &name).is_err(),
        "a process has one log"
    );
    tracing::warn!("nobody reads this");

    let reader = embedded::session(&hub).unwrap();
    let (sender, lines) = sync_channel(1000);
    let subscription = log_stream::subscribe(&reader, move |line| {
        let line = Log::decode(line.to_bytes().as_ref()).unwrap();
        sender.try_send(line).ok();
    });
    let line = logged_until_read(
        &lines,
        || tracing::info!(target: "ppnpack_planner", cell = "cell-1", step = 3, "decided"),
    );
    let told = line.0;
    assert_eq!(told.message, "decided cell=cell-1 step=3");
    assert_eq!(told.level, i32::from(LogLevel::Info));
    assert_eq!(told.name, "planner-1");
    assert!(told.file.ends_with("log_stream.rs"), "{}", told.file);
    assert!(told.line > 0 && told.timestamp.is_some());

    // Of others only what is wrong, and nothing of Zenoh.
    tracing::info!(target: "hyper", "a connection");
    tracing::error!(target: "zenoh::net", "publishing makes such lines");
    let long = "ä".repeat(10_000);
    tracing::error!(target: "hyper", "{long}");
    let others = std::iter::from_fn(|| lines.recv_timeout(PATIENCE).ok());
    let mut others = others.map(|line| line.0.message);
    let next = others.find(|message| message != "decided cell=cell-1 step=3");
    assert_eq!(next, Some("ä".repeat(4096)));

    drop((subscription, published));
    // Another one may follow where one has ended.
    drop(log_stream::publish(&session, &name).unwrap());
}
