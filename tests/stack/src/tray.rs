//! A simulated tray below a depth camera: objects come to lie there, and what perception sees of them is announced.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Result, anyhow};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::keys::{Key, Stream};
use ppnpack_wire::v1::{self, ItemState};
use prost::Message;
use rand::RngExt;
use rand::seq::IndexedRandom;
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use crate::cell::CellClient;

/// A box of the container frame, in metres.
#[derive(Debug, Clone, Copy)]
pub struct Region {
    /// The corner with the lowest coordinates.
    pub lowest_m: [f64; 3],
    /// The corner with the greatest coordinates.
    pub highest_m: [f64; 3],
}

/// What perception looks at of the tray: beside the container, within the arm's reach.
pub const REGION: Region = Region {
    lowest_m: [-0.36, -0.70, -0.04],
    highest_m: [0.40, -0.06, 0.35],
};

/// The height of the tray, in metres.
const HEIGHT_M: f64 = -0.01;

/// Where the camera is, in metres.
const EYE_M: Point3<f64> = Point3::new(0.02, -0.38, 0.95);

/// The middles of the places where objects come to lie, in metres.
const PLACES_M: [[f64; 2]; 4] = [[-0.16, -0.24], [0.16, -0.24], [-0.16, -0.48], [0.16, -0.48]];

/// How far an object may reach from the middle of its place, in metres: its neighbours keep clear.
const REACH_M: f64 = 0.11;

/// What is seen farther than this from the middle of a place is not what lies there, in metres.
const SAME_M: f64 = 0.11;

/// How long perception may take to say what lies there, before another cloud is published.
const LOOK_LIMIT: Duration = Duration::from_secs(2);

/// How long perception may not answer: after a start it prepares what it recognises, which takes a busy machine more than a minute.
const PATIENCE: Duration = Duration::from_secs(240);

/// An object on the tray.
#[derive(Debug)]
struct Lying {
    item_id: String,
    model: Arc<Model>,
    container_from_object: Isometry3<f64>,
    is_announced: bool,
}

/// The tray of a cell.
pub struct Tray {
    session: zenoh::Session,
    models: Vec<Arc<Model>>,
    camera: DepthCamera,
    plate: Mesh,
    /// What lies at each place.
    places: [Option<Lying>; PLACES_M.len()],
    /// What has not come yet.
    coming: VecDeque<(String, Arc<Model>)>,
    sequence: u64,
    unrecognised: usize,
}

impl Tray {
    /// An empty tray, whose clouds are published by this session.
    ///
    /// # Errors
    /// Where there can be no such camera.
    pub fn new(session: &zenoh::Session, catalogue: &Catalogue) -> Result<Self> {
        let intrinsics = Intrinsics::centred(640, 480, 600.0)?;
        Ok(Self {
            session: session.clone(),
            models: catalogue.models(),
            camera: DepthCamera::looking_down(intrinsics, EYE_M),
            plate: Mesh::cuboid([-0.7, -1.0, HEIGHT_M - 0.02], [0.7, -0.025, HEIGHT_M]),
            places: Default::default(),
            coming: VecDeque::new(),
            // Numbers go on where another run ended: the time makes them so.
            sequence: u64::try_from(now_ns()).unwrap_or_default(),
            unrecognised: 0,
        })
    }

    /// Clears the tray; these objects come to it, in this order. Item `i` is called `item-i`.
    pub fn expect(&mut self, objects: &[&str]) {
        self.places = Default::default();
        self.unrecognised = 0;
        let models = objects.iter().enumerate().filter_map(|(index, object)| {
            let model = self.models.iter().find(|model| model.name == *object)?;
            Some((format!("item-{index}"), Arc::clone(model)))
        });
        self.coming = models.collect();
    }

    /// Whether more is to come.
    pub fn has_more(&self) -> bool {
        !self.coming.is_empty()
    }

    /// How many objects were taken away as perception did not say what they are.
    pub fn unrecognised(&self) -> usize {
        self.unrecognised
    }

    /// Takes away what does not wait there any more, lets objects come where there is room, and announces them.
    ///
    /// # Errors
    /// Where perception or planner refuse, for a minute.
    pub fn bring(&mut self, cell: &CellClient, session: &v1::Session) -> Result<()> {
        self.take(session);
        if !self.lay() {
            return Ok(());
        }
        let seen = cell.with_patience(PATIENCE, |cell| self.look(cell))?;
        let announced = self.recognised(&seen);
        if announced.is_empty() {
            return Ok(());
        }
        cell.patiently(|cell| {
            cell.ask(v1::AnnounceRequest {
                items: announced.clone(),
                ..v1::AnnounceRequest::default()
            })?;
            Ok(())
        })
    }

    /// Takes away what was packed, lost or set aside.
    fn take(&mut self, session: &v1::Session) {
        let waits = |lying: &Lying| {
            let mut items = session.items.iter();
            let item = items.find(|item| item.item_id == lying.item_id);
            item.is_none_or(|item| matches!(item.state(), ItemState::Waiting | ItemState::Decided))
        };
        for place in &mut self.places {
            place.take_if(|lying| !waits(lying));
        }
    }

    /// Lays objects down where there is room, but for those that are too large; says whether there is something new.
    fn lay(&mut self) -> bool {
        let mut is_new = false;
        for (place, middle_m) in self.places.iter_mut().zip(PLACES_M) {
            while place.is_none()
                && let Some((item_id, model)) = self.coming.pop_front()
            {
                *place = tossed(item_id, &model, middle_m);
                is_new |= place.is_some();
            }
        }
        is_new
    }

    /// What perception sees on a cloud of now.
    fn look(&mut self, cell: &CellClient) -> Result<v1::ItemsReply> {
        self.sequence += 1;
        let capture = Capture {
            sequence: self.sequence,
            captured_at_ns: now_ns(),
            state_number: 0,
            container_from_sensor: self.camera.world_from_camera,
        };
        let cloud = cloud::write(&capture, &self.view()?);
        let key = Key::Stream(cell.cell().clone(), Stream::TrayCloud).to_string();
        self.session
            .put(key, cloud.encode_to_vec())
            .congestion_control(CongestionControl::Block)
            .wait()
            .map_err(|error| anyhow!("{error}"))?;
        let request = v1::ItemsRequest {
            least_sequence: self.sequence,
            ..v1::ItemsRequest::default()
        };
        Ok(cell.ask_within(request, LOOK_LIMIT)?)
    }

    /// What the camera sees, in its own frame, in metres.
    fn view(&self) -> Result<Vec<Point3<f32>>> {
        let lying = self.places.iter().flatten();
        let mut bodies = vec![body(&self.plate, Isometry3::identity())];
        bodies.extend(lying.map(|it| body(&it.model.mesh, it.container_from_object)));
        let view = self.camera.see(&bodies)?;
        let points = view.noisy_points(&NoiseModel::default(), self.sequence)?;
        Ok(points.points_m().to_vec())
    }

    /// Announcements of what is new and was recognised; what was not is taken away.
    fn recognised(&mut self, seen: &v1::ItemsReply) -> Vec<v1::Announcement> {
        let mut announced = Vec::new();
        for (place, middle_m) in self.places.iter_mut().zip(PLACES_M) {
            let Some(lying) = place.as_mut().filter(|lying| !lying.is_announced) else {
                continue;
            };
            let mut items = seen.items.iter();
            match items.find_map(|item| announcement(&lying.item_id, item, middle_m)) {
                Some(announcement) => {
                    lying.is_announced = true;
                    announced.push(announcement);
                }
                None => {
                    self.unrecognised += 1;
                    *place = None;
                }
            }
        }
        announced
    }
}

/// What was seen as an announcement, where it lies at this place and is an object of the catalogue.
fn announcement(
    item_id: &str,
    seen: &v1::SeenItem,
    middle_m: [f64; 2],
) -> Option<v1::Announcement> {
    let pose = seen.container_from_item.as_ref()?;
    let position = pose.position.as_ref()?;
    let off_m = (position.x_m - middle_m[0]).hypot(position.y_m - middle_m[1]);
    let heightmaps = seen
        .item
        .clone()
        .filter(|_| off_m <= SAME_M && !seen.object.is_empty())?;
    Some(v1::Announcement {
        item_id: item_id.to_owned(),
        shape: Some(v1::announcement::Shape::Item(heightmaps)),
        heightmap_from_item: seen.heightmap_from_item,
        waits_at: seen.container_from_item,
        ..v1::Announcement::default()
    })
}

/// An object at a place, in a resting pose drawn by its probability, turned anyhow; `None` where it is too large.
fn tossed(item_id: String, model: &Arc<Model>, middle_m: [f64; 2]) -> Option<Lying> {
    let mut random = rand::rng();
    let poses = &model.resting_poses;
    let resting = poses.choose_weighted(&mut random, |pose| pose.probability);
    let resting = resting.map_or_else(|_| UnitQuaternion::identity(), |pose| pose.rotation);
    let yaw_rad = random.random_range(0.0..TAU);
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad) * resting;
    let turned = model.mesh.transformed(&nalgebra::convert(rotation));
    let bounds = turned.bounds()?;
    let centre = nalgebra::center(&bounds.lowest, &bounds.highest);
    let reach_m = (bounds.highest - bounds.lowest).xy().norm() / 2.0;
    let [x_m, y_m] = middle_m;
    let shift = Translation3::new(x_m - centre.x, y_m - centre.y, HEIGHT_M - bounds.lowest.z);
    (reach_m <= REACH_M).then(|| Lying {
        item_id,
        container_from_object: shift * rotation,
        model: Arc::clone(model),
        is_announced: false,
    })
}

fn body(mesh: &Mesh, container_from_mesh: Isometry3<f64>) -> Body<'_> {
    Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body: container_from_mesh,
    }
}

fn now_ns() -> i64 {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let since_1970 = since_1970.unwrap_or_default();
    i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX)
}
