//! The keys of ROS 2.
//!
//! `rmw_zenoh` publishes a topic under `<domain>/<topic>/<type>/<hash>`, such as
//! `0/camera/depth/points/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_...`; the bridge of ROS 2
//! over DDS under the topic's name alone, without its first slash.

use crate::decode::MAX_CLOUD_BYTES;
use crate::error::{self, WireError};

/// The type that is read, as people write it.
pub const POINT_CLOUD2: &str = "sensor_msgs/msg/PointCloud2";

/// The type that is read, in all the ways that it is written.
const NAMES: [&str; 3] = [
    POINT_CLOUD2,
    "sensor_msgs/PointCloud2",
    "sensor_msgs::msg::dds_::PointCloud2_",
];

/// Checks the name of a type.
///
/// # Errors
/// [`WireError::Invalid`] where it is not that of a PointCloud2.
pub fn check_type(name: &str) -> Result<(), WireError> {
    if NAMES.contains(&name) {
        return Ok(());
    }
    let name: String = name.chars().take(80).collect();
    let reason = format_args!("'{name}' is not read, only {POINT_CLOUD2} is");
    Err(WireError::invalid("type", reason))
}

/// Checks that a key or key expression names no other type. One that names none may have any.
///
/// # Errors
/// [`WireError::Invalid`] where it names another type.
pub fn check_key(key: &str) -> Result<(), WireError> {
    // No name of a topic has a colon in it.
    let mut named = key
        .split('/')
        .filter(|chunk| chunk.contains("::") && !chunk.contains('*'));
    named.try_for_each(check_type)
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
        for key in [
            "0/camera/depth/image/sensor_msgs::msg::dds_::Image_/RIHS01_91",
            "0/points/my_msgs::msg::dds_::PointCloud2_/**",
        ] {
            assert!(check_key(key).is_err(), "{key}");
        }
    }

    #[test]
    fn one_type_is_known() {
        for name in NAMES {
            assert_eq!(check_type(name), Ok(()));
        }
        let error = check_type("sensor_msgs/msg/Image").unwrap_err();
        assert_eq!(
            error.to_string(),
            "type: 'sensor_msgs/msg/Image' is not read, only sensor_msgs/msg/PointCloud2 is"
        );
        assert!(check_type(&"x".repeat(1000)).unwrap_err().to_string().len() < 200);
    }
}
