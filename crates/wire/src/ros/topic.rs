//! The keys of ROS 2.
//!
//! `rmw_zenoh` publishes a topic under `<domain>/<topic>/<type>/<hash>`, such as
//! `0/camera/depth/points/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_...`; the bridge of ROS 2
//! over DDS under the topic's name alone, without its first slash.

use crate::decode::MAX_CLOUD_BYTES;
use crate::error::{self, WireError};

/// The type that is read, as keys name it.
const POINT_CLOUD2: &str = "sensor_msgs::msg::dds_::PointCloud2_";

/// Checks that a key or key expression names no other type. One that names none may have any.
///
/// # Errors
/// [`WireError::Invalid`] where it names another type.
pub fn check_key(key: &str) -> Result<(), WireError> {
    // No name of a topic has a colon in it.
    let named = |chunk: &&str| chunk.contains("::") && !chunk.contains('*');
    let mut others = key.split('/').filter(named);
    let Some(other) = others.find(|name| *name != POINT_CLOUD2) else {
        return Ok(());
    };
    let other: String = other.chars().take(80).collect();
    let reason = format_args!("'{other}' is not read, only sensor_msgs/msg/PointCloud2 is");
    Err(WireError::invalid("type", reason))
}

/// Checks the size of a payload before it is put together.
///
/// # Errors
/// [`WireError::TooLarge`] where it is larger than the largest cloud.
pub fn check_size(bytes: usize) -> Result<(), WireError> {
    error::check_size("PointCloud2", bytes, MAX_CLOUD_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_other_types_are_told_apart() {
        for key in [
            "0/camera/depth/points/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_91",
            "0/camera/depth/points/sensor_msgs::msg::dds_::PointCloud2_/TypeHashNotSupported",
            "0/camera/depth/points/$*::msg::dds_::$*/*",
            "0/camera/depth/points/**",
            "camera/depth/points",
        ] {
            assert_eq!(check_key(key), Ok(()), "{key}");
        }
        for (key, named) in [
            (
                "0/camera/depth/image/sensor_msgs::msg::dds_::Image_/RIHS01_91",
                "type: 'sensor_msgs::msg::dds_::Image_' is not read, only sensor_msgs/msg/PointCloud2 is",
            ),
            (
                "0/points/my_msgs::msg::dds_::PointCloud2_/**",
                "'my_msgs::msg::dds_::PointCloud2_'",
            ),
        ] {
            let error = check_key(key).unwrap_err().to_string();
            assert!(error.contains(named), "{error}");
        }
        let long = check_key(&"x::".repeat(1000)).unwrap_err().to_string();
        assert!(long.len() < 200, "{long}");
    }
}
