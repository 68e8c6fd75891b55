//! What perception sees of a container: the heightmap.

use ppnpack_ros::Qos;
use ppnpack_ros::messages::sensor_msgs::PointCloud2;
use ppnpack_ros::names::Name;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use super::follow::Followed;
use crate::cells::Common;
use crate::convert::points;
use crate::error::FaceError;

/// Perception of a container in ROS.
pub(crate) struct PerceptionFace {
    cell: Cell,
    heightmap: Followed<v1::Heightmap, PointCloud2>,
}

impl PerceptionFace {
    pub(crate) fn new(common: &Common, name: &Name, cell: &Cell) -> Result<Self, FaceError> {
        let heightmap = common
            .node
            .publisher(&name.join("heightmap")?, Qos::SENSOR)?;
        Ok(Self {
            heightmap: Followed::new(cell, Stream::Heightmap, heightmap),
            cell: cell.clone(),
        })
    }

    pub(crate) fn advance(&mut self, common: &Common) -> Result<(), FaceError> {
        let Some(message) = self.heightmap.newest(&common.process)? else {
            return Ok(());
        };
        let made = points::heightmap(&self.cell, &message);
        self.heightmap.pass_on(made)
    }
}
