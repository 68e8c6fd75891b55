//! A perception service with things to recognise, a camera, and somebody who asks.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::build::{ModelSettings, model};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_perception_service::{Fate, Objects, Perception, Settings, TraySettings};
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_recognition::recognise::RecognitionSettings;
use ppnpack_recognition::segmentation::{Region, SegmentationSettings};
use ppnpack_service::Process;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::keys::{Cell, Key, Service, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, Status};
use prost::Message;
use zenoh::Wait;
use zenoh::qos::CongestionControl;

pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// The middle of the tray in the container frame, in metres.
pub(crate) const TRAY_M: Vector3<f64> = Vector3::new(0.15, -0.35, -0.01);

pub(crate) fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

pub(crate) fn brick(x_m: f64, y_m: f64, z_m: f64) -> Mesh {
    let half = Vector3::new(x_m, y_m, z_m) / 2.0;
    let (lowest, highest) = (Point3::from(-half), Point3::from(half));
    Bounds { lowest, highest }.mesh()
}

pub(crate) fn known() -> Mesh {
    brick(0.12, 0.06, 0.03)
}

pub(crate) fn library() -> Arc<Library> {
    let meshes = [("slab", known()), ("cube", brick(0.05, 0.05, 0.05))];
    let models = meshes.map(|(name, mesh)| {
        let (model, _) = model(name, mesh, &ModelSettings::default()).unwrap();
        Arc::new(model)
    });
    Arc::new(Library::new(&models, LibrarySettings::default()).unwrap())
}

pub(crate) fn settings() -> Settings {
    let region = Region {
        lowest_m: Point3::from(TRAY_M + Vector3::new(-0.2, -0.15, -0.03)),
        highest_m: Point3::from(TRAY_M + Vector3::new(0.2, 0.15, 0.3)),
    };
    let tray = TraySettings {
        segmentation: SegmentationSettings::of(region),
        recognition: RecognitionSettings::default(),
    };
    Settings {
        catalogue: Some("builtin".to_owned()),
        trays: BTreeMap::from([("cell-1".to_owned(), tray)]),
        grid: GridSettings::from(&Grid::reference()),
        ..Settings::default()
    }
}

/// A sensor that waits where the network is busy: what these tests publish arrives.
pub(crate) struct Sensor(zenoh::pubsub::Publisher<'static>);

impl Sensor {
    pub(crate) fn new(process: &Process, cell: &Cell, stream: Stream) -> Self {
        let key = Key::Stream(cell.clone(), stream).to_string();
        let publisher = process
            .session()
            .declare_publisher(key)
            .congestion_control(CongestionControl::Block)
            .wait();
        Self(publisher.unwrap())
    }

    pub(crate) fn put(&self, cloud: &v1::PointCloud) {
        self.0.put(cloud.encode_to_vec()).wait().unwrap();
    }
}

pub(crate) struct Rig {
    pub(crate) perception: Perception,
    pub(crate) process: Process,
    pub(crate) sensor: Process,
    pub(crate) clouds: Sensor,
    pub(crate) client: Client,
    _hub: Hub,
}

impl Rig {
    /// With things to recognise, and a camera that publishes this stream.
    pub(crate) fn new(stream: Stream) -> Self {
        Self::recognising(stream, |_| Objects::of(library()))
    }

    /// The same with objects that may come later.
    pub(crate) fn recognising(stream: Stream, objects: impl FnOnce(&Process) -> Objects) -> Self {
        Self::with(&settings(), stream, |process| Some(objects(process)))
    }

    pub(crate) fn with(
        settings: &Settings,
        stream: Stream,
        objects: impl FnOnce(&Process) -> Option<Objects>,
    ) -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let objects = objects(&process);
        let perception =
            ppnpack_perception_service::start(&process, settings, objects.as_ref()).unwrap();
        let sensor = embedded::process(&hub, Service::Bridge, "sensor").unwrap();
        Self {
            perception,
            process,
            clouds: Sensor::new(&sensor, &cell(), stream),
            client: Client::new(sensor.session()),
            sensor,
            _hub: hub,
        }
    }

    /// Sends a cloud, and waits until it had its fate.
    pub(crate) fn send_refused(&self, cloud: &v1::PointCloud, fate: Fate) {
        self.meets(fate, || self.clouds.put(cloud));
    }

    /// Waits until a cloud had a fate once more than before it was sent.
    pub(crate) fn meets(&self, fate: Fate, send: impl FnOnce()) {
        let before = self.perception.clouds(fate);
        send();
        let is_counted = || {
            std::thread::yield_now();
            (self.perception.clouds(fate) > before).then_some(())
        };
        until(&format!("it is not counted as {fate:?}"), is_counted);
        assert_eq!(self.perception.clouds(fate), before + 1);
    }

    pub(crate) fn ask_for(
        &self,
        cell: &Cell,
        least_state_number: u64,
        span: Duration,
    ) -> Result<v1::Heightmap, CallError> {
        let reply = self.ask(cell, at_state(least_state_number), span)?;
        Ok(reply.heightmap.unwrap())
    }

    pub(crate) fn ask<R: Request>(
        &self,
        cell: &Cell,
        request: R,
        span: Duration,
    ) -> Result<R::Reply, CallError> {
        self.client.call(cell, request, Instant::now() + span)
    }

    /// Gives the refusal of a request that cannot be answered in this span. On a busy machine it
    /// may come too late: one in time is enough.
    pub(crate) fn refused<R: Request + Clone>(
        &self,
        cell: &Cell,
        request: &R,
        span: Duration,
    ) -> (Status, String)
    where
        R::Reply: std::fmt::Debug,
    {
        until("no refusal comes in time", || {
            match self.ask(cell, request.clone(), span) {
                Err(CallError::TimedOut) => None,
                answer => Some(refusal(answer)),
            }
        })
    }

    /// Publishes clouds with growing numbers until a request is answered.
    pub(crate) fn show<R: Request + Clone>(
        &self,
        mut cloud: v1::PointCloud,
        request: &R,
    ) -> R::Reply {
        let mut span = Duration::from_millis(200);
        until("no cloud arrives", || {
            cloud.sequence += 1;
            self.clouds.put(&cloud);
            span *= 2;
            self.ask(&cell(), request.clone(), span).ok()
        })
    }
}

pub(crate) fn until<T>(otherwise: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = attempt() {
            return found;
        }
        assert!(Instant::now() < end, "{otherwise}");
    }
}

/// A request for a heightmap of this state or a later one.
pub(crate) fn at_state(least_state_number: u64) -> v1::HeightmapRequest {
    v1::HeightmapRequest {
        header: None,
        least_state_number,
    }
}

/// What a camera that looks down from a place sees of meshes at these poses.
pub(crate) fn seen_from(
    eye_m: Point3<f64>,
    focal_px: f64,
    meshes: &[(Mesh, Isometry3<f64>)],
    [sequence, state_number]: [u64; 2],
) -> v1::PointCloud {
    let bodies = meshes.iter().map(|(mesh, pose)| Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body: *pose,
    });
    let bodies: Vec<Body<'_>> = bodies.collect();
    let intrinsics = Intrinsics::centred(640, 480, focal_px).unwrap();
    let camera = DepthCamera::looking_down(intrinsics, eye_m);
    let points = camera.see(&bodies, &NoiseModel::default(), sequence + state_number);
    let capture = Capture {
        sequence,
        captured_at_ns: 1_700_000_000_000_000_000,
        state_number,
        container_from_sensor: camera.world_from_camera,
    };
    cloud::write(&capture, &points.unwrap())
}

/// The status of a request that is refused, and why.
pub(crate) fn refusal<T: std::fmt::Debug>(answer: Result<T, CallError>) -> (Status, String) {
    match answer {
        Err(CallError::Refused {
            status, message, ..
        }) => (status, message),
        other => panic!("{other:?}"),
    }
}
