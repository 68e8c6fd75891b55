//! Recorded steps as scenes, for whoever shows them.

use foxglove::messages::SceneUpdate;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;
use zenoh::Session;

use crate::arm::Arms;
use crate::scene;
use crate::shapes::Shapes;

/// Draws recorded steps, and keeps the shapes and arms that they name for the next ones.
pub struct PlannedScenes {
    shapes: Shapes,
    arms: Arms,
}

impl PlannedScenes {
    /// Asks planners for shapes on this session.
    pub fn new(session: &Session) -> Self {
        Self {
            shapes: Shapes::new(Client::new(session)),
            arms: Arms::default(),
        }
    }

    /// What a step of a cell was planned on, what was chosen, how the arm carries that out, and what would have been next, by its record.
    /// Waits for the planner's answer where shapes are missing, a few seconds at most.
    ///
    /// # Errors
    /// Why it cannot be drawn, for people.
    pub fn draw(
        &mut self,
        cell: &Cell,
        record: &v1::PlanningRecord,
    ) -> Result<SceneUpdate, String> {
        scene::draw(cell, record, &mut self.shapes, &mut self.arms)
    }
}
