//! Traces, sent to a collector as OTLP over HTTP.

use std::time::Duration;

use async_trait::async_trait;
use opentelemetry::KeyValue;
use opentelemetry::trace::TracerProvider;
use opentelemetry_http::{Bytes, HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{Protocol, SpanExporter, WithExportConfig, WithHttpConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{Sampler, SdkTracerProvider};
use tracing::Level;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;

use crate::configuration::TelemetrySettings;
use crate::error::ServiceError;
use crate::http;
use crate::logs::BoxedLayer;
use crate::process::Core;
use crate::rpc::TRACE_TARGET;

const TIMEOUT: Duration = Duration::from_secs(5);

/// Sends spans; without a collector it does nothing.
#[derive(Default)]
pub(crate) struct Telemetry {
    provider: Option<SdkTracerProvider>,
}

impl Telemetry {
    pub(crate) fn start(settings: &TelemetrySettings, core: &Core) -> Result<Self, ServiceError> {
        let Some(endpoint) = &settings.otlp else {
            return Ok(Self::default());
        };
        let exporter = SpanExporter::builder()
            .with_http()
            .with_http_client(Collector)
            .with_protocol(Protocol::HttpBinary)
            .with_endpoint(endpoint)
            .with_timeout(TIMEOUT)
            .build()
            .map_err(|error| {
                ServiceError::start(format_args!("traces cannot be set up: {error}"))
            })?;
        let instance = core.instance.to_string();
        let resource = Resource::builder()
            .with_service_name(format!("ppnpack-{}", core.service))
            .with_attribute(KeyValue::new("service.instance.id", instance))
            .with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION")))
            .build();
        let sampler = Sampler::TraceIdRatioBased(settings.sampled_share);
        let provider = SdkTracerProvider::builder()
            .with_resource(resource)
            .with_sampler(Sampler::ParentBased(Box::new(sampler)))
            // Has a queue with a bound, and a thread of its own.
            .with_batch_exporter(exporter)
            .build();
        Ok(Self {
            provider: Some(provider),
        })
    }

    /// Makes the layer that turns the spans of this project into those of OpenTelemetry.
    pub(crate) fn layer(&self) -> Option<BoxedLayer> {
        let tracer = self.provider.as_ref()?.tracer("ppnpack");
        let filter = Targets::new()
            .with_target("ppnpack", Level::INFO)
            .with_target(TRACE_TARGET, Level::TRACE);
        let layer = tracing_opentelemetry::layer().with_tracer(tracer);
        Some(layer.with_filter(filter).boxed())
    }

    /// Sends what was not sent yet.
    pub(crate) fn finish(self, timeout: Duration) {
        if let Some(provider) = self.provider
            && let Err(error) = provider.shutdown_with_timeout(timeout)
        {
            tracing::warn!(%error, "some spans were not sent");
        }
    }
}

/// Sends to the collector from the exporter's own thread, which may wait.
#[derive(Debug)]
struct Collector;

#[async_trait]
impl HttpClient for Collector {
    async fn send_bytes(&self, request: Request<Bytes>) -> Result<Response<Bytes>, HttpError> {
        let uri = request.uri();
        let authority = uri.authority();
        let authority = authority.ok_or("the address of the collector has no host")?;
        let mut authority = authority.to_string();
        if uri.port().is_none() {
            authority.push_str(":80");
        }
        let path = uri.path_and_query().map_or("/", |path| path.as_str());
        let mut head = format!("POST {path} HTTP/1.1\r\n");
        for (name, value) in request.headers() {
            head.push_str(&format!("{name}: {}\r\n", value.to_str()?));
        }
        let answer = http::exchange(&authority, &head, request.body(), TIMEOUT)?;
        // Only the status of the answer matters here.
        let response = Response::builder().status(answer.status);
        Ok(response.body(Bytes::new())?)
    }
}
