//! Heightmaps that are planned on, over a real session.

use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Done, Incoming, Listener};
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::Service;

use super::*;

const LIMITS: SceneLimits = SceneLimits {
    age: Duration::from_secs(5),
    sensor_latency: Duration::from_secs(1),
};

fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

fn in_ms(span: u64) -> Instant {
    Instant::now() + Duration::from_millis(span)
}

fn heightmap(sequence: u64, state_number: u64, quality: v1::HeightmapQuality) -> v1::Heightmap {
    let grid = Grid::reference();
    let scene = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
    v1::Heightmap {
        id: Some(v1::HeightmapId { epoch: 1, sequence }),
        state_number,
        scene: Some(convert::scene::write(&grid, &scene)),
        quality: Some(quality),
        ..v1::Heightmap::default()
    }
}

fn hand() -> v1::HeightmapQuality {
    v1::HeightmapQuality {
        doubts: vec![v1::Doubt {
            kind: v1::DoubtKind::Intrusion.into(),
            message: "something reaches in".to_owned(),
        }],
        ..v1::HeightmapQuality::default()
    }
}

/// A planner's view of a cell, and who plays perception.
struct Rig {
    scenes: Scenes,
    heightmaps: Publisher<v1::Heightmap>,
    planner: Process,
    perception: Process,
    _hub: Hub,
}

impl Rig {
    fn new() -> Self {
        Self::with(LIMITS)
    }

    fn with(limits: SceneLimits) -> Self {
        let hub = embedded::hub().unwrap();
        let planner = embedded::process(&hub, Service::Planner, "planner-1").unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        Self {
            scenes: Scenes::subscribe(&planner, &cell(), &Grid::reference(), limits).unwrap(),
            heightmaps: Publisher::new(&perception, &cell(), Stream::Heightmap).unwrap(),
            planner,
            perception,
            _hub: hub,
        }
    }

    /// Publishes a heightmap, and answers with it, until the planner has it.
    fn show(&mut self, heightmap: &v1::Heightmap) {
        let _listener = self.answer(heightmap.clone(), Duration::ZERO);
        for _ in 0..200 {
            self.heightmaps.put(heightmap).unwrap();
            self.scenes.current(u64::MAX, in_ms(50)).ok();
            let newest = self.scenes.newest.as_ref();
            if newest.is_some_and(|newest| Some(newest.id) == heightmap.id) {
                return;
            }
        }
        panic!("it never came");
    }

    /// Publishes a heightmap until it came; gives when.
    fn publish_until_it_came(&self, heightmap: &v1::Heightmap) -> Boottime {
        // Subscribed after the scenes: what comes here has come there, too.
        let other: Latest<v1::Heightmap> =
            Latest::subscribe(&self.planner, &cell(), Stream::Heightmap, MAX_MESSAGE_BYTES)
                .unwrap();
        loop {
            self.heightmaps.put(heightmap).unwrap();
            if let Some(arrived) = other.wait(in_ms(50)) {
                return arrived.at;
            }
        }
    }

    /// Answers requests with a heightmap of this age.
    fn answer(&self, heightmap: v1::Heightmap, age: Duration) -> Listener {
        let answer = move |incoming: Incoming<v1::HeightmapRequest>| {
            let reply = v1::HeightmapReply {
                header: None,
                heightmap: Some(heightmap.clone()),
                age_ns: age.as_nanos() as u64,
            };
            incoming.reply(reply, Done::default());
        };
        rpc::listen(&self.perception, Some(&cell()), answer).unwrap()
    }
}

#[test]
fn nothing_is_planned_on_a_doubtful_scene_or_on_an_older_one() {
    let mut rig = Rig::new();
    rig.show(&heightmap(1, 3, v1::HeightmapQuality::default()));
    assert_eq!(rig.scenes.current(3, in_ms(0)).unwrap().id.sequence, 1);
    rig.show(&heightmap(2, 3, hand()));
    let refused = rig.scenes.current(3, in_ms(50)).unwrap_err();
    assert!(
        refused.contains("doubtful: something reaches in"),
        "{refused}"
    );
    rig.show(&heightmap(3, 3, v1::HeightmapQuality::default()));
    assert_eq!(rig.scenes.current(3, in_ms(0)).unwrap().id.sequence, 3);
}

#[test]
fn nothing_is_planned_on_a_scene_that_is_denied_until_it_is_reconsidered_or_a_newer_one_comes() {
    let mut rig = Rig::new();
    rig.show(&heightmap(1, 3, v1::HeightmapQuality::default()));
    let first = rig.scenes.current(3, in_ms(0)).unwrap();
    rig.scenes.deny(&first, "item a is away".to_owned());
    let refused = rig.scenes.current(3, in_ms(50)).unwrap_err();
    assert!(refused.contains("doubtful: item a is away"), "{refused}");
    rig.scenes.reconsider();
    assert_eq!(rig.scenes.current(3, in_ms(0)).unwrap().id.sequence, 1);
    rig.scenes.deny(&first, "item a is away".to_owned());
    rig.show(&heightmap(2, 3, v1::HeightmapQuality::default()));
    assert_eq!(rig.scenes.current(3, in_ms(0)).unwrap().id.sequence, 2);
    // Of an older one nothing is told.
    rig.scenes.deny(&first, "item a is away".to_owned());
    assert!(rig.scenes.current(3, in_ms(0)).is_ok());
}

#[test]
fn a_heightmap_that_perception_has_had_for_long_is_stale_to_a_new_planner() {
    let mut rig = Rig::new();
    let old = heightmap(1, 3, v1::HeightmapQuality::default());
    let listener = rig.answer(old.clone(), LIMITS.age + Duration::from_secs(2));
    let refused = rig.scenes.current(3, in_ms(1000)).unwrap_err();
    assert!(refused.contains("the newest heightmap came"), "{refused}");
    drop(listener);

    let mut rig = Rig::new();
    let _listener = rig.answer(old, LIMITS.age / 2);
    assert!(rig.scenes.current(3, in_ms(20_000)).is_ok());
}

#[test]
fn a_heightmap_that_was_held_up_on_its_way_from_perception_is_as_old_as_it_is() {
    let mut rig = Rig::with(SceneLimits {
        sensor_latency: Duration::ZERO,
        ..LIMITS
    });
    rig.scenes.changed(Boottime::now());
    let old = heightmap(1, 0, v1::HeightmapQuality::default());
    let _listener = rig.answer(old.clone(), LIMITS.age / 2);
    rig.publish_until_it_came(&old);
    let refused = rig.scenes.current(0, in_ms(1000)).unwrap_err();
    assert!(
        refused.contains("no cloud came since the last report"),
        "{refused}"
    );
}

#[test]
fn a_heightmap_ages_while_nothing_is_planned() {
    let limits = SceneLimits {
        age: Duration::from_millis(200),
        ..LIMITS
    };
    let mut rig = Rig::with(limits);
    let heightmap = heightmap(1, 3, v1::HeightmapQuality::default());
    let came = rig.publish_until_it_came(&heightmap);
    while came.elapsed() < 2 * limits.age {
        std::thread::sleep(limits.age);
    }
    let refused = rig.scenes.current(3, in_ms(0)).unwrap_err();
    assert!(refused.contains("the newest heightmap came"), "{refused}");
}

#[test]
fn a_cloud_that_was_on_its_way_does_not_show_the_change() {
    let mut rig = Rig::new();
    rig.show(&heightmap(1, 0, v1::HeightmapQuality::default()));
    assert!(rig.scenes.current(0, in_ms(0)).is_ok());
    rig.scenes.changed(Boottime::now());
    let changed = Instant::now();
    assert!(rig.scenes.current(0, in_ms(0)).is_err());
    for sequence in 2.. {
        rig.show(&heightmap(sequence, 0, v1::HeightmapQuality::default()));
        if rig.scenes.current(0, in_ms(0)).is_ok() {
            break;
        }
        assert!(changed.elapsed() < Duration::from_secs(30), "never");
    }
    assert!(changed.elapsed() > LIMITS.sensor_latency);

    // The heightmap is new, its cloud is not.
    let mut rig = Rig::with(SceneLimits {
        age: Duration::from_secs(60),
        sensor_latency: Duration::ZERO,
    });
    rig.scenes.changed(Boottime::now());
    let slow = v1::HeightmapQuality {
        processing_ns: 30_000_000_000,
        ..v1::HeightmapQuality::default()
    };
    rig.show(&heightmap(u64::MAX, 0, slow));
    let refused = rig.scenes.current(0, in_ms(0)).unwrap_err();
    assert!(
        refused.contains("no cloud came since the last report"),
        "{refused}"
    );
}

#[test]
fn a_heightmap_of_another_cell_is_not_planned_on() {
    let mut rig = Rig::new();
    let of = |cell: &str, state_number| v1::Heightmap {
        cell: cell.to_owned(),
        ..heightmap(1, state_number, v1::HeightmapQuality::default())
    };
    rig.scenes.take_over(Ok(of("cell-2", 9)), Duration::ZERO);
    assert!(rig.scenes.newest.is_none());
    let complaint = &rig.scenes.complaint;
    assert!(complaint.contains("of cell cell-2"), "{complaint}");
    rig.scenes.take_over(Ok(of("cell-1", 7)), Duration::ZERO);
    let seen = rig.scenes.current(0, in_ms(1000)).unwrap();
    assert_eq!(seen.state_number, 7);
}

#[test]
fn nothing_is_planned_while_two_perceptions_of_different_settings_serve_a_cell() {
    let of = |epoch, sequence, settings| v1::Heightmap {
        id: Some(v1::HeightmapId { epoch, sequence }),
        settings,
        ..heightmap(1, 3, v1::HeightmapQuality::default())
    };
    let mut rig = Rig::new();
    let mut plan_on = |heightmap, age| {
        rig.scenes.take_over(Ok(heightmap), age);
        rig.scenes.current(3, in_ms(0)).map(|seen| seen.id.epoch)
    };
    let now = Duration::ZERO;
    assert_eq!(plan_on(of(1, 1, 7), now), Ok(1));
    // Started anew with the same settings.
    assert_eq!(plan_on(of(2, 1, 7), now), Ok(2));
    for sequence in 1..4 {
        for (epoch, settings) in [(3, 8), (2, 7)] {
            let refused = plan_on(of(epoch, sequence + 1, settings), now).unwrap_err();
            assert!(refused.contains("two perceptions"), "{refused}");
        }
    }

    // Started anew with others, after its pictures of before are too old.
    let mut rig = Rig::new();
    let old = LIMITS.age + Duration::from_secs(1);
    rig.scenes.take_over(Ok(of(1, 1, 7)), old);
    rig.scenes.take_over(Ok(of(2, 1, 8)), now);
    assert_eq!(rig.scenes.current(3, in_ms(0)).unwrap().id.epoch, 2);
}
