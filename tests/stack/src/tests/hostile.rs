//! What others may send: malformed payloads at every endpoint, clouds at many times the rate, subscribers that never
//! read. The services refuse, count and go on; their memory stays bounded.

use std::time::{Duration, Instant};

use crate::cell::CellClient;
use crate::stack::{Options, Stack, connect};
use crate::tests::common::{
    OBJECTS, RECOVERY, assert_consistent, assert_serves, assert_serves_again,
};
use ppnpack_wire::keys::{Key, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;
use prost::Message;
use rand::RngExt;
use zenoh::Wait;

/// Malformed payloads sent in all.
const PAYLOADS: usize = 100_000;

/// What a service may take in memory beyond what it took before, in MiB.
const GROWTH_MIB: f64 = 64.0;

const SERVICES: [&str; 4] = ["planner-1", "heuristic-1", "perception-1", "bridge-1"];

fn memory(stack: &Stack) -> Vec<f64> {
    SERVICES
        .iter()
        .map(|name| stack.resident_mib(name).unwrap())
        .collect()
}

fn assert_memory_bounded(stack: &Stack, before: &[f64]) {
    for (name, before) in SERVICES.iter().zip(before) {
        let now = stack.resident_mib(name).unwrap();
        assert!(
            now < before + GROWTH_MIB,
            "{name}: {before:.0} MiB before, {now:.0} MiB now"
        );
    }
}

/// A request with its key and a valid payload to start from.
fn target<R: Request>(cell: &CellClient, mut request: R) -> (String, Vec<u8>) {
    request.set_header(v1::RequestHeader {
        request_id: "hostile".to_owned(),
        time_limit_us: 50_000,
        caller: "planner-1".to_owned(),
        ..v1::RequestHeader::default()
    });
    let service = R::SERVICE.unwrap();
    let key = Key::Request(Some(cell.cell().clone()), service, R::METHOD, None);
    (key.to_string(), request.encode_to_vec())
}

/// Every endpoint of the stack, with a payload that is nearly right.
fn targets(cell: &CellClient) -> Vec<(String, Vec<u8>)> {
    let heightmap = cell
        .ask(v1::HeightmapRequest::default())
        .unwrap()
        .heightmap
        .unwrap();
    let scene = heightmap.scene;
    let evaluate = v1::EvaluateRequest {
        scene,
        candidates: vec![v1::CandidateItem {
            item_id: vec![7; 32],
            arrival: 0,
            pose: 0,
        }],
        items: vec![v1::Item {
            name: "thing".to_owned(),
            views: vec![v1::ItemView::default(); 4],
            mesh_volume_m3: 0.1,
        }],
        parts: vec![v1::SearchPart {
            candidate: 0,
            proposals: None,
        }],
        objective: Some(v1::Objective {
            heuristic: v1::Heuristic::Sdfm.into(),
            ..v1::Objective::default()
        }),
        limit: 1,
        ..v1::EvaluateRequest::default()
    };
    let place = v1::PlaceRequest {
        placement_id: "hostile".to_owned(),
        item_id: "x".to_owned(),
        object: "mug".to_owned(),
        container_from_item: Some(v1::Pose::default()),
        state_number: 1,
        ..v1::PlaceRequest::default()
    };
    vec![
        target(cell, v1::HeightmapRequest::default()),
        target(cell, evaluate),
        target(cell, place),
        target(cell, v1::OutcomeRequest::default()),
        target(cell, v1::CellStateRequest::default()),
        target(cell, v1::AnnounceRequest::default()),
        target(cell, v1::WithdrawRequest::default()),
        target(cell, v1::ReportRequest::default()),
        target(cell, v1::OpenRequest::default()),
        target(cell, v1::ExplainRequest::default()),
        target(cell, v1::SessionRequest::default()),
    ]
}

/// Random bytes, or a valid message with some bytes changed, cut off or repeated.
fn malformed(random: &mut impl rand::Rng, valid: &[u8]) -> Vec<u8> {
    match random.random_range(0..4) {
        0 => (0..random.random_range(0..200))
            .map(|_| random.random())
            .collect(),
        1 => valid[..random.random_range(0..=valid.len())].to_vec(),
        2 => valid.repeat(random.random_range(2..4)),
        _ => {
            let mut bytes = valid.to_vec();
            for _ in 0..random.random_range(1..8) {
                if !bytes.is_empty() {
                    let at = random.random_range(0..bytes.len());
                    bytes[at] = random.random();
                }
            }
            bytes
        }
    }
}

#[test]
fn malformed_payloads_at_every_endpoint_change_nothing() {
    let stack = Stack::start(&Options::default()).unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("hostile", &OBJECTS, false).unwrap();
    cell.step().unwrap().unwrap();
    let (session, state) = (cell.session().unwrap(), cell.state().unwrap());
    let before = memory(&stack);
    let targets = targets(&cell);
    let mut random = rand::rng();
    let streams = [Stream::Cloud, Stream::Heightmap, Stream::Outcome];
    for round in 0..PAYLOADS {
        if round % 4 == 0 {
            let stream = streams[round / 4 % streams.len()];
            let key = Key::Stream(cell.cell().clone(), stream).to_string();
            let valid = v1::PointCloud::default().encode_to_vec();
            stack
                .session()
                .put(key, malformed(&mut random, &valid))
                .wait()
                .unwrap();
        } else {
            let (key, valid) = &targets[round % targets.len()];
            let payload = malformed(&mut random, valid);
            // Answers are not waited for: the services have to cope with the pace.
            stack
                .session()
                .get(key)
                .payload(payload)
                .callback(|_| {})
                .wait()
                .unwrap();
        }
        if round % 1000 == 999 {
            // Nor does the sender run away: what is in flight is limited by an honest request now and then.
            assert_serves(&cell, Instant::now() + RECOVERY, "in between");
        }
    }
    assert_serves_again(&cell, Instant::now(), "malformed payloads");
    assert_memory_bounded(&stack, &before);
    assert_eq!(cell.state().unwrap().state_number, state.state_number);
    assert_eq!(cell.session().unwrap().step, session.step);
    assert_consistent(&cell, "afterwards");
    assert!(cell.step().unwrap().is_some());
}

#[test]
fn clouds_at_many_times_the_rate_are_dropped_and_memory_stays_bounded() {
    let stack = Stack::start(&Options::default()).unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("flood", &OBJECTS, false).unwrap();
    cell.step().unwrap().unwrap();
    let before = memory(&stack);
    let key = Key::Stream(cell.cell().clone(), Stream::Cloud).to_string();
    let cloud = v1::PointCloud {
        sequence: 1,
        point_stride: 12,
        fields: ["x", "y", "z"]
            .iter()
            .zip([0, 4, 8])
            .map(|(name, offset)| v1::PackedField {
                name: (*name).to_owned(),
                offset,
                r#type: v1::NumericType::Float32.into(),
            })
            .collect(),
        data: vec![0; 12 * 300_000],
        ..v1::PointCloud::default()
    };
    let payload = cloud.encode_to_vec();
    // The simulated sensor sends two a second, of 16,384 points each: these come at ten times the rate, and each has
    // eighteen times the points.
    let until = Instant::now() + Duration::from_secs(20);
    while Instant::now() < until {
        stack.session().put(&key, payload.clone()).wait().unwrap();
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_serves_again(&cell, Instant::now(), "a flood of clouds");
    assert_memory_bounded(&stack, &before);
    assert!(cell.step().unwrap().is_some());
    assert_consistent(&cell, "afterwards");
}

#[test]
fn a_subscriber_that_never_reads_holds_nobody_up() {
    let stack = Stack::start(&Options::default()).unwrap();
    let cell = stack.cell(0).unwrap();
    // Its channel is full after one message, which then blocks its session.
    let slow = connect(&stack.endpoint).unwrap();
    let _subscriber = slow
        .declare_subscriber("ppnpack/v1/*/*")
        .with(zenoh::handlers::FifoChannel::new(1))
        .wait()
        .unwrap();
    cell.begin("unread", &OBJECTS[..10], false).unwrap();
    while cell.step().unwrap().is_some() {}
    assert_consistent(&cell, "at the end");
}
