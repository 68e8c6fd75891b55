//! One trace over a caller and who answers.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use opentelemetry::trace::{SpanKind, TracerProvider};
use opentelemetry_sdk::error::OTelSdkResult;
use opentelemetry_sdk::trace::{SdkTracerProvider, SpanData, SpanExporter};
use ppnpack_service::embedded::{self, hub};
use ppnpack_service::rpc::{Client, Done, listen};
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{HeightmapReply, HeightmapRequest};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use zenoh::Wait;

#[derive(Debug)]
struct Exporter(Mutex<Sender<SpanData>>);

impl SpanExporter for Exporter {
    async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
        for span in batch {
            self.0.lock().unwrap().send(span).unwrap();
        }
        Ok(())
    }
}

#[test]
fn a_trace_spans_processes_and_without_telemetry_nothing_is_attached() {
    let hub = hub().unwrap();
    let server = embedded::process(&hub, Service::Perception, "s1").unwrap();
    let session = embedded::session(&hub).unwrap();
    let cell = Cell::new("c1").unwrap();
    let call = |milliseconds| {
        let deadline = Instant::now() + Duration::from_millis(milliseconds);
        Client::new(&session).call(&cell, HeightmapRequest::default(), deadline)
    };
    let attached = Arc::new(Mutex::new(Vec::new()));
    let raw = server
        .session()
        .declare_queryable("ppnpack/v1/c1/rpc/perception/heightmap")
        .callback({
            let attached = attached.clone();
            move |query| {
                let text = query
                    .attachment()
                    .map(|bytes| bytes.try_to_string().unwrap().into_owned());
                attached.lock().unwrap().push(text);
                query.reply_err("enough").wait().unwrap();
            }
        })
        .wait()
        .unwrap();
    assert!(call(300).is_err());
    let (sender, spans) = channel();
    let provider = SdkTracerProvider::builder()
        .with_simple_exporter(Exporter(Mutex::new(sender)))
        .build();
    let layer = tracing_opentelemetry::layer().with_tracer(provider.tracer("test"));
    let ours =
        tracing_subscriber::filter::Targets::new().with_target("ppnpack", tracing::Level::TRACE);
    tracing_subscriber::registry()
        .with(layer.with_filter(ours))
        .init();
    assert!(call(300).is_err());
    let seen = std::mem::take(&mut *attached.lock().unwrap());
    assert_eq!(seen.first(), Some(&None));
    let parent = seen.last().unwrap().as_deref().unwrap();
    assert!(parent.len() == 55 && parent.starts_with("00-"), "{parent}");
    raw.undeclare().wait().unwrap();
    while spans.try_recv().is_ok() {}

    let _listener = listen::<HeightmapRequest>(&server, None, |incoming| {
        let entered = incoming.span().clone().entered();
        tracing::info_span!(target: "ppnpack_test", "work").in_scope(|| ());
        drop(entered);
        incoming.reply(HeightmapReply::default(), Done::default());
    })
    .unwrap();
    call(20_000).unwrap();
    let mut served = None;
    let mut worked = None;
    let mut called = None;
    while served.is_none() || worked.is_none() || called.is_none() {
        let span = spans.recv_timeout(Duration::from_secs(10)).unwrap();
        match (&span.span_kind, span.name.as_ref()) {
            (SpanKind::Server, "perception/heightmap") => served = Some(span),
            (SpanKind::Client, "perception/heightmap") => called = Some(span),
            (_, "work") => worked = Some(span),
            other => panic!("{other:?}"),
        }
    }
    let (served, worked, called) = (served.unwrap(), worked.unwrap(), called.unwrap());
    assert_eq!(
        served.span_context.trace_id(),
        worked.span_context.trace_id()
    );
    assert_eq!(worked.parent_span_id, served.span_context.span_id());
    // The call that was answered is the last of those that were made.
    let calls: Vec<SpanData> = std::iter::once(called).chain(spans.try_iter()).collect();
    let parent = calls
        .iter()
        .find(|call| call.span_context.span_id() == served.parent_span_id);
    let parent = parent.expect("the parent of the answer is a call");
    assert_eq!(
        parent.span_context.trace_id(),
        served.span_context.trace_id()
    );
}
