//! What perception sees of a container: clouds, and the heightmap.

use ppnpack_ros::Qos;
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::sensor_msgs::PointCloud2;
use ppnpack_ros::names::Name;
use ppnpack_wire::convert::cloud;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_CLOUD_BYTES, MAX_MESSAGE_BYTES, v1};

use super::follow::Followed;
use crate::cells::Common;
use crate::convert::points;
use crate::error::FaceError;
use crate::frames;

/// Perception of a container in ROS.
pub(crate) struct PerceptionFace {
    cell: Cell,
    cloud: Followed<v1::PointCloud, PointCloud2>,
    heightmap: Followed<v1::Heightmap, PointCloud2>,
}

impl PerceptionFace {
    pub(crate) fn new(common: &Common, name: &Name, cell: &Cell) -> Result<Self, FaceError> {
        let node = &common.node;
        let cloud = node.publisher(&name.join("cloud")?, Qos::SENSOR)?;
        let heightmap = node.publisher(&name.join("heightmap")?, Qos::SENSOR)?;
        Ok(Self {
            cloud: Followed::new(cell, Stream::Cloud, MAX_CLOUD_BYTES, cloud),
            heightmap: Followed::new(cell, Stream::Heightmap, MAX_MESSAGE_BYTES, heightmap),
            cell: cell.clone(),
        })
    }

    pub(crate) fn advance(&mut self, common: &Common) -> Result<(), FaceError> {
        if let Some(message) = self.heightmap.newest(&common.process)? {
            let made = points::heightmap(&self.cell, &message);
            self.heightmap.pass_on(made)?;
        }
        if let Some(message) = self.cloud.newest(&common.process)? {
            self.pass_cloud(common, &message)?;
        }
        Ok(())
    }

    /// Passes a cloud on, once it was said where its sensor is.
    fn pass_cloud(&self, common: &Common, message: &v1::PointCloud) -> Result<(), FaceError> {
        let read = cloud::read(message);
        if let Ok(cloud) = &read {
            let frame = frames::sensor(&self.cell, &message.sensor);
            let pose = *cloud.container_from_sensor();
            // A sensor that moves is elsewhere by now.
            let at = Time::from_ns(cloud.captured_at_ns());
            common.frames.tell(&self.cell, &at, [(frame, pose)])?;
        }
        self.cloud
            .pass_on(read.map(|cloud| points::cloud(&self.cell, &cloud)))
    }
}
