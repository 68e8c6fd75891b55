//! The poses of everything after each step, in as few numbers as show them.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::scene::model::mesh::Bounds;
use ppnpack_packing::streams::episode::Step;
use ppnpack_physics::moves::Moves;
use serde::Serialize;

use super::Content;

/// Minimum shift that is shown, in metres.
const LEAST_SHIFT_M: f64 = 2e-4;

/// Maximum of shifts that are written: the smallest are left out until they are so few. A shift
/// takes some 60 bytes.
const MOST_SHIFTS: usize = 10_000;

/// Maximum of doublings of the least shift: then nothing within a container is one.
const MOST_DOUBLINGS: i32 = 14;

/// Number of whole steps of a quantised position in a metre, and of a quantised quaternion in one.
const STEPS: f64 = 1e4;

/// A pose in whole numbers: x, y and z in tenths of millimetres, then the quaternion's w, x, y and
/// z in ten-thousandths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct QuantisedPose([i32; 7]);

impl QuantisedPose {
    pub(super) fn of(pose: &Isometry3<f64>) -> Self {
        let at_m = pose.translation.vector;
        let rotation = pose.rotation.quaternion();
        let [w, i, j, k] = [rotation.w, rotation.i, rotation.j, rotation.k];
        Self([at_m.x, at_m.y, at_m.z, w, i, j, k].map(|part| (part * STEPS).round() as i32))
    }
}

/// An item that lies elsewhere after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Shift {
    /// The step that placed it, from 0.
    item: usize,
    /// The pose of its shape in the container.
    pose: QuantisedPose,
}

/// The shape of an item that was placed, as it is drawn.
#[derive(Debug)]
pub(super) struct Shape<'a> {
    pub(super) model: &'a Arc<Model>,
    /// The frame of the model in the item's own.
    own_from_model: Isometry3<f64>,
    /// The corners of the box around it, in the model's frame.
    corners: Vec<Point3<f64>>,
}

impl<'a> Shape<'a> {
    /// Gives the shape of what a step placed: the one in which it lies at the end, or else the one
    /// in which it was placed, where that is known.
    pub(super) fn of(step: &'a Step, lies: Option<&'a Content>) -> Option<Self> {
        let candidate = &step.candidate;
        let turned = candidate.lying.heightmap_from_item;
        let own_from_model = turned.map_or_else(Isometry3::identity, |turned| turned.inverse());
        let (model, own_from_model) = match lies {
            Some(content) => (&content.model, Isometry3::identity()),
            None => (candidate.model.as_ref()?, own_from_model),
        };
        Some(Self {
            model,
            own_from_model,
            corners: Bounds::of(&model.mesh.vertices)?.mesh().vertices,
        })
    }

    fn pose(&self, container_from_item: &Isometry3<f64>) -> QuantisedPose {
        QuantisedPose::of(&(container_from_item * self.own_from_model))
    }

    /// Gives the pose that was planned for it.
    pub(super) fn planned(&self, step: &Step, grid: &Grid) -> Option<QuantisedPose> {
        let candidate = &step.candidate;
        let resting = &step.choice.resting;
        let frame = candidate.item.container_from_item(grid, resting)?;
        Some(self.pose(&candidate.lying.own_frame(&frame)))
    }

    /// Bounds the distance of any point of it between two poses, in metres.
    fn apart_m(&self, one: &Isometry3<f64>, other: &Isometry3<f64>) -> f64 {
        let corners = self.corners.iter().map(|corner| {
            let corner = self.own_from_model * corner;
            (one * corner - other * corner).norm()
        });
        corners.fold(0.0, f64::max)
    }
}

/// The shapes of all that was placed, by arrival, each with the step that placed it.
pub(super) type Shapes<'a> = BTreeMap<usize, (usize, Shape<'a>)>;

/// Gives what lies elsewhere after each step: the placed item, and what it moved so far that it can
/// be seen.
pub(super) fn shifts(moves: &[Moves], shapes: &Shapes<'_>) -> Vec<Vec<Shift>> {
    let least_m = (0..MOST_DOUBLINGS).map(|doublings| LEAST_SHIFT_M * 2.0_f64.powi(doublings));
    let mut all = least_m.map(|least_m| shifts_above(moves, shapes, least_m));
    let few = all.find(|shifts| shifts.iter().map(Vec::len).sum::<usize>() <= MOST_SHIFTS);
    few.unwrap_or_else(|| shifts_above(moves, shapes, f64::INFINITY))
}

/// Gives the shifts further than that from where the item was shown last.
fn shifts_above(moves: &[Moves], shapes: &Shapes<'_>, least_m: f64) -> Vec<Vec<Shift>> {
    let mut shown: BTreeMap<usize, Isometry3<f64>> = BTreeMap::new();
    let of_step = |moves: &Moves| {
        shown.retain(|arrival, _| !moves.gone.contains(arrival));
        let mut shifts = Vec::new();
        for (arrival, pose) in &moves.lies {
            let Some((item, shape)) = shapes.get(arrival) else {
                continue;
            };
            let last = shown.get(arrival);
            if last.is_none_or(|last| shape.apart_m(last, pose) > least_m) {
                shown.insert(*arrival, *pose);
                let pose = shape.pose(pose);
                shifts.push(Shift { item: *item, pose });
            }
        }
        shifts
    };
    moves.iter().map(of_step).collect()
}

#[cfg(test)]
mod tests {
    use ppnpack_catalogue::build::{ModelSettings, model};

    use super::*;

    fn cube() -> Arc<Model> {
        let bounds = Bounds {
            lowest: Point3::origin(),
            highest: Point3::new(0.1, 0.1, 0.1),
        };
        let (cube, _) = model("cube", bounds.mesh(), &ModelSettings::default()).unwrap();
        Arc::new(cube)
    }

    fn shapes(model: &Arc<Model>, count: usize) -> Shapes<'_> {
        let shape = || Shape {
            model,
            own_from_model: Isometry3::identity(),
            corners: Bounds::of(&model.mesh.vertices).unwrap().mesh().vertices,
        };
        (0..count).map(|step| (step, (step, shape()))).collect()
    }

    fn at(x_m: f64) -> Isometry3<f64> {
        Isometry3::translation(x_m, 0.0, 0.0)
    }

    fn moved(lies: &[(usize, f64)]) -> Moves {
        let lies = lies.iter().map(|(arrival, x_m)| (*arrival, at(*x_m)));
        Moves {
            lies: lies.collect(),
            gone: Vec::new(),
        }
    }

    #[test]
    fn small_shifts_are_shown_when_they_have_added_up() {
        let cube = cube();
        let shapes = shapes(&cube, 2);
        let drift = (0..10).map(|step| moved(&[(0, f64::from(step) * 0.6e-4)]));
        let shifts = shifts(&drift.collect::<Vec<_>>(), &shapes);
        let shown: Vec<usize> = shifts.iter().map(Vec::len).collect();
        assert_eq!(shown, [1, 0, 0, 0, 1, 0, 0, 0, 1, 0]);
        assert_eq!(shifts[8][0].pose.0, [5, 0, 0, 10_000, 0, 0, 0]);
    }

    #[test]
    fn however_much_moves_a_page_carries_few_shifts_and_every_item() {
        let cube = cube();
        let count = 300;
        let shapes = shapes(&cube, count);
        // After each step everything lies some millimetres away from where it was.
        let steps = (0..count).map(|step| {
            let away_m = if step % 2 == 0 { 0.0 } else { 0.004 };
            moved(&(0..=step).map(|item| (item, away_m)).collect::<Vec<_>>())
        });
        let shifts = shifts(&steps.collect::<Vec<_>>(), &shapes);
        assert!(shifts.iter().map(Vec::len).sum::<usize>() <= MOST_SHIFTS);
        for (step, shifts) in shifts.iter().enumerate() {
            assert!(shifts.iter().any(|shift| shift.item == step), "{step}");
        }
    }
}
