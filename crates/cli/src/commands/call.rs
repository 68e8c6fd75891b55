//! `ppnpack call`: one request to a service, written and answered as JSON.

use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use clap::Args;
use ppnpack_wire::keys::{Cell, Key, Method, Service};
use prost::Message;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, SerializeOptions};
use serde_json::{Value, json};
use zenoh::Wait;

use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::output::print_json;
use crate::stack::connect::ConnectOptions;

/// Sends one request to a service by hand: `ppnpack call planner plan`.
///
/// Requests and replies are the messages of the protocol (docs/protocol.md) as JSON. The header is
/// filled in.
#[derive(Debug, Args)]
pub(crate) struct CallArguments {
    /// perception, ppn, heuristic, bridge or planner
    #[arg(value_parser = |text: &str| one_of(Service::ALL, text))]
    service: Service,

    /// The method, such as plan
    #[arg(value_parser = |text: &str| one_of(Method::ALL, text))]
    method: Method,

    /// The request's fields
    #[arg(value_name = "JSON", default_value = "{}")]
    request: String,

    /// The cell
    #[arg(long, default_value = "cell-1")]
    cell: String,

    #[command(flatten)]
    connection: ConnectOptions,
}

fn one_of<T: Copy + std::fmt::Display>(all: &[T], text: &str) -> Result<T, String> {
    let found = all.iter().copied().find(|known| known.to_string() == text);
    found.ok_or_else(|| {
        let names: Vec<String> = all.iter().map(T::to_string).collect();
        format!("one of {} is possible", names.join(", "))
    })
}

pub(crate) fn run(arguments: &CallArguments) -> Outcome {
    let cell = Cell::new(&arguments.cell).or_input()?;
    let (request, reply) = messages(arguments.service, arguments.method)?;
    let deadline = arguments.connection.deadline()?;
    let id = format!("call-{:016x}", rand::random::<u64>());
    let payload = encode(request, &arguments.request, &id, deadline)?;
    let session = arguments.connection.open()?;
    let key = Key::Request(Some(cell), arguments.service, arguments.method, None);
    let answer = ask(&session, &key, &payload, deadline)?;
    let reply = DynamicMessage::decode(reply, answer.as_slice());
    let reply = reply
        .context("the answer is no message of its kind")
        .or_run()?;
    let options = SerializeOptions::new().use_proto_field_name(true);
    let value = reply.serialize_with_options(serde_json::value::Serializer, &options);
    let value = value.or_run()?;
    print_json(&value)?;
    match value.pointer("/header/status").and_then(Value::as_str) {
        Some("STATUS_OK") => Ok(()),
        status => {
            let status = status.unwrap_or("without a status");
            Err(anyhow!("the {} answered {status}", arguments.service).into())
        }
    }
}

/// All messages of the protocol.
pub(super) fn schema() -> Outcome<DescriptorPool> {
    DescriptorPool::from_file_descriptor_set(ppnpack_wire::schema().or_run()?).or_run()
}

/// The messages of a method, by the protocol's naming.
fn messages(service: Service, method: Method) -> Outcome<(MessageDescriptor, MessageDescriptor)> {
    let pool = schema()?;
    let (first, rest) = method.as_str().split_at(1);
    let name = match (service, method) {
        (Service::Bridge, Method::State) => "CellState".to_owned(),
        _ => first.to_uppercase() + rest,
    };
    let message = |kind: &str| pool.get_message_by_name(&format!("ppnpack.v1.{name}{kind}"));
    message("Request")
        .zip(message("Reply"))
        .ok_or_else(|| Failure::input(format_args!("there is no method {method} of {service}")))
}

fn encode(
    request: MessageDescriptor,
    fields: &str,
    id: &str,
    deadline: Instant,
) -> Outcome<Vec<u8>> {
    let fields = serde_json::from_str(fields).context("the request is no JSON");
    let mut fields: Value = fields.or_input()?;
    let left = deadline.saturating_duration_since(Instant::now());
    let header = json!({"request_id": id, "time_limit_us": (left.as_micros() as u64).to_string()});
    match fields.as_object_mut() {
        Some(fields) => fields.insert("header".to_owned(), header),
        None => return Err(Failure::input("the request is no JSON object")),
    };
    let message = DynamicMessage::deserialize(request, fields);
    let message = message.context("the request does not fit its message");
    Ok(message.or_input()?.encode_to_vec())
}

/// Asks until somebody answers.
fn ask(session: &zenoh::Session, key: &Key, payload: &[u8], deadline: Instant) -> Outcome<Vec<u8>> {
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            let silent = anyhow!("nobody answers {key}: `ppnpack status` shows who is alive");
            return Err(silent.into());
        }
        let (sender, replies) = sync_channel(1);
        session
            .get(key.to_string())
            .payload(payload)
            .timeout(left)
            .callback(move |reply: zenoh::query::Reply| {
                // The first answer counts.
                drop(sender.try_send(reply));
            })
            .wait()
            .map_err(|error| anyhow!("{key}: {error}"))?;
        if let Ok(Ok(sample)) = replies.recv().map(zenoh::query::Reply::into_result) {
            return Ok(sample.payload().to_bytes().into_owned());
        }
        // No answer at all: nobody serves the key just now.
        std::thread::sleep(Duration::from_millis(50));
    }
}
