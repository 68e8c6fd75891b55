//! Records of steps: what each was planned on and what came of it.

mod read;
mod shapes;
mod write;

use std::sync::Mutex;

use ppnpack_service::ServiceError;
use ppnpack_service::clock::now_ns;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use crate::settings::CellSettings;
use crate::step::plan::{Found, StepPlan};
pub use read::Unreadable;
pub(crate) use read::step;
use shapes::Shapes;

/// Publishes the records of a cell while somebody reads them.
pub(crate) struct Recorder {
    records: Publisher<v1::PlanningRecord>,
    shapes: Mutex<Shapes>,
    cell: String,
    versions: v1::Versions,
    /// The settings of the cell, as JSON.
    settings: String,
}

impl Recorder {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        settings: &CellSettings,
    ) -> Result<Self, ServiceError> {
        Ok(Self {
            records: Publisher::new(process, cell, Stream::Record)?,
            shapes: Mutex::default(),
            cell: cell.to_string(),
            versions: process.versions(),
            settings: serde_json::to_string(settings).map_err(ServiceError::start)?,
        })
    }

    /// Makes the record of a step and its result; `None` where nobody reads records.
    pub(crate) fn record(
        &self,
        session_id: &str,
        plan: &StepPlan,
        found: &Found,
        decision: Option<&v1::Decision>,
    ) -> Option<v1::PlanningRecord> {
        if !self.records.has_readers() {
            return None;
        }
        let mut shapes = lock(&self.shapes);
        shapes.make_room();
        Some(v1::PlanningRecord {
            cell: self.cell.clone(),
            session_id: session_id.to_owned(),
            planned_at_ns: i64::try_from(now_ns()).unwrap_or(i64::MAX),
            versions: Some(self.versions.clone()),
            settings: self.settings.clone(),
            is_cut: found.is_cut,
            decision: decision.cloned(),
            ..write::step(plan, &mut shapes)
        })
    }

    pub(crate) fn publish(&self, record: &v1::PlanningRecord) {
        if let Err(error) = self.records.put(record) {
            tracing::warn!(cell = self.cell, %error, "a record is not published");
        }
    }

    pub(crate) fn shapes(&self, ids: &[Vec<u8>]) -> v1::ShapesReply {
        lock(&self.shapes).reply(ids)
    }
}
