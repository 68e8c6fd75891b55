//! What goes with a request so that its answer belongs to the same trace; `one_trace_spans_...` of
//! the stack's tests has the spans.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use opentelemetry::trace::TracerProvider;
use opentelemetry_sdk::trace::SdkTracerProvider;
use ppnpack_service::embedded::{self, hub};
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::HeightmapRequest;
use tracing_subscriber::Layer;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use zenoh::Wait;

#[test]
fn a_request_names_its_trace_and_without_telemetry_nothing_is_attached() {
    let hub = hub().unwrap();
    let server = embedded::process(&hub, Service::Perception, "s1").unwrap();
    let session = embedded::session(&hub).unwrap();
    let cell = Cell::new("c1").unwrap();
    let attached = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&attached);
    let queryable = server
        .session()
        .declare_queryable("ppnpack/v1/c1/rpc/perception/heightmap")
        .callback(move |query| {
            let text = query
                .attachment()
                .map(|it| it.try_to_string().unwrap().into_owned());
            kept.lock().unwrap().push(text);
            query.reply_err("enough").wait().unwrap();
        });
    let _queryable = queryable.wait().unwrap();
    let call = || {
        let deadline = Instant::now() + Duration::from_millis(300);
        let called = Client::new(&session).call(&cell, HeightmapRequest::default(), deadline);
        assert!(called.is_err());
    };
    call();
    let provider = SdkTracerProvider::builder().build();
    let layer = tracing_opentelemetry::layer().with_tracer(provider.tracer("test"));
    let ours =
        tracing_subscriber::filter::Targets::new().with_target("ppnpack", tracing::Level::TRACE);
    tracing_subscriber::registry()
        .with(layer.with_filter(ours))
        .init();
    call();
    let seen = attached.lock().unwrap();
    assert_eq!(seen.first(), Some(&None));
    let parent = seen.last().unwrap().as_deref().unwrap();
    assert!(parent.len() == 55 && parent.starts_with("00-"), "{parent}");
}
