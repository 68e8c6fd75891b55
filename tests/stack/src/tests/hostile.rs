//! Hostile peers: malformed payloads at every endpoint, clouds at many times the rate, subscribers
//! that never read. The services refuse, count and go on; their memory stays bounded.

use std::sync::mpsc;
use std::time::{Duration, Instant};

use crate::cell::CellClient;
use crate::stack::{Options, Stack, connect};
use crate::tests::common::{
    OBJECTS, RECOVERY, assert_consistent, assert_serves, assert_serves_again, started,
};
use ppnpack_service::clock;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::header::RequestHeader;
use ppnpack_wire::keys::{Key, Method, Service, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;
use prost::Message;
use rand::RngExt;
use zenoh::Wait;

/// The number of malformed payloads.
const PAYLOADS: usize = 100_000;

/// The maximum by which a service's memory may grow, in MiB.
const GROWTH_MIB: f64 = 64.0;

const SERVICES: [&str; 4] = ["planner-1", "heuristic-1", "perception-1", "bridge-1"];

fn memory(stack: &Stack) -> [f64; 4] {
    SERVICES.map(|name| stack.resident_mib(name).unwrap())
}

fn assert_memory_bounded(stack: &Stack, before: [f64; 4]) {
    for ((name, before), now) in SERVICES.iter().zip(before).zip(memory(stack)) {
        let grown = now - before;
        assert!(
            grown < GROWTH_MIB,
            "{name}: grown by {grown:.0} MiB to {now:.0}"
        );
    }
}

/// An endpoint, and a payload that is nearly right.
struct Target {
    method: Method,
    key: String,
    valid: Vec<u8>,
    /// Whether a payload is a whole request that may change something: such a one is not sent.
    is_whole: fn(&[u8]) -> bool,
}

/// An endpoint that refuses this request, or only tells something.
fn harmless<R: Request>(cell: &CellClient, request: R) -> Target {
    Target {
        is_whole: |_| false,
        ..changing(cell, request)
    }
}

/// An endpoint that may do what this request asks for.
fn changing<R: Request>(cell: &CellClient, request: R) -> Target {
    to(cell, R::SERVICE.unwrap(), request)
}

fn to<R: Request>(cell: &CellClient, service: Service, mut request: R) -> Target {
    request.set_header(v1::RequestHeader {
        request_id: "hostile".to_owned(),
        time_limit_us: 50_000,
        caller: "planner-1".to_owned(),
        ..v1::RequestHeader::default()
    });
    let key = Key::Request(Some(cell.cell().clone()), service, R::METHOD, None);
    Target {
        method: R::METHOD,
        key: key.to_string(),
        valid: request.encode_to_vec(),
        is_whole: |payload| {
            ppnpack_wire::decode::<R>(payload, MAX_MESSAGE_BYTES)
                .is_ok_and(|request| RequestHeader::read(request.header()).is_ok())
        },
    }
}

/// Every endpoint of the stack.
fn targets(cell: &CellClient) -> Vec<Target> {
    let seen = cell.ask(v1::HeightmapRequest::default()).unwrap();
    let evaluate = v1::EvaluateRequest {
        scene: seen.heightmap.unwrap().scene,
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
    use Service::{Bridge, Heuristic, Perception, Planner};
    let healths = [Planner, Heuristic, Perception, Bridge];
    let healths = healths.map(|service| to(cell, service, v1::HealthRequest::default()));
    let mut targets = vec![
        harmless(cell, v1::HeightmapRequest::default()),
        harmless(cell, v1::ItemsRequest::default()),
        harmless(cell, v1::InspectRequest::default()),
        // Nobody answers these here.
        harmless(cell, v1::ProposeRequest::default()),
        harmless(cell, v1::TakeOverRequest::default()),
        harmless(cell, v1::CarryOutRequest::default()),
        harmless(cell, v1::BringEmptyRequest::default()),
        harmless(cell, evaluate),
        harmless(cell, place),
        harmless(cell, v1::OutcomeRequest::default()),
        harmless(cell, v1::RenewRequest::default()),
        changing(cell, v1::HoldRequest::default()),
        changing(cell, v1::ResumeRequest::default()),
        changing(cell, v1::ChangedRequest::default()),
        harmless(cell, v1::CellStateRequest::default()),
        changing(cell, v1::BeginRequest::default()),
        harmless(cell, v1::AnnounceRequest::default()),
        harmless(cell, v1::WithdrawRequest::default()),
        changing(cell, v1::PlanRequest::default()),
        harmless(cell, v1::ReportRequest::default()),
        harmless(cell, v1::OpenRequest::default()),
        changing(cell, v1::CloseRequest::default()),
        harmless(cell, v1::ExplainRequest::default()),
        changing(cell, v1::AutomaticRequest::default()),
        harmless(cell, v1::SessionRequest::default()),
        harmless(cell, v1::ShapesRequest::default()),
    ];
    targets.extend(healths);
    targets
}

/// A malformed request, or one that is whole where that changes nothing.
fn malformed_for(random: &mut impl rand::Rng, target: &Target) -> Vec<u8> {
    loop {
        let payload = malformed(random, &target.valid);
        if !(target.is_whole)(&payload) {
            return payload;
        }
    }
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
    let (stack, cell) = started(&Options::default());
    cell.begin("hostile", &OBJECTS, false).unwrap();
    cell.step().unwrap().unwrap();
    let (session, state) = (cell.session().unwrap(), cell.state().unwrap());
    let before = memory(&stack);
    let targets = targets(&cell);
    let mut methods = Method::ALL.iter();
    let left_out = methods.find(|method| targets.iter().all(|target| target.method != **method));
    assert_eq!(left_out, None);
    let mut random = rand::rng();
    use Stream::{Cloud, Heightmap, Outcome, TrayCloud};
    let streams = [Cloud, TrayCloud, Heightmap, Outcome];
    for round in 0..PAYLOADS {
        if round % 4 == 0 {
            let stream = streams[round / 4 % streams.len()];
            let key = Key::Stream(cell.cell().clone(), stream).to_string();
            let valid = v1::PointCloud::default().encode_to_vec();
            let payload = malformed(&mut random, &valid);
            stack.session().put(key, payload).wait().unwrap();
        } else {
            let target = &targets[random.random_range(0..targets.len())];
            let payload = malformed_for(&mut random, target);
            // Answers are not waited for: the services have to cope with the pace.
            let asked = stack.session().get(&target.key).payload(payload);
            asked.callback(|_| {}).wait().unwrap();
        }
        if round % 1000 == 999 {
            // Nor does the sender run away: what is in flight is limited by an honest request now
            // and then.
            assert_serves(&cell, Instant::now() + RECOVERY, "in between");
        }
    }
    assert_serves_again(&cell, Instant::now(), "malformed payloads");
    assert_memory_bounded(&stack, before);
    let now = cell.state().unwrap();
    assert_eq!((now.state_number, now.hold), (state.state_number, None));
    assert_eq!(cell.session().unwrap(), session);
    assert_consistent(&cell, "afterwards");
    assert!(cell.step().unwrap().is_some());
}

#[test]
fn clouds_at_many_times_the_rate_are_dropped_and_memory_stays_bounded() {
    let (stack, cell) = started(&Options::default());
    cell.begin("flood", &OBJECTS, false).unwrap();
    cell.step().unwrap().unwrap();
    let before = memory(&stack);
    let key = Key::Stream(cell.cell().clone(), Stream::Cloud).to_string();
    // The simulated sensor sends two a second, of 16,384 points each: these come at ten times the
    // rate, and each has eighteen times the points. They are newer than its own, and show the same.
    let mut cloud = cloud_of(&stack, &key, cell.state().unwrap().state_number);
    let points = cloud.data.len() / cloud.point_stride as usize;
    cloud.data = cloud.data.repeat(18);
    let until = Instant::now() + Duration::from_secs(20);
    while Instant::now() < until {
        cloud.sequence += 1;
        cloud.captured_at_ns = i64::try_from(clock::now_ns()).unwrap();
        let payload = cloud.encode_to_vec();
        stack.session().put(&key, payload).wait().unwrap();
        std::thread::sleep(Duration::from_millis(50));
    }
    let seen = cell.ask(v1::HeightmapRequest::default()).unwrap();
    let quality = seen.heightmap.unwrap().quality.unwrap();
    let measured = quality.points_measured;
    assert!(measured > 10 * points as u64, "none was mapped: {measured}");
    assert_serves_again(&cell, Instant::now(), "a flood of clouds");
    assert_memory_bounded(&stack, before);
    assert!(cell.step().unwrap().is_some());
    assert_consistent(&cell, "afterwards");
}

/// Waits for the sensor's cloud of this state.
fn cloud_of(stack: &Stack, key: &str, state_number: u64) -> v1::PointCloud {
    let (sender, clouds) = mpsc::channel();
    let subscriber = stack.session().declare_subscriber(key);
    let _subscriber = subscriber
        .callback(move |sample| {
            sender.send(sample.payload().to_bytes().into_owned()).ok();
        })
        .wait()
        .unwrap();
    loop {
        let payload = clouds.recv_timeout(RECOVERY).unwrap();
        let cloud = v1::PointCloud::decode(payload.as_slice()).unwrap();
        if cloud.state_number == state_number {
            return cloud;
        }
    }
}

#[test]
fn a_subscriber_that_never_reads_holds_nobody_up() {
    let (stack, cell) = started(&Options::default());
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
