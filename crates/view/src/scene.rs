//! Recorded steps as scenes: the meshes of all that lies there, the choice, the runners-up, and the
//! arm.

use std::time::{Duration, Instant};

use foxglove::messages::{Color, LinePrimitive, SceneEntity, SceneUpdate};
use nalgebra::Isometry3;
use ppnpack_packing::checks::motion::LegKind;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_service::rpc::Client;
use ppnpack_service::shapes;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::shape_store::ShapeStore;
use ppnpack_wire::{convert, v1};
use zenoh::Session;

use crate::arm::{ArmLines, Arms, Leg};
use crate::draw::{ItemBox, color, color_of, edges, entity, in_place_of_all, mesh, strip, text};

/// How long a planner may take to send shapes: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(5);

/// Maximum of shapes that are kept before all are forgotten and asked for anew.
const MOST_KEPT: usize = 1_024;

const CHOICE: Color = color(0.95, 0.65, 0.15, 0.9);

/// The placements that would be next, each less visible than the one before.
const RUNNER_UP: Color = color(0.95, 0.85, 0.35, 0.25);

/// The arm's colour and thickness, in metres.
const ARM: Color = color(0.45, 0.48, 0.52, 0.9);
const ARM_M: f64 = 0.02;

/// The thickness of the way of the cup's tip with the item and without it, in metres.
const HOLDING_M: f64 = 0.008;
const EMPTY_M: f64 = 0.003;

/// The size and colour of the text beside bodies and ways.
const FONT_SIZE: f64 = 10.0;
const TEXT: Color = color(0.2, 0.2, 0.2, 1.0);

/// Draws recorded steps, and keeps the shapes and arms that they name for the next ones.
pub struct PlannedScenes {
    client: Client,
    shapes: ShapeStore,
    arms: Arms,
}

impl PlannedScenes {
    /// Makes one that asks planners for shapes on this session.
    pub fn new(session: &Session) -> Self {
        Self {
            client: Client::new(session),
            shapes: ShapeStore::default(),
            arms: Arms::default(),
        }
    }

    /// Draws a step by its record: what it was planned on, what was chosen, how the arm carries
    /// that out, and what would have been next. It is drawn in the chosen container, or the fullest
    /// one where none was. Waits for the planner where shapes are missing, a few seconds at most.
    ///
    /// # Errors
    /// The reason why it cannot be drawn, for people.
    pub fn draw(
        &mut self,
        cell: &Cell,
        record: &v1::PlanningRecord,
    ) -> Result<SceneUpdate, String> {
        self.fetch_shapes(cell, record);
        let decision = record.decision.as_ref();
        let arm = decision.and_then(|chosen| self.arms.lines(cell, &record.settings, chosen));
        draw(cell, record, &self.shapes, arm.as_ref())
    }

    /// Asks for the shapes that a record names and that are not kept; what nobody has is left out.
    fn fetch_shapes(&mut self, cell: &Cell, record: &v1::PlanningRecord) {
        if self.shapes.count() > MOST_KEPT {
            self.shapes = ShapeStore::default();
        }
        let store = &mut self.shapes;
        let mut missing = shapes::named(record);
        missing.retain(|id| store.item(id).is_none() && store.solid(id).is_none());
        let deadline = Instant::now() + PATIENCE;
        let keep = |shape| store.add(shape);
        if let Err(error) = shapes::fetch(&self.client, cell, missing, deadline, keep) {
            tracing::debug!(%cell, %error, "not all shapes");
        }
    }
}

fn draw(
    cell: &Cell,
    record: &v1::PlanningRecord,
    shapes: &ShapeStore,
    arm: Option<&ArmLines>,
) -> Result<SceneUpdate, String> {
    let decision = record.decision.as_ref();
    let chosen = decision.map(|decision| decision.container.as_str());
    let mut containers = record.containers.iter();
    let named = chosen.and_then(|name| containers.find(|at| at.container == name));
    let at = named
        .or(record.containers.first())
        .ok_or("it has no container")?;
    let scene = convert::scene::read_required("scene", at.scene.as_ref());
    let (grid, _) = scene.map_err(|error| error.to_string())?;
    let step = Step {
        record,
        grid: &grid,
        shapes,
    };
    let entity = |id: &str| entity(cell, record.planned_at_ns, id.to_owned());
    let mut entities = vec![SceneEntity {
        lines: vec![edges(grid.container())],
        ..entity("container")
    }];
    let bodies = at.content.iter().flat_map(|content| &content.bodies);
    entities.extend(bodies.filter_map(|body| {
        let own = entity(&format!("body/{}", body.name));
        step.body(body, own)
    }));
    if let Some(decision) = decision {
        entities.extend(step.choice(decision, entity("choice")));
        let next = (1_u32..).zip(step.runners_up(decision));
        entities.extend(next.map(|(rank, next)| SceneEntity {
            cubes: vec![next.cube(Color {
                a: RUNNER_UP.a / f64::from(rank),
                ..RUNNER_UP
            })],
            texts: vec![next.label()],
            ..entity(&format!("runner_up/{rank}"))
        }));
    }
    let seen = arm.filter(|arm| !arm.links.is_empty());
    entities.extend(seen.map(|arm| SceneEntity {
        lines: vec![strip(&arm.links, ARM_M, ARM)],
        ..entity("arm")
    }));
    entities.extend(arm.map(|arm| {
        let begins = arm.legs.iter().find_map(|leg| leg.points.first());
        let cycle = format!("cycle {:.1} s", arm.cycle_s);
        let time = begins.map(|at| text(&(*at).into(), FONT_SIZE, TEXT, cycle));
        SceneEntity {
            lines: arm.legs.iter().filter_map(tip_path).collect(),
            texts: time.into_iter().collect(),
            ..entity("trajectory")
        }
    }));
    Ok(in_place_of_all(record.planned_at_ns, entities))
}

/// Draws a leg; `None` where it leads nowhere. The way back is the way there: with the item it is
/// wide and faint, without it narrow and full, so that both are seen.
fn tip_path(leg: &Leg) -> Option<LinePrimitive> {
    let (thickness_m, colour) = match leg.kind {
        LegKind::Descend => (EMPTY_M, color(0.15, 0.30, 0.65, 1.0)),
        LegKind::Lift => (HOLDING_M, color(0.95, 0.75, 0.15, 0.5)),
        LegKind::Transfer => (HOLDING_M, color(0.95, 0.55, 0.10, 0.5)),
        LegKind::Insert => (HOLDING_M, color(0.85, 0.30, 0.10, 0.5)),
        LegKind::Retreat => (EMPTY_M, color(0.10, 0.50, 0.55, 1.0)),
        LegKind::Return => (EMPTY_M, color(0.25, 0.55, 0.85, 1.0)),
    };
    let leads = leg.points.len() > 1;
    leads.then(|| strip(&leg.points, thickness_m, colour))
}

struct Step<'a> {
    record: &'a v1::PlanningRecord,
    grid: &'a Grid,
    shapes: &'a ShapeStore,
}

impl<'a> Step<'a> {
    fn body(&self, body: &v1::RecordedBody, own: SceneEntity) -> Option<SceneEntity> {
        let solid = self.shapes.solid(&body.solid)?;
        let pose = body.container_from_item.as_ref();
        let pose = convert::pose::read_required("pose", pose).ok()?;
        let name = body.name.clone();
        Some(SceneEntity {
            triangles: mesh(&solid.mesh, &pose, color_of(&name))
                .into_iter()
                .collect(),
            texts: vec![text(&pose, FONT_SIZE, TEXT, name)],
            ..own
        })
    }

    /// Draws what was chosen: its mesh where its solid is known, else its box.
    fn choice(&self, decision: &v1::Decision, own: SceneEntity) -> Option<SceneEntity> {
        let held = self.held(&decision.item_id, decision.pose)?;
        let resting = read(decision.placement.as_ref()?)?;
        let boxed = ItemBox {
            label: format!("{} {:.3}", decision.object, decision.value),
            ..self.item_box(held, &resting)?
        };
        let frame = self.heightmap_frame(held, &resting)?;
        let solid = self.shapes.solid(&held.solid);
        let solid = solid.and_then(|solid| mesh(&solid.mesh, &frame, CHOICE));
        Some(SceneEntity {
            cubes: match solid {
                Some(_) => Vec::new(),
                None => vec![boxed.cube(CHOICE)],
            },
            triangles: solid.into_iter().collect(),
            texts: vec![boxed.label()],
            ..own
        })
    }

    fn runners_up(&self, decision: &'a v1::Decision) -> impl Iterator<Item = ItemBox> {
        decision.alternatives.iter().filter_map(|ranked| {
            let index = usize::try_from(ranked.candidate).ok()?;
            let item_id = decision.buffer.get(index)?;
            let held = self.held(item_id, ranked.pose)?;
            let boxed = self.item_box(held, &read(ranked.placement.as_ref()?)?)?;
            Some(ItemBox {
                label: format!("{} {:.3}", boxed.label, ranked.value),
                ..boxed
            })
        })
    }

    /// Finds the item of this id in one of its poses.
    fn held(&self, item_id: &str, pose: u32) -> Option<&'a v1::RecordedCandidate> {
        let mut items = self.record.items.iter();
        let item = items.find(|item| item.item_id == item_id)?;
        let mut candidates = self.record.candidates.iter();
        candidates.find(|held| held.arrival == item.arrival && held.pose == pose)
    }

    fn item_box(
        &self,
        held: &v1::RecordedCandidate,
        resting: &RestingPlacement,
    ) -> Option<ItemBox> {
        let item = self.shapes.item(&held.item)?;
        let frame = self.heightmap_frame(held, resting)?;
        ItemBox::of(self.grid, item, resting.placement.yaw, &frame)
    }

    /// Gives the frame of an item's heightmaps.
    fn heightmap_frame(
        &self,
        held: &v1::RecordedCandidate,
        resting: &RestingPlacement,
    ) -> Option<Isometry3<f64>> {
        let item = self.shapes.item(&held.item)?;
        item.container_from_item(self.grid, resting)
    }
}

fn read(resting: &v1::RestingPlacement) -> Option<RestingPlacement> {
    convert::placement::read_resting(resting).ok()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point3};
    use ppnpack_packing::kernel::heightmap::Heightmap;
    use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
    use ppnpack_packing::scene::Scene;
    use ppnpack_packing::scene::model::mesh::Mesh;
    use ppnpack_packing::scene::model::{MassProperties, Model};
    use ppnpack_wire::item_id::ItemId;

    use super::*;

    fn solid() -> v1::Solid {
        convert::solid::write(&Model {
            name: "box".to_owned(),
            mesh: Mesh::cuboid([0.0; 3], [0.1; 3]),
            volume_m3: 0.001,
            pieces: Vec::new(),
            mass: MassProperties {
                mass_kg: 1.0,
                centre_of_mass_m: Point3::origin(),
                inertia_kg_m2: Matrix3::identity(),
            },
            carries_kg: None,
            resting_poses: Vec::new(),
        })
    }

    fn item() -> v1::Item {
        let view = ViewSurfaces::of_cells(10, 10, vec![50; 100], vec![0; 100]);
        convert::item::write(&Item::new("box", vec![view; 4], 0.001).unwrap())
    }

    /// Gives the record of a step in which an item was chosen beside a body, with two runners-up.
    fn record() -> v1::PlanningRecord {
        let grid = Grid::reference();
        let scene = Scene::from_heightmap(Heightmap::empty(&grid));
        let solid = ItemId::of_solid(&solid()).to_bytes();
        let body = v1::RecordedBody {
            name: "a".to_owned(),
            solid: solid.clone(),
            container_from_item: Some(convert::pose::write(&Isometry3::identity())),
            ..v1::RecordedBody::default()
        };
        let next = v1::RankedPlacement {
            placement: Some(v1::RestingPlacement::default()),
            ..v1::RankedPlacement::default()
        };
        v1::PlanningRecord {
            items: vec![v1::RecordedItem {
                item_id: "b".to_owned(),
                ..v1::RecordedItem::default()
            }],
            candidates: vec![v1::RecordedCandidate {
                item: ItemId::of(&item()).to_bytes(),
                solid,
                ..v1::RecordedCandidate::default()
            }],
            containers: vec![v1::RecordedContainer {
                scene: Some(convert::scene::write(&grid, &scene)),
                content: Some(v1::RecordedContent {
                    bodies: vec![body],
                    ..v1::RecordedContent::default()
                }),
                ..v1::RecordedContainer::default()
            }],
            decision: Some(v1::Decision {
                item_id: "b".to_owned(),
                placement: next.placement,
                alternatives: vec![next, next],
                buffer: vec!["b".to_owned()],
                ..v1::Decision::default()
            }),
            ..v1::PlanningRecord::default()
        }
    }

    #[test]
    fn a_step_is_drawn_with_the_shapes_that_are_known() {
        let mut shapes = ShapeStore::default();
        let cell = Cell::new("cell-1").unwrap();
        let drawn = |shapes: &ShapeStore| draw(&cell, &record(), shapes, None).unwrap();
        let ids = |scene: &SceneUpdate| {
            let ids = scene.entities.iter().map(|entity| entity.id.clone());
            ids.collect::<Vec<_>>()
        };
        assert_eq!(ids(&drawn(&shapes)), ["container"]);
        let item = v1::shape::Shape::Item(item());
        let solid = v1::shape::Shape::Solid(solid());
        let [candidate] = &record().candidates[..] else {
            panic!("one");
        };
        for (id, shape) in [(&candidate.item, item), (&candidate.solid, solid)] {
            shapes.add(v1::Shape {
                id: id.clone(),
                shape: Some(shape),
            });
        }
        let scene = drawn(&shapes);
        let expected = [
            "container",
            "body/a",
            "choice",
            "runner_up/1",
            "runner_up/2",
        ];
        assert_eq!(ids(&scene), expected);
        assert_eq!(scene.entities[1].triangles[0].indices.len(), 36);
        assert!(scene.entities[2].cubes.is_empty() && !scene.entities[2].triangles.is_empty());
    }
}
