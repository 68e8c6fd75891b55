//! Names of topics, services and actions.

use crate::error::RosError;

/// A name from the root, such as `/ppnpack/cell_1/state`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name(String);

impl Name {
    /// The name, as it is written.
    ///
    /// # Errors
    /// [`RosError::Name`] where ROS has no such name.
    pub fn new(name: &str) -> Result<Self, RosError> {
        let parts = name.strip_prefix('/').map(|parts| parts.split('/'));
        let is_possible = parts.is_some_and(|mut parts| parts.all(is_part));
        if is_possible {
            Ok(Self(name.to_owned()))
        } else {
            Err(RosError::Name(name.chars().take(80).collect()))
        }
    }

    /// A name below this one; `name` has no slash at its beginning.
    ///
    /// # Errors
    /// [`RosError::Name`] where ROS has no such name.
    pub fn join(&self, name: &str) -> Result<Self, RosError> {
        Self::new(&format!("{self}/{name}"))
    }

    /// The name, as it is written.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// Whether this is a part of a name between slashes.
fn is_part(part: &str) -> bool {
    let begins = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'_';
    let goes_on = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    part.bytes().next().is_some_and(|first| begins(&first)) && part.bytes().all(goes_on)
}

/// A name as a part of a name of ROS: what that may not hold becomes `_`, and what begins with a digit gets one before it.
pub fn part_of(name: &str) -> String {
    let part: String = name
        .chars()
        .map(|it| if it.is_ascii_alphanumeric() { it } else { '_' })
        .collect();
    if is_part(&part) {
        part
    } else {
        format!("_{part}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_ros_are_told_from_others() {
        for name in ["/tf", "/ppnpack/cell_1/state", "/a/_action/send_goal"] {
            assert_eq!(Name::new(name).unwrap().as_str(), name);
        }
        for name in [
            "", "/", "tf", "/tf/", "//tf", "/1", "/a-b", "/a b", "/ä", "/a*",
        ] {
            assert!(Name::new(name).is_err(), "{name}");
        }
    }

    #[test]
    fn every_name_of_a_cell_has_one_in_ros() {
        for (name, part) in [
            ("cell-1", "cell_1"),
            ("1", "_1"),
            ("a_b", "a_b"),
            ("-", "_"),
        ] {
            assert_eq!(part_of(name), part);
            assert!(Name::new(&format!("/{part}")).is_ok());
        }
    }
}
