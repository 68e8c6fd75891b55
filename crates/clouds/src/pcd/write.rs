//! PCD files to be written.

use crate::cloud::Cloud;

/// The content of a binary PCD file with a cloud's points, holes included.
pub fn to_pcd(cloud: &Cloud) -> Vec<u8> {
    let header = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n\
         WIDTH {}\nHEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
        cloud.width(),
        cloud.height(),
        cloud.points_m().len()
    );
    let mut content = Vec::with_capacity(header.len() + 12 * cloud.points_m().len());
    content.extend_from_slice(header.as_bytes());
    for point in cloud.points_m() {
        for side_m in point.iter() {
            content.extend_from_slice(&side_m.to_le_bytes());
        }
    }
    content
}
