//! Requests and answers between two sessions on a hub.

use std::sync::mpsc::sync_channel;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ppnpack_service::Process;
use ppnpack_service::actor::{self, Actor, Mailbox};
use ppnpack_service::alive::{Alive, announce};
use ppnpack_service::embedded::{self, Hub, hub};
use ppnpack_service::rpc::{CallError, Client, Done, Incoming, Listener, listen};
use ppnpack_wire::keys::{Cell, Instance, Service};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{
    EvaluateReply, EvaluateRequest, Heightmap, HeightmapReply, HeightmapRequest, RequestHeader,
    Status,
};
use prost::Message;
use zenoh::Wait;
use zenoh::query::Reply;

struct Pair {
    hub: Hub,
    server: Process,
    client: Client,
    session: zenoh::Session,
}

impl Pair {
    fn new(service: Service) -> Self {
        let hub = hub().unwrap();
        let server = embedded::process(&hub, service, "s1").unwrap();
        let session = embedded::session(&hub).unwrap();
        Self {
            client: Client::new(&session),
            hub,
            server,
            session,
        }
    }

    /// Begins a server that answers in a thread until it is not listened to any more.
    fn echo(&self) -> (Listener, JoinHandle<()>) {
        let (listener, mailbox) = self.mailbox(4);
        (listener, thread::spawn(move || actor::run(Echo, &mailbox)))
    }

    /// Begins a server whose mailbox the test reads.
    fn mailbox<R: Request>(&self, size: usize) -> (Listener, Mailbox<Incoming<R>>) {
        let (address, mailbox) = actor::mailbox(size);
        let listener = address.listen(&self.server, None, |incoming| incoming);
        (listener.unwrap(), mailbox)
    }

    fn ask(&self, least_state_number: u64, deadline: Instant) -> Result<HeightmapReply, CallError> {
        let request = wants(least_state_number);
        self.client.call(&cell(), request, deadline)
    }

    /// Asks this server in a thread.
    fn begin(&self, least_state_number: u64) -> JoinHandle<Result<HeightmapReply, CallError>> {
        let (client, instance) = (self.client.clone(), Instance::new("s1").unwrap());
        let request = wants(least_state_number);
        thread::spawn(move || client.call_instance(&cell(), &instance, request, soon()))
    }

    /// What the server says to this payload.
    fn send_raw(&self, key: &str, payload: &[u8]) -> Reply {
        let (sender, replies) = sync_channel(1);
        self.session
            .get(key)
            .payload(payload)
            .callback(move |reply| drop(sender.try_send(reply)))
            .wait()
            .unwrap();
        replies.recv_timeout(Duration::from_secs(10)).unwrap()
    }
}

fn cell() -> Cell {
    Cell::new("c1").unwrap()
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(20)
}

fn heightmap(state_number: u64) -> HeightmapReply {
    let heightmap = Some(Heightmap {
        state_number,
        ..Heightmap::default()
    });
    HeightmapReply {
        heightmap,
        ..HeightmapReply::default()
    }
}

fn wants(least_state_number: u64) -> HeightmapRequest {
    HeightmapRequest {
        header: None,
        least_state_number,
    }
}

fn next<R: Request>(mailbox: &Mailbox<Incoming<R>>) -> Incoming<R> {
    mailbox.receive(Some(soon())).unwrap().unwrap()
}

/// Answers with the number that it is asked for.
struct Echo;

impl Actor for Echo {
    type Message = Incoming<HeightmapRequest>;

    fn handle(&mut self, mut incoming: Self::Message) {
        let number = incoming.take().least_state_number;
        let done = Done {
            model: Some("m".to_owned()),
            ..Done::default()
        };
        incoming.reply(heightmap(number), done);
    }
}

#[test]
fn a_request_is_answered_with_its_id_and_versions() {
    let pair = Pair::new(Service::Perception);
    let (listener, thread) = pair.echo();
    let header = RequestHeader {
        request_id: "mine".to_owned(),
        ..RequestHeader::default()
    };
    let request = HeightmapRequest {
        header: Some(header),
        least_state_number: 7,
    };
    let reply = pair.client.call(&cell(), request, soon()).unwrap();
    assert_eq!(reply.heightmap.unwrap().state_number, 7);
    let header = reply.header.unwrap();
    assert_eq!((&*header.request_id, header.status()), ("mine", Status::Ok));
    assert_eq!(header.stages[0].stage, "queue");
    let versions = header.versions.unwrap();
    assert_eq!((&*versions.instance, &*versions.model), ("s1", "m"));

    // The same of one instance, several at once.
    let calls: Vec<_> = (0..3).map(|number| pair.begin(number)).collect();
    for (number, call) in calls.into_iter().enumerate() {
        let reply = call.join().unwrap().unwrap();
        assert_eq!(reply.heightmap.unwrap().state_number, number as u64);
    }
    drop(listener);
    thread.join().unwrap();
}

#[test]
fn a_refusal_says_why() {
    let pair = Pair::new(Service::Heuristic);
    let _listener = listen::<EvaluateRequest>(&pair.server, Some(&cell()), |incoming| {
        assert_eq!(incoming.cell(), &cell());
        assert!(!incoming.has_expired() && incoming.deadline() <= soon());
        let reply = EvaluateReply {
            missing_items: vec![vec![1; 32]],
            ..EvaluateReply::default()
        };
        incoming.refuse_with(reply, Status::MissingItems, "one is missing");
    })
    .unwrap();
    let called = pair
        .client
        .call(&cell(), EvaluateRequest::default(), soon());
    let error = called.unwrap_err();
    assert_eq!(error.status(), Some(Status::MissingItems));
    assert!(error.to_string().ends_with(": one is missing"), "{error}");
    let CallError::Refused { reply, .. } = error else {
        panic!("{error}")
    };
    let reply: EvaluateReply = reply.decode().unwrap();
    assert_eq!(reply.missing_items, [vec![1; 32]]);
}

#[test]
fn a_full_mailbox_refuses_as_busy_and_a_closed_one_as_unavailable() {
    let pair = Pair::new(Service::Perception);
    let (_listener, mailbox) = pair.mailbox::<HeightmapRequest>(1);
    // Insists until the server is found, which then has its mailbox full with one of the others.
    let first = pair.begin(1);
    let waiting = next(&mailbox);
    let others = [pair.begin(2), pair.begin(2)];
    while !others.iter().any(JoinHandle::is_finished) {
        thread::sleep(Duration::from_millis(5));
    }
    waiting.reply(heightmap(1), Done::default());
    assert!(first.join().unwrap().is_ok());
    next(&mailbox).reply(heightmap(2), Done::default());
    let others = others.map(|other| other.join().unwrap());
    let refused = others.iter().filter_map(|other| other.as_ref().err());
    let refused: Vec<_> = refused.map(CallError::status).collect();
    assert_eq!(refused, [Some(Status::Busy)]);
    drop(mailbox);
    let last = pair.begin(3).join().unwrap().unwrap_err();
    assert_eq!(last.status(), Some(Status::Unavailable));
}

#[test]
fn a_late_answer_is_dropped() {
    let pair = Pair::new(Service::Perception);
    let (_listener, mailbox) = pair.mailbox::<HeightmapRequest>(4);
    let asked = pair.ask(1, Instant::now() + Duration::from_millis(300));
    assert!(matches!(asked, Err(CallError::TimedOut)), "{asked:?}");
    let late = next(&mailbox);
    // The limit counts from when the request was received, which is after it was sent.
    thread::sleep(late.deadline().saturating_duration_since(Instant::now()));
    assert!(late.has_expired());
    late.reply(heightmap(1), Done::default());
    thread::spawn(move || actor::run(Echo, &mailbox));
    let next = pair.ask(2, soon()).unwrap();
    assert_eq!(next.heightmap.unwrap().state_number, 2);
}

#[test]
fn what_nobody_answers_is_asked_again_and_any_answer_to_it_counts() {
    let pair = Pair::new(Service::Perception);
    let (_listener, mailbox) = pair.mailbox::<HeightmapRequest>(4);
    let client = pair.client.clone();
    let ask = move || {
        let request = HeightmapRequest::default();
        let reply = client.call(&cell(), request, soon()).unwrap();
        reply.heightmap.unwrap().state_number
    };

    // Lost with whoever was killed: the one that comes after it is answered.
    let asking = thread::spawn(ask.clone());
    let (lost, again) = (next(&mailbox), next(&mailbox));
    assert_eq!(lost.header().request_id, again.header().request_id);
    again.reply(heightmap(1), Done::default());
    assert_eq!(asking.join().unwrap(), 1);

    // Not lost, but long: it is answered after it was asked for again.
    let asking = thread::spawn(ask);
    let (long, _again) = (next(&mailbox), next(&mailbox));
    long.reply(heightmap(2), Done::default());
    assert_eq!(asking.join().unwrap(), 2);
}

#[test]
fn what_waits_for_a_planner_that_has_gone_is_dropped() {
    let pair = Pair::new(Service::Heuristic);
    let planners = Alive::watch(pair.server.session(), Service::Planner).unwrap();
    let (_listener, mailbox) = pair.mailbox::<EvaluateRequest>(4);
    let planner = embedded::process(&pair.hub, Service::Planner, "p1").unwrap();
    let of_planner = Client::new(planner.session()).of_planner(planner.instance());
    let waiting = |client: &Client| {
        let client = client.clone();
        thread::spawn(move || client.call(&cell(), EvaluateRequest::default(), soon()));
        next(&mailbox)
    };
    let cells = [Cell::new("c1").unwrap(), Cell::new("c2").unwrap()];
    let [first, second] = cells.map(|cell| announce(&planner, Some(&cell)).unwrap());
    assert!(planners.wait(soon(), |there| there.len() == 1));

    let (asked, other) = (waiting(&of_planner), waiting(&pair.client));
    assert_eq!(asked.header().caller.as_ref(), Some(planner.instance()));
    drop(first);
    let asked = asked.still_wanted(&planners);
    let asked = asked.expect("the planner is there for another cell");
    drop(second);
    assert!(planners.wait(soon(), <[Instance]>::is_empty));
    assert!(asked.still_wanted(&planners).is_none());
    let other = other.still_wanted(&planners);
    other.expect("no planner asked").refuse(Status::Busy, "");

    // It comes back under its name: what it asks now is wanted, whether its token is seen already
    // or not.
    let asked = waiting(&of_planner).still_wanted(&planners);
    let asked = asked.expect("it asked after it had gone");
    let _token = announce(&planner, None).unwrap();
    assert!(planners.wait(soon(), |there| there.len() == 1));
    let asked = asked.still_wanted(&planners).expect("it is there");
    asked.refuse(Status::Busy, "");
}

#[test]
fn no_answer_at_all_is_no_refusal() {
    let pair = Pair::new(Service::Perception);
    let error = pair.ask(0, Instant::now() + Duration::from_millis(300));
    assert_eq!(error.unwrap_err().status(), None);
    let client = pair.client.clone();
    let call = thread::spawn(move || client.call(&cell(), wants(0), soon()));
    let _echo = pair.echo();
    assert!(call.join().unwrap().is_ok());
}

#[test]
fn malformed_requests_are_refused() {
    let pair = Pair::new(Service::Perception);
    let _echo = pair.echo();
    pair.ask(1, soon()).unwrap();
    let header = |request_id: &str, time_limit_us| {
        let header = Some(RequestHeader {
            request_id: request_id.to_owned(),
            time_limit_us,
            ..RequestHeader::default()
        });
        HeightmapRequest { header, ..wants(0) }.encode_to_vec()
    };
    let key = "ppnpack/v1/c1/rpc/perception/heightmap";
    let to_all = "ppnpack/v1/all/rpc/perception/heightmap";
    for (key, payload, request_id) in [
        (key, b"\xff\xff\xff\xff".to_vec(), ""),
        (key, Vec::new(), ""),
        (key, header("a b", 1000), ""),
        (key, header("good", 0), "good"),
        (key, header("good", u64::MAX), "good"),
        (key, vec![0; (16 << 20) + 1], ""),
        (to_all, header("good", 1000), "good"),
    ] {
        let sample = pair.send_raw(key, &payload).into_result().unwrap();
        let reply = HeightmapReply::decode(&*sample.payload().to_bytes()).unwrap();
        let header = reply.header.unwrap();
        let refused = (header.status(), &*header.request_id);
        assert_eq!(refused, (Status::Invalid, request_id), "{}", header.message);
        assert!(!header.message.is_empty());
    }
    let replied = pair.send_raw("ppnpack/v1/*/rpc/perception/heightmap", b"");
    assert!(replied.into_result().is_err());
    // After all of them it still answers.
    pair.ask(2, soon()).unwrap();
}

#[test]
fn a_dropped_request_is_answered_as_failed() {
    let pair = Pair::new(Service::Perception);
    let _listener = listen::<HeightmapRequest>(&pair.server, None, drop).unwrap();
    let error = pair.ask(1, soon()).unwrap_err();
    assert_eq!(error.status(), Some(Status::Failed), "{error}");
}

#[test]
fn health_is_answered_over_zenoh() {
    let pair = Pair::new(Service::Perception);
    let latch = pair.server.health().check("camera");
    let _token = announce(&pair.server, Some(&cell())).unwrap();
    let ask = || {
        let instance = pair.server.instance();
        let asked = pair.client.health(Service::Perception, instance, soon());
        asked.unwrap()
    };
    let reply = ask();
    assert!(!reply.is_ready && reply.uptime_ns > 0);
    assert_eq!(
        (reply.service, reply.cells),
        ("perception".to_owned(), vec!["c1".to_owned()])
    );
    assert_eq!(reply.checks[0].message, "not started");
    latch.pass();
    assert!(ask().is_ready);
}
