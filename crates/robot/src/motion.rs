//! The place motion: down into the container with an item, and up again without it.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::item::{Item, ItemView};
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::scene::Scene;

use crate::arm::Arm;
use crate::cell::CellSettings;
use crate::clearance::{Held, Sweep, deviations_m, extruded};
use crate::columns::Columns;
use crate::error::ParameterError;
use crate::gripper::GripperPart;
use crate::joints::{Joint, JointAngles};
use crate::path::JointPath;
use crate::pick::PickPoint;
use crate::refusal::{Body, Obstacle, Refusal};
use crate::shapes::AxisBox;
use crate::surroundings::{Surroundings, keep_apart};
use crate::track::{first_possible, range};

/// Maximum of steps of one line: more is out of any arm's reach.
const MAX_STEPS: f64 = 10_000.0;

/// A place motion that the arm can make.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceMotion {
    /// The joints from above the container down to the release; the retreat is the same way back.
    pub insert: JointPath,
    /// The place of the cup's lip at the insert's start, in the container frame.
    pub approach: Point3<f64>,
    /// The place of the cup's lip when it lets go, in the container frame.
    pub release: Point3<f64>,
    /// The flange's turn about the vertical seen from the item's: the yaw at which the item is to
    /// be picked.
    pub grasp_yaw_rad: f64,
}

/// One placement of an item held at a pick point.
#[derive(Debug, Clone, Copy)]
pub struct Placing<'a> {
    /// The container's grid.
    pub grid: &'a Grid,
    /// The container's content.
    pub scene: &'a Scene,
    /// The item.
    pub item: &'a Item,
    /// Its placement.
    pub resting: &'a RestingPlacement,
    /// The point at which it is held.
    pub pick: &'a PickPoint,
}

/// Plans place motions of an arm in a cell. It keeps the content between calls.
#[derive(Debug, Clone)]
pub struct PlacePlanner {
    pub(crate) arm: Arc<Arm>,
    pub(crate) cell: CellSettings,
    pub(crate) content: Columns,
    content_with_item: Columns,
}

/// A placement in the container frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    /// The place of the cup's lip when it lets go.
    pub(crate) release: Point3<f64>,
    /// The item's yaw.
    pub(crate) item_yaw_rad: f64,
    /// The item's box at rest.
    pub(crate) item_box: AxisBox,
}

impl Target {
    /// Gives the item below the cup.
    pub(crate) fn held(&self) -> AxisBox {
        self.item_box.moved(&-self.release.coords)
    }

    /// Measures how far the item reaches from the cup's lip, in metres.
    pub(crate) fn beyond_m(&self) -> f64 {
        let AxisBox { lowest, highest } = self.held();
        lowest.coords.abs().sup(&highest.coords.abs()).norm()
    }
}

impl PlacePlanner {
    /// Makes a planner for an arm in a cell.
    ///
    /// # Errors
    /// [`ParameterError::Value`] names the first setting that is not possible.
    pub fn new(arm: Arc<Arm>, cell: CellSettings) -> Result<Self, ParameterError> {
        cell.validate()?;
        Ok(Self {
            arm,
            cell,
            content: Columns::default(),
            content_with_item: Columns::default(),
        })
    }

    /// Gives the arm.
    pub fn arm(&self) -> &Arc<Arm> {
        &self.arm
    }

    /// Gives the cell's settings.
    pub fn cell(&self) -> &CellSettings {
        &self.cell
    }

    /// Plans a motion that places an item, if there is one.
    ///
    /// Cheap tests come first: the gripper's and the item's swept volumes against content, walls
    /// and boxes, which do not depend on joints; then reach and joint ranges; then the links.
    ///
    /// # Errors
    /// [`Refusal`]: of several ways to move, why the one that came furthest is not possible.
    pub fn plan(&mut self, placing: &Placing<'_>) -> Result<PlaceMotion, Refusal> {
        let (target, surroundings) = self.prepare(placing)?;
        let approach = self.approach(&target, placing.grid);
        self.check_swept(&surroundings, &target, &approach)?;
        let lips = |step_m| line(step_m, &approach, &target.release);
        first_possible(&self.arm, &self.cell, lips, |branch, lips| {
            let (branch, grasp_yaw_rad) = self.turned(branch, &target)?;
            let insert = JointPath::new(branch);
            self.check_links(&surroundings, &target, lips, &insert)?;
            Ok(PlaceMotion {
                insert,
                approach,
                release: target.release,
                grasp_yaw_rad,
            })
        })
    }

    /// Takes over the content, alone and with the item at rest, and checks that it is free for the
    /// item; gives the target and its surroundings.
    pub(crate) fn prepare(
        &mut self,
        placing: &Placing<'_>,
    ) -> Result<(Target, Surroundings), Refusal> {
        let view = view(placing)?;
        let target = target(placing, view)?;
        self.content.update(placing.grid, placing.scene.heightmap());
        if !self.content.is_free_for(view, placing.resting) {
            return Err(Refusal::Collision {
                body: Body::HeldItem,
                obstacle: Obstacle::Content,
            });
        }
        self.content_with_item
            .set_with_item(&self.content, view, placing.resting);
        let surroundings = Surroundings::new(&self.cell, &placing.grid.container());
        Ok((target, surroundings))
    }

    /// Gives the lip's place above the release from which the item's lowest point clears the rim.
    fn approach(&self, target: &Target, grid: &Grid) -> Point3<f64> {
        let hangs_m = target.release.z - target.item_box.lowest.z;
        let rim_m = grid.container().z_m.max(target.item_box.lowest.z);
        let above_m = rim_m + hangs_m + self.cell.approach_clearance_m;
        Point3::new(target.release.x, target.release.y, above_m)
    }

    /// Checks the space that the gripper and the item sweep on the vertical line: it depends on no
    /// joint.
    pub(crate) fn check_swept(
        &self,
        surroundings: &Surroundings,
        target: &Target,
        approach: &Point3<f64>,
    ) -> Result<(), Refusal> {
        let apart_m = self.cell.clearance_m + self.cell.path_tolerance_m;
        for (part, mut swept) in extruded(&self.arm, &target.release, approach.z) {
            if part == GripperPart::Cup {
                // The cup touches the item, which may be thinner than the clearance.
                swept.lowest_m += apart_m;
            }
            let nearest = surroundings.nearest_to_cylinder(&self.content, &swept);
            keep_apart(Body::Gripper(part), nearest, apart_m)?;
        }
        let mut swept = target.item_box;
        swept.highest.z += approach.z - target.release.z;
        let nearest = surroundings.nearest_box(|solid| solid.distance_to_box_m(&swept));
        keep_apart(Body::HeldItem, nearest, apart_m)
    }

    /// Turns J6 along a branch for the item's yaw: of the yaws at which it may be picked, for the
    /// one that turns J6 least.
    fn turned(
        &self,
        mut branch: Vec<JointAngles>,
        target: &Target,
    ) -> Result<(Vec<JointAngles>, f64), Refusal> {
        let [.., limits] = self.arm.limits();
        let (low, high) = range(&branch, Joint::J6 as usize);
        let turns = grasp_yaws_rad(&self.cell).filter_map(|grasp_yaw_rad| {
            let flange_yaw_rad = target.item_yaw_rad + grasp_yaw_rad;
            let turn_rad = self.arm.flange_turn_rad(flange_yaw_rad);
            let whole_rad = limits.turns_into((low + turn_rad, high + turn_rad), 0.0)?;
            let turn_rad = turn_rad + whole_rad;
            let most_rad = (low + turn_rad).abs().max((high + turn_rad).abs());
            Some((most_rad, turn_rad, grasp_yaw_rad))
        });
        let least = turns.min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, turn_rad, grasp_yaw_rad) = least.ok_or(Refusal::JointLimit { joint: Joint::J6 })?;
        for joints in &mut branch {
            *joints = joints.with_flange_turned(turn_rad);
        }
        Ok((branch, grasp_yaw_rad))
    }

    /// Checks straightness and the links, on the way down with the item and on the way up past it.
    pub(crate) fn check_links(
        &self,
        surroundings: &Surroundings,
        target: &Target,
        lips: &[Point3<f64>],
        insert: &JointPath,
    ) -> Result<(), Refusal> {
        let deviations_m = deviations_m(&self.arm, insert, target.beyond_m());
        straight(&deviations_m, self.cell.path_tolerance_m)?;
        let sweep = Sweep {
            arm: &self.arm,
            lips,
            surroundings,
            columns: &self.content_with_item,
            held: Some(Held::Box(target.held())),
            clearance_m: self.cell.clearance_m,
        };
        sweep.links(insert, &deviations_m)
    }
}

/// Refuses a path that may be further than a tolerance from the straight lines between its
/// waypoints.
pub(crate) fn straight(deviations_m: &[f64], tolerance_m: f64) -> Result<(), Refusal> {
    let deviation_m = deviations_m.iter().copied().fold(0.0, f64::max);
    if deviation_m > tolerance_m {
        return Err(Refusal::NotStraight { deviation_m });
    }
    Ok(())
}

/// Gives the turns of the flange, seen from the item, at which an item may be picked.
pub(crate) fn grasp_yaws_rad(cell: &CellSettings) -> impl Iterator<Item = f64> + use<> {
    let count = cell.wrist_yaws;
    (0..count).map(move |yaw| std::f64::consts::TAU * yaw as f64 / count as f64)
}

/// Gives points along a straight line, at most `step_m` apart, both ends included.
pub(crate) fn line(step_m: f64, from: &Point3<f64>, to: &Point3<f64>) -> Vec<Point3<f64>> {
    let way = to - from;
    let steps = steps_along(way.norm(), step_m);
    let point = |step| from + way * (step as f64 / steps as f64);
    (0..=steps).map(point).collect()
}

/// Counts the steps of at most `step_m` into which a way is cut.
pub(crate) fn steps_along(length_m: f64, step_m: f64) -> usize {
    let steps = (length_m / step_m).ceil();
    steps.clamp(1.0, MAX_STEPS) as usize
}

/// Gives the view of a placement that lies on the grid.
fn view<'a>(placing: &Placing<'a>) -> Result<&'a ItemView, Refusal> {
    let placement = placing.resting.placement;
    let view = placing.item.views().get(placement.yaw);
    let view = view.filter(|view| {
        placement.x.saturating_add(view.nx()) <= placing.grid.nx()
            && placement.y.saturating_add(view.ny()) <= placing.grid.ny()
            && placing.resting.resting_height >= 0
    });
    view.ok_or(Refusal::Placement)
}

/// Converts a placement on the grid to the container frame.
fn target(placing: &Placing<'_>, view: &ItemView) -> Result<Target, Refusal> {
    let Placing { grid, resting, .. } = *placing;
    let resolution = grid.resolution();
    let placement = resting.placement;
    let container_from_item = placing.item.container_from_item(grid, resting);
    let container_from_item = container_from_item.ok_or(Refusal::Placement)?;
    let yaws = resolution.yaws().radians();
    let item_yaw_rad = *yaws.get(placement.yaw).ok_or(Refusal::Placement)?;
    let metres = |x: usize, y: usize, height: Units| {
        let [x_m, y_m] = [x, y].map(|cells| cells as f64 * resolution.cell_m());
        Vector3::new(x_m, y_m, f64::from(height) * resolution.height_unit_m())
    };
    let lowest = Point3::from(metres(placement.x, placement.y, resting.resting_height));
    let size = metres(view.nx(), view.ny(), view.height());
    Ok(Target {
        release: container_from_item * placing.pick.in_item,
        item_yaw_rad,
        item_box: AxisBox {
            lowest,
            highest: lowest + size,
        },
    })
}
