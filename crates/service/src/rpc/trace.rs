//! One trace over several processes: W3C trace context in Zenoh's attachments.
//!
//! The attachment is the value of the header `traceparent`. Spans have a level that only the layer
//! of the traces enables: without it they cost a look at a flag, and nothing is attached.

use opentelemetry::Context;
use opentelemetry::propagation::{Extractor, Injector, TextMapPropagator};
use opentelemetry_sdk::propagation::TraceContextPropagator;
use ppnpack_wire::keys::{Method, Service};
use tracing::{Level, Span};
use tracing_opentelemetry::OpenTelemetrySpanExt;
use zenoh::bytes::ZBytes;

pub(crate) const TARGET: &str = "ppnpack::trace";

const HEADER: &str = "traceparent";

/// Maximum size of an attachment that is read, in bytes; a traceparent has 55.
const MAX_ATTACHMENT_BYTES: usize = 128;

/// Makes the span of a request that is sent.
pub(super) fn calling(service: Service, method: Method) -> Span {
    tracing::span!(
        target: TARGET,
        Level::TRACE,
        "call",
        otel.name = %format_args!("{service}/{method}"),
        otel.kind = "client",
    )
}

/// Makes the span of a request that is answered, within the trace of its caller.
pub(super) fn serving(
    service: Service,
    method: Method,
    request_id: &str,
    attachment: Option<&ZBytes>,
) -> Span {
    let span = tracing::span!(
        target: TARGET,
        Level::TRACE,
        "request",
        otel.name = %format_args!("{service}/{method}"),
        otel.kind = "server",
        request_id,
    );
    if !span.is_disabled()
        && let Some(context) = attachment.and_then(read)
    {
        // Fails only where no layer wants traces.
        span.set_parent(context).ok();
    }
    span
}

/// Makes the attachment of a request, by which its answer belongs to the same trace.
pub(super) fn attachment(span: &Span) -> Option<ZBytes> {
    if span.is_disabled() {
        return None;
    }
    let mut carrier = Carrier(None);
    TraceContextPropagator::new().inject_context(&span.context(), &mut carrier);
    carrier.0.map(ZBytes::from)
}

fn read(attachment: &ZBytes) -> Option<Context> {
    if attachment.len() > MAX_ATTACHMENT_BYTES {
        return None;
    }
    let text = attachment.try_to_string().ok()?.into_owned();
    Some(TraceContextPropagator::new().extract_with_context(&Context::new(), &Carrier(Some(text))))
}

struct Carrier(Option<String>);

impl Injector for Carrier {
    fn set(&mut self, key: &str, value: String) {
        if key == HEADER {
            self.0 = Some(value);
        }
    }
}

impl Extractor for Carrier {
    fn get(&self, key: &str) -> Option<&str> {
        self.0.as_deref().filter(|_| key == HEADER)
    }

    fn keys(&self) -> Vec<&str> {
        vec![HEADER]
    }
}
