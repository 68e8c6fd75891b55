//! Clouds in, heightmaps out, over a real session.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, GridSettings, Units};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_perception_service::{Fate, Settings};
use ppnpack_service::Process;
use ppnpack_service::embedded;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::convert::scene;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::v1::{self, Status};
use prost::Message;

use crate::rig::{PATIENCE, Rig, Sensor, at_state, cell, until};

/// A cloud with a point in every sample of a grid's surface, at the height that `height_m` gives.
fn cloud_of(
    grid: &Grid,
    state_number: u64,
    sequence: u64,
    height_m: impl Fn(usize, usize) -> Option<f32>,
) -> v1::PointCloud {
    let empty = Surface::empty(grid);
    let middle = |index: usize| ((index as f64 + 0.5) * empty.pitch_m()) as f32;
    let places = (0..empty.nx()).flat_map(|x| (0..empty.ny()).map(move |y| (x, y)));
    let points: Vec<Point3<f32>> = places
        .filter_map(|(x, y)| Some(Point3::new(middle(x), middle(y), height_m(x, y)?)))
        .collect();
    let capture = Capture {
        sequence,
        captured_at_ns: 1_700_000_000_000_000_000,
        state_number,
        container_from_sensor: Isometry3::identity(),
    };
    cloud::write(&capture, &points)
}

fn flat(state_number: u64, sequence: u64) -> v1::PointCloud {
    cloud_of(&Grid::reference(), state_number, sequence, |_, _| Some(0.0))
}

fn settings() -> Settings {
    Settings {
        // No test takes so long that a late cloud would be taken for a new beginning.
        sensor_restart_after_s: 600.0,
        grid: GridSettings::from(&Grid::reference()),
        ..Settings::default()
    }
}

fn rig(settings: &Settings) -> Rig {
    Rig::with(settings, Stream::Cloud, |_| None)
}

impl Rig {
    /// Shows the cell in its state 1 until that is seen: from then on clouds arrive.
    fn connected(settings: &Settings) -> Self {
        let rig = rig(settings);
        rig.show(flat(1, 0), &at_state(1));
        rig
    }

    fn seen(&self, least_state_number: u64) -> v1::Heightmap {
        self.ask_for(&cell(), least_state_number, PATIENCE).unwrap()
    }

    fn status(&self, cell: &Cell, least_state_number: u64) -> Status {
        let request = at_state(least_state_number);
        self.refused(cell, &request, Duration::from_millis(500)).0
    }
}

#[test]
fn a_second_perception_of_a_cell_waits_and_serves_its_other_cells_meanwhile() {
    let hub = embedded::hub().unwrap();
    let process = || embedded::process(&hub, Service::Perception, "perception-1").unwrap();
    let start = |process: &Process, cells: &[&str]| {
        let cells = cells.iter();
        let settings = Settings {
            cells: cells
                .map(|name| ((*name).to_owned(), settings().grid))
                .collect(),
            has_unlisted_cells: false,
            ..settings()
        };
        ppnpack_perception_service::start(process, &settings, None).unwrap()
    };
    let (of_first, second) = (process(), process());
    let first = start(&of_first, &["cell-1"]);
    let starting = std::thread::spawn({
        let second = second.clone();
        move || start(&second, &["cell-1", "cell-2"])
    });

    let sensor = embedded::process(&hub, Service::Bridge, "sensor").unwrap();
    let free = Cell::new("cell-2").unwrap();
    let clouds = Sensor::new(&sensor, &free, Stream::Cloud);
    let client = Client::new(sensor.session());
    let mut cloud = flat(1, 0);
    until("no heightmap", || {
        cloud.sequence += 1;
        clouds.put(&cloud);
        let soon = Instant::now() + Duration::from_secs(1);
        client.call(&free, at_state(0), soon).ok()
    });
    let waits = "another perception, instance perception-1, serves cell cell-1";
    until(waits, || {
        std::thread::sleep(Duration::from_millis(10));
        let checks = second.health().report();
        checks
            .into_iter()
            .find(|check| check.message.contains(waits))
    });
    assert!(!starting.is_finished() && !second.health().is_ready());
    drop(first);
    drop(starting.join().unwrap());
}

fn read(heightmap: &v1::Heightmap) -> (Grid, Scene) {
    scene::read(heightmap.scene.as_ref().unwrap()).unwrap()
}

fn are_all(heightmap: &v1::Heightmap, height: Units) -> bool {
    let (_, scene) = read(heightmap);
    let mut heights = scene.heightmap().heights().iter();
    heights.all(|found| *found == height)
}

#[test]
fn the_actor_of_a_cell_that_does_not_come_back_from_a_cloud_would_be_noticed() {
    let rig = Rig::connected(&settings());
    let watched = rig.process.supervisor().watched();
    assert!(watched.contains(&"perception-cell-1".to_owned()));
}

#[test]
fn a_cloud_becomes_the_heightmap_that_its_surface_gives() {
    let rig = Rig::connected(&settings());
    let heightmaps: Latest<v1::Heightmap> =
        Latest::subscribe(&rig.sensor, &cell(), Stream::Heightmap, MAX_MESSAGE_BYTES).unwrap();
    let grid = Grid::reference();
    let height_m = |x: usize, y: usize| (x * 7 + y * 3) as f32 * 1e-4;
    let mut surface = Surface::empty(&grid);
    for (x, y) in (0..128).flat_map(|x| (0..128).map(move |y| (x, y))) {
        surface.raise(x, y, height_m(x, y));
    }
    let expected = Scene::from_surface(&grid, surface).unwrap();
    let before = rig.seen(1).id.unwrap();

    rig.clouds
        .put(&cloud_of(&grid, 2, 1, |x, y| Some(height_m(x, y))));
    let heightmap = rig.seen(2);
    assert_eq!(read(&heightmap), (grid, expected));
    let id = heightmap.id.unwrap();
    assert_eq!((id.epoch, id.sequence), (before.epoch, before.sequence + 1));
    assert_eq!(heightmap.state_number, 2);
    assert_eq!(heightmap.captured_at_ns, 1_700_000_000_000_000_000);
    let quality = heightmap.quality.unwrap();
    let counts = (quality.points_inside, quality.unknown_cells, quality.cells);
    assert_eq!(counts, (128 * 128, 0, 1024));
    assert!(quality.processing_ns > 0);

    // The subscription may have come too late for that one.
    rig.clouds.put(&flat(3, 1));
    let published = std::iter::from_fn(|| heightmaps.wait(Instant::now() + PATIENCE));
    let published = published
        .map(|arrived| arrived.message.unwrap())
        .find(|published| published.state_number == 3);
    assert_eq!(published.unwrap(), rig.seen(3));
}

#[test]
fn who_waits_for_a_state_holds_nobody_up() {
    let rig = Rig::connected(&settings());
    std::thread::scope(|scope| {
        let waiting: Vec<_> = (0..4).map(|_| scope.spawn(|| rig.seen(9))).collect();
        for _ in 0..20 {
            assert_eq!(rig.seen(1).state_number, 1);
        }
        rig.clouds.put(&flat(8, 1));
        assert_eq!(rig.seen(8).state_number, 8);
        assert!(waiting.iter().all(|waiting| !waiting.is_finished()));
        rig.clouds.put(&flat(9, 1));
        for waiting in waiting {
            assert_eq!(waiting.join().unwrap().state_number, 9);
        }
    });
}

#[test]
fn who_waits_in_vain_is_told_why() {
    let rig = Rig::connected(&settings());
    assert_eq!(rig.status(&cell(), 2), Status::TimedOut);
    let other = Cell::new("cell-2").unwrap();
    assert_eq!(rig.status(&other, 0), Status::Unavailable);
}

#[test]
fn malformed_clouds_are_refused_and_counted() {
    let rig = Rig::connected(&settings());
    let malformed: [fn(&mut v1::PointCloud); 3] = [
        |cloud| cloud.container_from_sensor = None,
        |cloud| cloud.fields.truncate(2),
        |cloud| cloud.data.truncate(100),
    ];
    for change in malformed {
        let mut cloud = flat(2, 1);
        change(&mut cloud);
        rig.send_refused(&cloud, Fate::Malformed);
    }
    assert_eq!(rig.seen(0).state_number, 1);
    rig.clouds.put(&flat(2, 1));
    assert_eq!(rig.seen(2).state_number, 2);
}

#[test]
fn a_sensor_with_noise_that_repeats_itself_shows_nothing_new() {
    let mut settings = settings();
    settings.mapper.noise_m = 0.001;
    let rig = Rig::connected(&settings);
    // The next state, by its number, and the points of the one before: a driver that is stuck.
    rig.send_refused(&flat(2, 1), Fate::Repeated);
    assert_eq!(rig.status(&cell(), 2), Status::TimedOut);
    rig.clouds
        .put(&cloud_of(&Grid::reference(), 2, 2, |_, _| Some(0.001)));
    assert_eq!(rig.seen(2).state_number, 2);
}

#[test]
fn late_clouds_are_refused_and_counted() {
    let rig = Rig::connected(&settings());
    rig.clouds.put(&flat(5, 7));
    let newest = rig.seen(5);
    for (state_number, sequence) in [(5, 7), (5, 6), (4, 100), (0, 100)] {
        rig.send_refused(&flat(state_number, sequence), Fate::Late);
    }
    assert_eq!(rig.seen(0), newest);
}

#[test]
fn what_no_point_shows_is_higher_than_the_rim() {
    let rig = Rig::connected(&settings());
    let grid = Grid::reference();
    // Cells (10, 20) and (11, 20) are in the dark, but for a hole in one of them that is no point.
    let in_the_dark = |x: usize, y: usize| (40..48).contains(&x) && (80..84).contains(&y);
    let height_m = |x, y| match (x, y) {
        (41, 81) => Some(f32::NAN),
        (x, y) if in_the_dark(x, y) => None,
        _ => Some(0.1),
    };
    rig.clouds.put(&cloud_of(&grid, 2, 1, height_m));
    let heightmap = rig.seen(2);
    assert_eq!(heightmap.quality.as_ref().unwrap().unknown_cells, 2);
    let (_, scene) = read(&heightmap);
    for (x, y) in (0..32).flat_map(|x| (0..32).map(move |y| (x, y))) {
        let is_unknown = y == 20 && (x == 10 || x == 11);
        let expected = if is_unknown { grid.rim() + 1 } else { 50 };
        let found = scene.heightmap().get(x, y);
        assert_eq!(found, Some(expected), "cell ({x}, {y})");
    }
    let surface = scene.surface().unwrap();
    assert!(surface.heights_m()[41 * 128 + 81] > 0.3);
}

#[test]
fn cells_have_the_grids_that_are_set() {
    let fine = GridSettings {
        container: ContainerSize::cuboid(0.2, 0.1, 0.15),
        cell_m: 0.005,
        height_unit_m: 0.001,
        yaws: 8,
    };
    let rig = Rig::connected(&Settings {
        cells: BTreeMap::from([("cell-2".to_owned(), fine)]),
        ..settings()
    });
    let second = Cell::new("cell-2").unwrap();
    let clouds = Sensor::new(&rig.sensor, &second, Stream::Cloud);
    let grid = fine.build().unwrap();
    clouds.put(&cloud_of(&grid, 1, 1, |_, _| Some(0.02)));
    let heightmap = rig.ask_for(&second, 1, PATIENCE).unwrap();
    assert_eq!(read(&heightmap).0, grid);
    assert!(are_all(&heightmap, 20));
    assert_eq!(read(&rig.seen(1)).0, Grid::reference());
}

#[test]
fn other_cells_are_not_served_where_only_listed_ones_are() {
    let rig = Rig::connected(&Settings {
        cells: BTreeMap::from([("cell-1".to_owned(), GridSettings::from(&Grid::reference()))]),
        has_unlisted_cells: false,
        ..settings()
    });
    let second = Cell::new("cell-2").unwrap();
    assert!(matches!(
        rig.ask_for(&second, 0, Duration::from_millis(300)),
        Err(CallError::NoAnswer { .. } | CallError::TimedOut)
    ));
}

/// The points of `flat` in one half along x, of a sensor.
fn half(sensor: &str, state_number: u64, sequence: u64, is_low: bool) -> v1::PointCloud {
    let grid = Grid::reference();
    let height_m = |x: usize, _| ((x < 64) == is_low).then_some(0.1);
    v1::PointCloud {
        sensor: sensor.to_owned(),
        ..cloud_of(&grid, state_number, sequence, height_m)
    }
}

fn two_sensors() -> Settings {
    let names = ["left", "right"].map(str::to_owned).to_vec();
    Settings {
        sensors: BTreeMap::from([("cell-1".to_owned(), names)]),
        sensor_restart_after_s: 0.2,
        ..settings()
    }
}

#[test]
fn the_sensors_of_a_cell_make_one_heightmap_together() {
    let rig = rig(&two_sensors());
    let mut sequence = 0;
    let heightmap = until("no heightmap", || {
        sequence += 1;
        rig.clouds.put(&half("left", 4, sequence, true));
        rig.clouds.put(&half("right", 4, sequence, false));
        rig.ask_for(&cell(), 4, Duration::from_millis(200)).ok()
    });
    let quality = heightmap.quality.as_ref().unwrap();
    assert_eq!((quality.unknown_cells, quality.clouds), (0, 2));
    assert_eq!(quality.points_inside, 128 * 128);
    assert!(quality.doubts.is_empty());
    assert!(are_all(&heightmap, 50));

    // One alone is not enough, and the other is named.
    let silence = until("nobody is named", || {
        sequence += 1;
        rig.clouds.put(&half("left", 5, sequence, true));
        match rig.ask_for(&cell(), 5, Duration::from_millis(500)) {
            Err(CallError::Refused { message, .. }) => Some(message),
            _ => None,
        }
        .filter(|message| message.contains("has sent nothing"))
    });
    assert!(silence.contains("sensor \"right\""), "{silence}");
    let mut stranger = half("behind", 5, 1, true);
    rig.send_refused(&stranger, Fate::Unserved);
    stranger.sensor.clear();
    rig.send_refused(&stranger, Fate::Unserved);
}

#[test]
fn a_cloud_of_another_cell_is_not_used() {
    let rig = Rig::connected(&settings());
    let of = |cell: &str, sequence| v1::PointCloud {
        cell: cell.to_owned(),
        ..flat(9, sequence)
    };
    rig.send_refused(&of("cell-2", 1_000_000), Fate::Unserved);
    rig.clouds.put(&of("cell-1", 1_000_001));
    assert_eq!(rig.seen(9).cell, "cell-1");
}

#[test]
fn what_a_cloud_makes_doubtful_is_told() {
    let rig = Rig::connected(&settings());
    assert!(rig.seen(1).quality.unwrap().doubts.is_empty());
    let third = |x, _| (x < 40).then_some(0.0);
    rig.clouds.put(&cloud_of(&Grid::reference(), 2, 1, third));
    let doubts = rig.seen(2).quality.unwrap().doubts;
    let [doubt] = &doubts[..] else {
        panic!("{doubts:?}")
    };
    assert_eq!(doubt.kind(), v1::DoubtKind::LittleSeen);
    assert!(doubt.message.contains("320 of 1024 cells"), "{doubt:?}");
}

#[test]
fn a_heightmap_that_is_asked_for_tells_its_age() {
    let rig = Rig::connected(&settings());
    let age = |()| rig.ask(&cell(), at_state(1), PATIENCE).unwrap().age_ns;
    let ages = [(); 2].map(age);
    assert!(0 < ages[0] && ages[0] < ages[1], "{ages:?}");
}

#[test]
fn clouds_that_have_no_room_are_dropped_and_those_that_have_are_mapped() {
    let rig = Rig::connected(&Settings {
        clouds_mib: 1,
        ..settings()
    });
    let mut large = flat(2, 1);
    large.data = large.data.repeat(6);
    assert!(large.encoded_len() > 1 << 20);
    for _ in 0..10 {
        rig.send_refused(&large, Fate::NoRoom);
    }
    for state_number in 2..20 {
        rig.clouds.put(&flat(state_number, 1));
        rig.seen(state_number);
    }
    let dropped = rig.perception.clouds(Fate::NoRoom);
    assert_eq!(dropped, 10, "room is given back");
}
