//! Does anything touch? Asked by moving densely sampled points of the arm, the gripper and the item
//! along densely sampled motions, and looking each up among solid columns and boxes. It shares the
//! arm's forward and inverse kinematics with what it tests, and nothing of its geometry.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::kernel::grid::ABSENT;
use ppnpack_packing::kernel::item::ItemView;
use ppnpack_robot::arm::Arm;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::joints::JointAngles;
use ppnpack_robot::motion::PlaceMotion;
use ppnpack_robot::pick::PickPoint;
use ppnpack_robot::shapes::{Capsule, UprightCylinder};

use super::scenes::Case;

/// Samples of the motion between two waypoints.
const SAMPLES_PER_STRETCH: usize = 4;

/// Steps of the oracle's own vertical lines, in metres.
const STEP_M: f64 = 0.002;

/// What the held item may move beside its nominal line, in metres; it lies against its neighbours.
const ITEM_TOLERANCE_M: f64 = 0.001;

/// A case seen by the oracle.
pub(crate) struct Oracle<'a> {
    arm: &'a Arm,
    cell: &'a CellSettings,
    case: &'a Case,
    /// Per capsule: link and points of its surface in the link's frame.
    links: Vec<(usize, Vec<Point3<f64>>)>,
    /// Points of the gripper in the flange's frame.
    gripper: Vec<Point3<f64>>,
    /// Points of the item where it is placed, moved inwards by the tolerance.
    item: Vec<Point3<f64>>,
    /// Where the cup's lip is at the release.
    release: Point3<f64>,
    item_yaw_rad: f64,
}

impl<'a> Oracle<'a> {
    pub(crate) fn new(
        arm: &'a Arm,
        cell: &'a CellSettings,
        case: &'a Case,
        pick: &PickPoint,
    ) -> Self {
        let links = arm.capsules().iter().filter(|capsule| capsule.link > 0);
        let links = links.map(|capsule| (capsule.link, capsule_points(&capsule.shape)));
        let length_m = arm.gripper().length_m();
        let parts = arm.gripper().parts();
        let gripper = parts
            .iter()
            .flat_map(|(_, part)| cylinder_points(part, length_m));
        let pose = case.item.container_from_item(&case.grid, &case.resting);
        let yaws = case.grid.resolution().yaws().radians();
        Self {
            arm,
            cell,
            case,
            links: links.collect(),
            gripper: gripper.collect(),
            item: item_points(case),
            release: pose.unwrap() * pick.in_item,
            item_yaw_rad: yaws[case.resting.placement.yaw],
        }
    }

    /// What a planned motion touches, if anything.
    pub(crate) fn check(&self, motion: &PlaceMotion) -> Result<(), String> {
        let flange_yaw_rad = self.item_yaw_rad + motion.grasp_yaw_rad;
        let stretches = motion.insert.stretches();
        let samples = stretches * SAMPLES_PER_STRETCH;
        let last = motion.insert.waypoints().last().unwrap();
        if (self.arm.lip(last) - self.release).norm() > 1e-5 {
            return Err("the motion does not end at the release".to_owned());
        }
        let top = self.arm.lip(&motion.insert.at(0.0).unwrap());
        let hangs_m = self.release.z - self.resting_m();
        if top.z - hangs_m < self.case.grid.container().z_m {
            return Err("the motion does not start above the rim".to_owned());
        }
        for sample in 0..=samples {
            let at = sample as f64 / SAMPLES_PER_STRETCH as f64;
            let joints = motion.insert.at(at).unwrap();
            for (joint, limits) in joints.as_array().iter().zip(self.arm.limits()) {
                if !(limits.lowest_rad - 1e-9..=limits.highest_rad + 1e-9).contains(joint) {
                    return Err("a joint leaves its range".to_owned());
                }
            }
            let lip = self.arm.lip(&joints);
            if (lip - self.release).xy().norm() > self.cell.path_tolerance_m {
                return Err("the motion is not straight".to_owned());
            }
            self.touches(&joints, flange_yaw_rad)?;
        }
        Ok(())
    }

    /// Whether any of the arm's solutions at the release can be followed straight up without
    /// touching anything.
    pub(crate) fn is_possible(&self) -> bool {
        let hangs_m = self.release.z - self.resting_m();
        let rim_m = self.case.grid.container().z_m;
        let top_m = rim_m + hangs_m + self.cell.approach_clearance_m;
        let steps = ((top_m - self.release.z) / STEP_M).ceil() as usize;
        let solutions = self.arm.inverse(&self.release, self.item_yaw_rad);
        solutions.into_iter().any(|start| {
            let mut last = start;
            let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); 6];
            for step in 0..=steps {
                let above_m = (top_m - self.release.z) * step as f64 / steps as f64;
                let lip = self.release + Vector3::new(0.0, 0.0, above_m);
                let solutions = self.arm.inverse(&lip, self.item_yaw_rad).into_iter();
                let near = solutions.map(|solution| unwrapped(&solution, &last));
                let Some((step_rad, joints)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                    return false;
                };
                if step_rad > 0.3 || self.touches(&joints, self.item_yaw_rad).is_err() {
                    return false;
                }
                for (range, angle) in ranges.iter_mut().zip(joints.as_array()) {
                    *range = (range.0.min(*angle), range.1.max(*angle));
                }
                if !self.is_allowed(&ranges) {
                    return false;
                }
                last = joints;
            }
            true
        })
    }

    /// Whether ranges of angles can be turned into the limits; J6 has its grasp yaws to choose
    /// from.
    fn is_allowed(&self, ranges: &[(f64, f64); 6]) -> bool {
        let mut joints = ranges.iter().zip(self.arm.limits()).enumerate();
        joints.all(|(joint, (range, limits))| {
            let yaws = if joint == 5 { self.cell.wrist_yaws } else { 1 };
            let turns = (0..yaws).map(|yaw| TAU * yaw as f64 / yaws as f64);
            let mut turns = turns.flat_map(|turn| (-3..=3).map(move |n| turn + TAU * f64::from(n)));
            turns.any(|turn| {
                range.0 + turn >= limits.lowest_rad && range.1 + turn <= limits.highest_rad
            })
        })
    }

    /// What is touched at one moment, on the way down with the item or on the way up without.
    fn touches(&self, joints: &JointAngles, flange_yaw_rad: f64) -> Result<(), String> {
        let frames = self.arm.container_from_links(joints);
        let length_m = self.arm.gripper().length_m();
        let nominal = Isometry3::from_parts(
            Translation3::from(self.release.coords + Vector3::new(0.0, 0.0, length_m)),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), flange_yaw_rad)
                * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI),
        );
        // How far the item is from where it will be placed.
        let moved = frames[6] * nominal.inverse();
        let moved_back = moved.inverse();
        let flange_from_container = frames[6].inverse();
        for (link, points) in &self.links {
            for point in points {
                let at = frames[*link] * point;
                if let Some(hit) = self.solid_at(&at, *link > 1) {
                    return Err(format!("link {link} in {hit}"));
                }
                if self.is_in_item(&at) {
                    return Err(format!("link {link} in the placed item"));
                }
                if self.is_in_item(&(moved_back * at)) {
                    return Err(format!("link {link} in the held item"));
                }
                if *link < 5 && self.is_in_gripper(&(flange_from_container * at)) {
                    return Err(format!("link {link} in the gripper"));
                }
            }
        }
        for point in &self.gripper {
            if let Some(hit) = self.solid_at(&(frames[6] * point), true) {
                return Err(format!("the gripper in {hit}"));
            }
        }
        for point in &self.item {
            if let Some(hit) = self.solid_at(&(moved * point), true) {
                return Err(format!("the item in {hit}"));
            }
        }
        Ok(())
    }

    /// What is solid at a point.
    fn solid_at(&self, at: &Point3<f64>, is_above_table: bool) -> Option<String> {
        let (grid, cell) = (&self.case.grid, self.cell);
        let size = grid.container();
        if is_above_table && at.z < cell.table_height_m {
            return Some("the table".to_owned());
        }
        let inside = at.x > 0.0 && at.x < size.x_m && at.y > 0.0 && at.y < size.y_m;
        if inside {
            let cell_m = grid.resolution().cell_m();
            let (x, y) = ((at.x / cell_m) as usize, (at.y / cell_m) as usize);
            let height = self.case.scene.heightmap().get(x, y).unwrap_or(0);
            if at.z < f64::from(height) * grid.resolution().height_unit_m() {
                return Some("the content".to_owned());
            }
        } else {
            let thick = cell.wall_thickness_m;
            let outside = at.x < -thick
                || at.x > size.x_m + thick
                || at.y < -thick
                || at.y > size.y_m + thick;
            if !outside && at.z < size.z_m && at.z > cell.table_height_m {
                return Some("a wall".to_owned());
            }
        }
        let inside = cell.boxes.iter().find(|solid| {
            (0..3).all(|axis| at[axis] > solid.lowest_m[axis] && at[axis] < solid.highest_m[axis])
        });
        inside.map(|solid| solid.name.clone())
    }

    fn view(&self) -> &ItemView {
        &self.case.item.views()[self.case.resting.placement.yaw]
    }

    fn resting_m(&self) -> f64 {
        f64::from(self.case.resting.resting_height) * self.case.grid.resolution().height_unit_m()
    }

    /// Whether a point is in the item where it is placed.
    fn is_in_item(&self, at: &Point3<f64>) -> bool {
        let resolution = self.case.grid.resolution();
        let (placement, view) = (self.case.resting.placement, self.view());
        let x = at.x / resolution.cell_m() - placement.x as f64;
        let y = at.y / resolution.cell_m() - placement.y as f64;
        if x < 0.0 || y < 0.0 || x >= view.nx() as f64 || y >= view.ny() as f64 {
            return false;
        }
        let index = x as usize * view.ny() + y as usize;
        let height = (at.z - self.resting_m()) / resolution.height_unit_m();
        view.bottom()[index] != ABSENT
            && height > f64::from(view.bottom()[index])
            && height < f64::from(view.top()[index])
    }

    /// Whether a point in the flange's frame is in the gripper.
    fn is_in_gripper(&self, at: &Point3<f64>) -> bool {
        let above_lip_m = self.arm.gripper().length_m() - at.z;
        self.arm.gripper().parts().iter().any(|(_, part)| {
            at.xy().coords.norm() < part.radius_m
                && above_lip_m > part.lowest_m
                && above_lip_m < part.highest_m
        })
    }
}

fn unwrapped(joints: &JointAngles, near: &JointAngles) -> (f64, JointAngles) {
    let mut angles = *joints.as_array();
    let mut most = 0.0_f64;
    for (angle, near) in angles.iter_mut().zip(near.as_array()) {
        let difference = (*angle - near + PI).rem_euclid(TAU) - PI;
        *angle = near + difference;
        most = most.max(difference.abs());
    }
    (most, JointAngles::new(angles))
}

/// A circle of points about the z axis, at most so far apart, in metres.
fn ring(radius_m: f64, z_m: f64, apart_m: f64) -> impl Iterator<Item = Point3<f64>> {
    let around = (TAU * radius_m / apart_m).ceil().max(1.0) as usize;
    (0..around).map(move |step| {
        let (sin, cos) = (TAU * step as f64 / around as f64).sin_cos();
        Point3::new(radius_m * cos, radius_m * sin, z_m)
    })
}

/// Points of a capsule's surface, some 8 mm apart.
fn capsule_points(&Capsule { from, to, radius_m }: &Capsule) -> Vec<Point3<f64>> {
    let axis = to - from;
    let along = UnitQuaternion::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
    let length_m = axis.norm();
    let steps = (length_m / 0.008).ceil().max(1.0) as usize;
    let side = (0..=steps).map(|step| (radius_m, length_m * step as f64 / steps as f64));
    let ends = (0..=8).flat_map(|step| {
        let (sin, cos) = (0.5 * PI * f64::from(step) / 8.0).sin_cos();
        let (beyond_m, radius_m) = (radius_m * sin, radius_m * cos);
        [(radius_m, length_m + beyond_m), (radius_m, -beyond_m)]
    });
    let points = side
        .chain(ends)
        .flat_map(|(radius_m, z_m)| ring(radius_m, z_m, 0.008));
    points.map(|point| from + along * point.coords).collect()
}

/// Points of a part's side and lower end in the flange's frame, some 3 mm apart; the lip's plane is
/// left out.
fn cylinder_points(part: &UprightCylinder, length_m: f64) -> Vec<Point3<f64>> {
    let lowest_m = part.lowest_m.max(1e-4);
    let height_m = part.highest_m - lowest_m;
    let steps = (height_m / 0.003).ceil() as usize;
    let side = (0..=steps).map(|step| (part.radius_m, height_m * step as f64 / steps as f64));
    let rings = (part.radius_m / 0.003).ceil() as usize;
    let end = (0..rings).map(|step| (part.radius_m * step as f64 / rings as f64, 0.0));
    let rings = side.chain(end);
    rings
        .flat_map(|(radius_m, above_m)| ring(radius_m, length_m - lowest_m - above_m, 0.003))
        .collect()
}

/// Points of the item's cells where it is placed, each cell made smaller by the tolerance.
fn item_points(case: &Case) -> Vec<Point3<f64>> {
    let resolution = case.grid.resolution();
    let (cell_m, unit_m) = (resolution.cell_m(), resolution.height_unit_m());
    let placement = case.resting.placement;
    let view = &case.item.views()[placement.yaw];
    let mut points = Vec::new();
    for (index, (top, bottom)) in view.top().iter().zip(view.bottom()).enumerate() {
        if *bottom == ABSENT {
            continue;
        }
        let x_m = (placement.x + index / view.ny()) as f64 * cell_m;
        let y_m = (placement.y + index % view.ny()) as f64 * cell_m;
        let base_m = f64::from(case.resting.resting_height) * unit_m;
        let low_m = base_m + f64::from(*bottom) * unit_m + ITEM_TOLERANCE_M;
        let high_m = (base_m + f64::from(*top) * unit_m - ITEM_TOLERANCE_M).max(low_m);
        for x_m in [x_m + ITEM_TOLERANCE_M, x_m + cell_m - ITEM_TOLERANCE_M] {
            for y_m in [y_m + ITEM_TOLERANCE_M, y_m + cell_m - ITEM_TOLERANCE_M] {
                points.extend([low_m, high_m].map(|z_m| Point3::new(x_m, y_m, z_m)));
            }
        }
    }
    points
}
