//! Containers before a simulated depth camera.
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_perception::calibration::Calibration;
use rand::{Rng, RngExt};

/// A container, its surroundings and a camera above; the world is the container's frame.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) size_m: [f64; 3],
    pub(crate) wall_m: f64,
    pub(crate) bottom_m: f64,
    pub(crate) has_ground: bool,
    /// Where the container stands that should be at the world's origin.
    pub(crate) stands_at: Isometry3<f64>,
    /// How far inwards the wall at x = 0 bulges, in metres.
    pub(crate) bulge_m: f64,
    /// How far the walls lean outwards, in radians.
    pub(crate) draft_rad: f64,
    /// What else there is.
    pub(crate) others: Vec<Mesh>,
    pub(crate) world_from_camera: Isometry3<f64>,
    pub(crate) noise: NoiseModel,
    pub(crate) seed: u64,
}

/// How far a calibration is from the truth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    pub(crate) position_m: f64,
    pub(crate) angle_rad: f64,
    pub(crate) size_m: f64,
}

impl Errors {
    /// Within the aims: 2 mm, 0.3 degrees, 2 mm.
    pub(crate) fn are_small(&self) -> bool {
        self.position_m <= 0.002 && self.angle_rad <= 0.3_f64.to_radians() && self.size_m <= 0.002
    }
}

impl Case {
    /// The reference container on a table, seen from straight above.
    pub(crate) fn plain() -> Self {
        let mut case = Self {
            size_m: [0.32, 0.32, 0.30],
            wall_m: 0.01,
            bottom_m: 0.005,
            has_ground: true,
            stands_at: Isometry3::identity(),
            bulge_m: 0.0,
            draft_rad: 0.0,
            others: Vec::new(),
            world_from_camera: Isometry3::identity(),
            noise: NoiseModel::default(),
            seed: 1,
        };
        case.look_from(0.7, 0.1, 0.3, 0.2);
        case
    }

    /// Any container before any camera that sees it all, tilted by up to 30 degrees.
    pub(crate) fn any(random: &mut impl Rng) -> Self {
        let mut case = Self::plain();
        let [x_m, y_m] = [(); 2].map(|()| random.random_range(0.15..0.6));
        let z_m = random.random_range(0.06..0.4_f64).min(f64::min(x_m, y_m));
        case.size_m = [x_m, y_m, z_m];
        case.wall_m = random.random_range(0.003..0.02);
        case.bottom_m = random.random_range(0.002..0.02);
        case.has_ground = random.random_range(0..5) > 0;
        let wide_m = x_m.hypot(y_m) / 2.0 + case.wall_m;
        let away_m = (wide_m * random.random_range(2.9..3.5)).max(0.45);
        let tilt_rad = random.random_range(0.0..30.0_f64).to_radians();
        let around_rad = random.random_range(0.0..std::f64::consts::TAU);
        let roll_rad = random.random_range(0.0..std::f64::consts::TAU);
        case.look_from(away_m, tilt_rad, around_rad, roll_rad);
        case.seed = random.random();
        case
    }

    /// Puts the camera so far from the middle of the opening, tilted by an angle towards a
    /// direction, rolled.
    pub(crate) fn look_from(&mut self, away_m: f64, tilt_rad: f64, around_rad: f64, roll_rad: f64) {
        let [x_m, y_m, z_m] = self.size_m;
        let middle = Point3::new(x_m / 2.0, y_m / 2.0, z_m);
        let (sideways, up) = tilt_rad.sin_cos();
        let (sin, cos) = around_rad.sin_cos();
        let towards = Vector3::new(sideways * cos, sideways * sin, up);
        let camera = DepthCamera::looking_at(intrinsics(), middle + towards * away_m, &middle);
        let roll = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll_rad);
        self.world_from_camera = camera.world_from_camera * roll;
    }

    pub(crate) fn size(&self) -> ContainerSize {
        let [x_m, y_m, z_m] = self.size_m;
        ContainerSize::cuboid(x_m, y_m, z_m)
    }

    /// What the camera sees, in metres in its frame.
    pub(crate) fn cloud(&self) -> Vec<Point3<f32>> {
        let mut moved = container(self.size_m, self.wall_m, self.bottom_m, self.bulge_m);
        for vertex in moved.iter_mut().flat_map(|mesh| &mut mesh.vertices) {
            let inwards_m = self.draft_rad.tan() * (self.size_m[2] - vertex.z.max(0.0));
            vertex.x -= inwards_m.copysign(vertex.x - self.size_m[0] / 2.0);
            vertex.y -= inwards_m.copysign(vertex.y - self.size_m[1] / 2.0);
        }
        let mut fixed = self.others.clone();
        if self.has_ground {
            let low = [-5.0, -5.0, -self.bottom_m - 0.01];
            fixed.push(Mesh::cuboid(low, [5.0, 5.0, -self.bottom_m]));
        }
        let moved = moved.iter().map(|mesh| (mesh, self.stands_at));
        let fixed = fixed.iter().map(|mesh| (mesh, Isometry3::identity()));
        let bodies = moved.chain(fixed).map(|(mesh, world_from_body)| Body {
            vertices: &mesh.vertices,
            triangles: &mesh.triangles,
            world_from_body,
        });
        let bodies: Vec<Body<'_>> = bodies.collect();
        let camera = DepthCamera::new(intrinsics(), self.world_from_camera);
        camera.see(&bodies, &self.noise, self.seed).unwrap()
    }

    /// How far a calibration is from the truth. Any corner may be the origin.
    pub(crate) fn errors(&self, found: &Calibration) -> Errors {
        let [x_m, y_m, z_m] = self.size_m;
        let corners = [
            (0.0, 0.0, [x_m, y_m, z_m]),
            (x_m, 0.0, [y_m, x_m, z_m]),
            (x_m, y_m, [x_m, y_m, z_m]),
            (0.0, y_m, [y_m, x_m, z_m]),
        ];
        let turns = corners.into_iter().enumerate();
        let turns = turns.map(|(turn, (corner_x_m, corner_y_m, size_m))| {
            let angle_rad = turn as f64 * std::f64::consts::FRAC_PI_2;
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
            let corner = Translation3::new(corner_x_m, corner_y_m, 0.0);
            let sensor_from_truth = self.world_from_camera.inverse() * (corner * turned);
            let off = found.container_from_sensor * sensor_from_truth;
            let ContainerSize { x_m, y_m, z_m, .. } = found.measured_size;
            Errors {
                position_m: off.translation.vector.norm(),
                angle_rad: off.rotation.angle(),
                size_m: (Vector3::new(x_m, y_m, z_m) - Vector3::from(size_m)).amax(),
            }
        });
        let best = turns.min_by(|one, two| one.angle_rad.total_cmp(&two.angle_rad));
        best.unwrap()
    }
}

fn intrinsics() -> Intrinsics {
    Intrinsics::centred(640, 480, 570.0).unwrap()
}

/// A bottom and four walls; the one at x = 0 of panels that bulge.
pub(crate) fn container([x, y, z]: [f64; 3], wall: f64, bottom: f64, bulge: f64) -> Vec<Mesh> {
    let mut meshes = vec![
        Mesh::cuboid([-wall, -wall, -bottom], [x + wall, y + wall, 0.0]),
        Mesh::cuboid([x, -wall, 0.0], [x + wall, y + wall, z]),
        Mesh::cuboid([-wall, -wall, 0.0], [x + wall, 0.0, z]),
        Mesh::cuboid([-wall, y, 0.0], [x + wall, y + wall, z]),
    ];
    let panels = if bulge == 0.0 { 1 } else { 40 };
    for panel in 0..panels {
        let from = f64::from(panel) / f64::from(panels);
        let to = f64::from(panel + 1) / f64::from(panels);
        let inwards = bulge * ((from + to) / 2.0 * std::f64::consts::PI).sin();
        let near = [-wall + inwards, from * y, 0.0];
        meshes.push(Mesh::cuboid(near, [inwards, to * y, z]));
    }
    meshes
}
