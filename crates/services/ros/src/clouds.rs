//! Clouds of ROS's drivers, passed on to perception.
//!
//! A cloud is read on Zenoh's thread and put at once, as sensors of the stack put theirs: its points are copied, and nothing is waited for.

use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::Isometry3;
use ppnpack_ros::messages::sensor_msgs;
use ppnpack_ros::names::Name;
use ppnpack_ros::{Node, Qos, Subscription};
use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::ros::{PointCloud2, to_cloud, topic};
use ppnpack_wire::v1;
use zenoh::bytes::ZBytes;

use crate::error::FaceError;
use crate::settings::CloudSource;

/// The clouds of a driver are passed on until it is dropped.
pub(crate) type CloudIn = Subscription;

/// Where the clouds of a driver go.
struct Way {
    cell: Cell,
    sensor: String,
    container_from_sensor: Isometry3<f64>,
    sequence: AtomicU64,
    publisher: Publisher<v1::PointCloud>,
}

/// Passes the clouds of a driver on.
pub(crate) fn pass_on(
    process: &Process,
    node: &Node,
    source: &CloudSource,
) -> Result<CloudIn, FaceError> {
    let topic = Name::new(&source.topic)?;
    let cell = Cell::new(&source.cell).map_err(ServiceError::from)?;
    let pose = source.container_from_sensor.pose();
    let stream = match source.is_tray {
        true => Stream::TrayCloud,
        false => Stream::Cloud,
    };
    let way = Way {
        publisher: Publisher::new(process, &cell, stream)?,
        cell,
        sensor: source.sensor.clone(),
        container_from_sensor: pose.map_err(ServiceError::start)?,
        sequence: AtomicU64::new(1),
    };
    let name = topic.clone();
    let pass = move |payload| {
        if let Err(error) = way.take(&payload) {
            tracing::debug!(topic = %name, cell = %way.cell, %error, "a cloud is not passed on");
        }
    };
    let subscribed =
        node.subscribe_payloads::<sensor_msgs::PointCloud2>(&topic, Qos::SENSOR, pass)?;
    Ok(subscribed)
}

impl Way {
    fn take(&self, payload: &ZBytes) -> Result<(), FaceError> {
        // A larger payload is not even put together.
        topic::check_size(payload.len())?;
        let payload = payload.to_bytes();
        let message = PointCloud2::read(&payload)?;
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed);
        let mut cloud = to_cloud(&message, sequence, &self.container_from_sensor)?;
        cloud.sensor.clone_from(&self.sensor);
        cloud.cell = self.cell.to_string();
        self.publisher.put(&cloud)?;
        Ok(())
    }
}
