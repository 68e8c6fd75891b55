//! One trace spans planner and services, as a collector of OpenTelemetry gets it.

use std::io::{BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use crate::http;
use crate::tests::common::{self, OBJECTS};
use opentelemetry_proto::tonic::collector::trace::v1::ExportTraceServiceRequest;
use opentelemetry_proto::tonic::common::v1::any_value::Value;
use opentelemetry_proto::tonic::trace::v1::Span;
use ppnpack_wire::keys::Service;
use prost::Message;

/// The maximum time for spans, which are sent every few seconds.
const LIMIT: Duration = Duration::from_secs(30);

/// A span, and the service that sent it.
#[derive(Debug)]
struct Sent {
    service: String,
    span: Span,
}

/// Takes what services send, each request on a connection of its own or on one that is kept.
fn collector() -> (String, mpsc::Receiver<Sent>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/v1/traces", listener.local_addr().unwrap());
    let (sender, spans) = mpsc::channel();
    std::thread::spawn(move || {
        for connection in listener.incoming().flatten() {
            let sender = sender.clone();
            std::thread::spawn(move || while take(&connection, &sender).is_some() {});
        }
    });
    (address, spans)
}

/// Reads a request and answers it; `None` at the end of the connection.
fn take(connection: &TcpStream, sender: &mpsc::Sender<Sent>) -> Option<()> {
    let mut reader = BufReader::new(connection);
    http::line(&mut reader).ok()?;
    let headers = http::headers(&mut reader).ok()?;
    let length = headers.get("content-length")?.parse().ok()?;
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    let request = ExportTraceServiceRequest::decode(&*body).ok()?;
    for resource in request.resource_spans {
        let mut attributes = resource.resource.unwrap_or_default().attributes.into_iter();
        let name = attributes.find(|pair| pair.key == "service.name");
        let Some(Value::StringValue(service)) = name?.value?.value else {
            return None;
        };
        let scopes = resource.scope_spans.into_iter();
        for span in scopes.flat_map(|scope| scope.spans) {
            let service = service.clone();
            sender.send(Sent { service, span }).ok()?;
        }
    }
    let answer = b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n";
    (&mut &*connection).write_all(answer).ok()
}

fn find<'a>(spans: &'a [Sent], service: &str, name: &str, parent: &[u8]) -> Option<&'a Span> {
    let is_it = |sent: &&Sent| {
        let is_child = parent.is_empty() || sent.span.parent_span_id == parent;
        sent.service == service && sent.span.name == name && is_child
    };
    spans.iter().find(is_it).map(|sent| &sent.span)
}

/// The span of the heuristic service within that of the planner's plan, where all came.
fn trace(spans: &[Sent]) -> Option<(&Span, &Span)> {
    let plan = find(spans, "ppnpack-planner", "planner/plan", &[])?;
    let answer_to = |call: &Span| {
        let name = "heuristic/evaluate";
        let is_part = call.name == name && call.trace_id == plan.trace_id;
        let answer = || find(spans, "ppnpack-heuristic", name, &call.span_id);
        is_part.then(answer).flatten()
    };
    let answer = spans.iter().find_map(|sent| answer_to(&sent.span))?;
    Some((plan, answer))
}

#[test]
fn one_trace_spans_the_planner_and_the_services_that_it_asks() {
    let (address, spans) = collector();
    let otlp = format!("telemetry.otlp={address}");
    let settings = [Service::Planner, Service::Heuristic]
        .map(|of| [(of, otlp.as_str()), (of, "telemetry.sampled_share=1.0")]);
    let (_stack, cell) = common::started(&common::with(settings.as_flattened()));
    cell.begin("traced", &OBJECTS, false).unwrap();
    cell.plan().unwrap().unwrap();

    let until = Instant::now() + LIMIT;
    let mut came = Vec::new();
    let (plan, answer) = loop {
        if let Some((plan, answer)) = trace(&came) {
            break (plan.clone(), answer.clone());
        }
        let left = until.saturating_duration_since(Instant::now());
        let next = spans.recv_timeout(left);
        came.push(next.unwrap_or_else(|_| panic!("the trace is not whole: {came:?}")));
    };
    assert_eq!(plan.trace_id, answer.trace_id);
    assert!(plan.start_time_unix_nano <= answer.start_time_unix_nano);
    assert!(answer.end_time_unix_nano <= plan.end_time_unix_nano);
}
