//! The simulated cell as a robot.

mod settings;
mod view;

use std::collections::BTreeMap;
use std::sync::Arc;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::checks::motion::{Cycle, LegKind};
use ppnpack_packing::kernel::grid::{ContainerSize, GridError};
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::outcome::PlacedReport;
use ppnpack_service::Shutdown;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::robot::{
    Body, CutOff, Ending, Finding, KnownPose, Placement, Robot, RobotError, View as RobotView,
};
pub use settings::{FaultSettings, Scan, SimulatedSettings};
use view::View;

use crate::settings::span;

/// A setting with which there is no simulated cell.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulatedError {
    /// The simulation cannot be as it is asked for.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
    /// The container cannot be scanned at this pitch.
    #[error("scan_pitch_m: {0}")]
    Scan(#[from] GridError),
}

/// The names of a simulated cell's sensors: of several, each has one.
pub fn sensor_names(sensors: usize) -> Vec<String> {
    match sensors {
        ..=1 => vec![String::new()],
        _ => (1..=sensors)
            .map(|number| format!("camera-{number}"))
            .collect(),
    }
}

/// A simulated cell with a robot that does as it is told, but for the faults that are asked for.
pub struct SimulatedRobot {
    settings: SimulatedSettings,
    cell: SimulatedCell,
    view: View,
    models: BTreeMap<String, Arc<Model>>,
    /// The items by the numbers of their bodies.
    items: Vec<String>,
    faults: ChaCha8Rng,
}

impl SimulatedRobot {
    /// An empty cell for the objects of a catalogue.
    ///
    /// # Errors
    /// [`SimulatedError`] where a setting is impossible.
    pub fn new(settings: SimulatedSettings, catalogue: &Catalogue) -> Result<Self, SimulatedError> {
        let models = catalogue.objects.iter().map(|object| &object.model);
        Ok(Self {
            cell: SimulatedCell::new(settings.physics.clone())?,
            view: View::new(&settings)?,
            models: models
                .map(|model| (model.name.clone(), Arc::clone(model)))
                .collect(),
            items: Vec::new(),
            faults: ChaCha8Rng::seed_from_u64(settings.faults.seed),
            settings,
        })
    }

    /// Follows the legs of a motion, in time, up to the release of the item.
    fn bring(&mut self, cycle: &Cycle, cut_off: &Shutdown) -> Result<(), CutOff> {
        for leg in cycle.legs.iter().take_while(|leg| !is_way_back(leg.kind)) {
            let is_cut_off = self.wait(leg.duration_s(), cut_off);
            // Until the item is held, nothing in the cell is touched. After that it goes to the
            // end.
            match leg.kind {
                LegKind::Descend if is_cut_off || self.wait(cycle.grip_s, cut_off) => {
                    return Err(CutOff);
                }
                LegKind::Insert => {
                    self.wait(cycle.release_s, cut_off);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Follows the legs after the release, in time.
    fn come_back(&mut self, cycle: &Cycle, cut_off: &Shutdown) {
        for leg in cycle.legs.iter().filter(|leg| is_way_back(leg.kind)) {
            self.wait(leg.duration_s(), cut_off);
        }
    }

    /// Lets time pass, in seconds of the motion. Says whether the end was asked for, which ends it.
    fn wait(&self, motion_s: f64, end: &Shutdown) -> bool {
        let speed = self.settings.motion_speed;
        let passing_s = if speed > 0.0 { motion_s / speed } else { 0.0 };
        end.wait_timeout(span(passing_s))
    }

    /// Draws the fault of a placement, if any; takes one random number a placement.
    fn fault(&mut self) -> Option<Finding> {
        let faults = &self.settings.faults;
        let chance: f64 = self.faults.random();
        if chance < faults.missed_picks {
            let failure = "the gripper missed the item, which is where it was";
            Some(Finding::failed(Ending::NotPlaced, failure))
        } else if chance < faults.missed_picks + faults.drops {
            let failure = "the gripper dropped the item beside the container";
            Some(Finding::failed(Ending::Lost, failure))
        } else {
            None
        }
    }

    fn empty(&mut self) {
        self.cell.reset();
        self.items.clear();
    }

    fn release(&mut self, placement: &Placement) -> Finding {
        let Some(model) = self.models.get(&placement.object) else {
            let failure = format!("the cell has no object '{}'", placement.object);
            return Finding::failed(Ending::NotPlaced, failure);
        };
        match self.cell.place(model, &placement.container_from_item) {
            Ok(report) => {
                self.items.push(placement.item_id.clone());
                finding(&report)
            }
            // On an error nothing has changed.
            Err(error) => Finding::failed(Ending::NotPlaced, error.to_string()),
        }
    }
}

fn is_way_back(leg: LegKind) -> bool {
    matches!(leg, LegKind::Retreat | LegKind::Return)
}

fn finding(report: &PlacedReport) -> Finding {
    let (ending, failure) = if report.lost {
        (Ending::Lost, "the item fell beside the container")
    } else {
        (Ending::Placed, "")
    };
    Finding {
        ending,
        failure: failure.to_owned(),
        container_from_item: Some(KnownPose::Found(report.container_from_item)),
        is_inside: report.inside,
        slide_m: report.slide_m,
        tilt_rad: report.tilt_rad,
    }
}

impl Robot for SimulatedRobot {
    fn is_simulated(&self) -> bool {
        true
    }

    fn container(&self) -> ContainerSize {
        self.settings.physics.container
    }

    fn objects(&self) -> Option<BTreeMap<String, Bounds>> {
        let models = self.models.iter();
        // A catalogue has no object without a surface.
        let outlines =
            models.filter_map(|(name, model)| Some((name.clone(), model.mesh.bounds()?)));
        Some(outlines.collect())
    }

    fn take_over(&mut self, bodies: Vec<Body>) -> Vec<Body> {
        let known = bodies.into_iter().filter_map(|body| {
            let Some(model) = self.models.get(&body.object) else {
                tracing::error!(
                    item = body.item_id,
                    object = body.object,
                    "the catalogue no longer has the object: the item is taken out of the container"
                );
                return None;
            };
            let container_from_item = *body.container_from_item.isometry();
            Some(((Arc::clone(model), container_from_item), body.item_id))
        });
        let (poses, items): (Vec<_>, Vec<_>) = known.unzip();
        self.items = items;
        if let Err(error) = self.cell.lay_down(&poses) {
            tracing::error!(%error, "the container cannot be filled as it was: it begins empty");
            self.empty();
        }
        self.bodies()
    }

    fn place(&mut self, placement: &Placement, cut_off: &Shutdown) -> Result<Finding, CutOff> {
        match &placement.cycle {
            Some(cycle) => self.bring(cycle, cut_off)?,
            None if cut_off.wait_timeout(span(self.settings.place_duration_s)) => {
                return Err(CutOff);
            }
            None => {}
        }
        let finding = match self.fault() {
            Some(finding) => finding,
            None => self.release(placement),
        };
        if let Some(cycle) = &placement.cycle {
            self.come_back(cycle, cut_off);
        }
        Ok(finding)
    }

    fn renew(&mut self) -> Result<(), RobotError> {
        self.empty();
        Ok(())
    }

    fn bodies(&self) -> Vec<Body> {
        let contents = self.cell.contents().into_iter();
        let bodies = contents.filter_map(|body| {
            Some(Body {
                item_id: self.items.get(body.id.index())?.clone(),
                object: body.model.name.clone(),
                container_from_item: KnownPose::Found(body.container_from_item),
                is_inside: body.inside,
            })
        });
        bodies.collect()
    }

    fn capture(&mut self) -> Result<Vec<RobotView>, RobotError> {
        let views = self.view.of(&mut self.cell);
        let views = views.map_err(|error| RobotError(error.to_string()))?;
        let views = views.into_iter().map(|view| RobotView {
            is_of_now: !self.settings.is_stateless,
            ..view
        });
        Ok(views.collect())
    }
}
