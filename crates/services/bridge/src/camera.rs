//! The sensors of a cell as a publisher of clouds.

use std::time::Duration;

use ppnpack_service::ServiceError;
use ppnpack_service::clock;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use crate::Settings;
use crate::robot::{Robot, RobotError, View};
use crate::settings::span;

/// Publishes what a robot's sensors see.
pub(crate) struct Camera {
    cell: Cell,
    clouds: Publisher<v1::PointCloud>,
    /// The time between clouds while nothing changes.
    pub(crate) period: Duration,
    sequence: u64,
    /// Trouble is told once, until it ends.
    is_in_trouble: bool,
}

impl Camera {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        settings: &Settings,
    ) -> Result<Self, ServiceError> {
        Ok(Self {
            cell: cell.clone(),
            clouds: Publisher::new(process, cell, Stream::Cloud)?,
            period: span(1.0 / settings.cloud_rate_hz),
            sequence: 0,
            is_in_trouble: false,
        })
    }

    /// Publishes clouds of the container in this state, one of each sensor.
    pub(crate) fn show(&mut self, robot: &mut dyn Robot, state_number: u64) {
        let result = self.try_show(robot, state_number);
        if let (Err(error), false) = (&result, self.is_in_trouble) {
            tracing::warn!(%error, "no cloud is published");
        }
        self.is_in_trouble = result.is_err();
    }

    fn try_show(&mut self, robot: &mut dyn Robot, state_number: u64) -> Result<(), RobotError> {
        // The time of day, for people: nanoseconds since 1970.
        let captured_at_ns = i64::try_from(clock::now_ns()).unwrap_or(i64::MAX);
        let views = robot.capture()?;
        self.sequence += 1;
        for view in &views {
            let message = self.cloud(view, state_number, captured_at_ns);
            self.clouds
                .put(&message)
                .map_err(|error| RobotError(error.to_string()))?;
        }
        Ok(())
    }

    fn cloud(&self, view: &View, state_number: u64, captured_at_ns: i64) -> v1::PointCloud {
        let capture = Capture {
            sequence: self.sequence,
            captured_at_ns,
            state_number: if view.is_of_now { state_number } else { 0 },
            container_from_sensor: view.container_from_sensor,
        };
        v1::PointCloud {
            cell: self.cell.to_string(),
            sensor: view.sensor.clone(),
            ..cloud::write(&capture, &view.points_m)
        }
    }
}
