//! Names of topics and services, their keys, and the tokens by which others know who has them.
//!
//! | key | what |
//! |---|---|
//! | `<domain>/<topic>/<type>/<hash>` | what a topic carries; requests of a service |
//! | `@ros2_lv/<domain>/<session>/0/0/NN/%/<namespace>/<name>` | a node is there |
//! | `@ros2_lv/<domain>/<session>/0/<endpoint>/<kind>/%/<namespace>/<name>/<topic>/<type>/<hash>/<qos>` | an endpoint of it is there |
//!
//! In tokens each `/` of a name is written as `%`. A session has one node, of number 0.

use crate::error::RosError;

/// A name from the root, such as `/ppnpack/cell_1/state`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Name(String);

impl Name {
    /// The root, which names begin with.
    pub(crate) const ROOT: Self = Self(String::new());

    /// Reads a name.
    ///
    /// # Errors
    /// [`RosError::Name`] where ROS has no such name.
    pub(crate) fn new(name: &str) -> Result<Self, RosError> {
        let parts = name.strip_prefix('/').map(|parts| parts.split('/'));
        match parts.is_some_and(|mut parts| parts.all(is_part)) {
            true => Ok(Self(name.to_owned())),
            false => Err(RosError::Name(name.chars().take(80).collect())),
        }
    }

    /// Gives a name below this one. A forbidden character becomes `_`, and a digit at the beginning
    /// gets one before it.
    pub(crate) fn join(&self, part: &str) -> Self {
        let replaced = |it: char| if it.is_ascii_alphanumeric() { it } else { '_' };
        let part: String = part.chars().map(replaced).collect();
        let begin = if is_part(&part) { "" } else { "_" };
        Self(format!("{}/{begin}{part}", self.0))
    }

    /// Gives the name as it is in tokens.
    fn mangled(&self) -> String {
        self.0.replace('/', "%")
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// Tells whether this is a part of a name between slashes.
fn is_part(part: &str) -> bool {
    let goes_on = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    part.bytes().all(goes_on) && part.starts_with(|first: char| !first.is_ascii_digit())
}

/// The quality of service of a topic. Zenoh matches any publisher with any subscriber: it tells
/// others what to expect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Qos {
    /// Services: every message is wanted.
    Services,
    /// Frames where they are now.
    Frames,
    /// States, "transient local": whoever comes later is given the last message.
    Latched,
}

impl Qos {
    /// Gives reliability, durability, history and depth as tokens have them, without defaults.
    fn as_str(self) -> &'static str {
        match self {
            Self::Services => "::,10:,:,:,,",
            Self::Frames => "::,100:,:,:,,",
            Self::Latched => ":1:,1:,:,:,,",
        }
    }
}

/// Gives the key of a topic or a service of a type in a domain.
pub(crate) fn data(domain: u32, topic: &Name, of: &str) -> String {
    format!("{domain}{topic}/{of}")
}

/// The kinds of endpoints, as tokens name them.
pub(super) const PUBLISHER: &str = "MP";
pub(super) const SERVER: &str = "SS";

/// A node, as its tokens name it.
#[derive(Debug)]
pub(super) struct NodeKey {
    pub(super) domain: u32,
    pub(super) session: String,
    /// The last part is its own name, what is before it its namespace.
    pub(super) name: Name,
}

impl NodeKey {
    /// Gives the token that says that the node is there.
    pub(super) fn token(&self) -> String {
        self.any(0, "NN")
    }

    /// Gives the token that says that an endpoint of it is there.
    pub(super) fn endpoint(&self, id: u32, kind: &str, topic: &Name, of: &str, qos: Qos) -> String {
        let begin = self.any(id, kind);
        format!("{begin}/{}/{of}/{}", topic.mangled(), qos.as_str())
    }

    fn any(&self, id: u32, kind: &str) -> String {
        let Self {
            domain, session, ..
        } = self;
        let (namespace, name) = self.name.0.rsplit_once('/').unwrap_or_default();
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        let namespace = namespace.replace('/', "%");
        format!("@ros2_lv/{domain}/{session}/0/{id}/{kind}/%/{namespace}/{name}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::messages::{TfMessage, Trigger, Typed};
    use super::*;

    #[test]
    fn names_of_ros_are_told_from_others() {
        for name in ["/tf", "/ppnpack/cell_1/state", "/_a"] {
            assert_eq!(Name::new(name).unwrap().to_string(), name);
        }
        for name in [
            "", "/", "tf", "/tf/", "//tf", "/1", "/a-b", "/a b", "/ä", "/a*",
        ] {
            assert!(Name::new(name).is_err(), "{name}");
        }
    }

    #[test]
    fn every_name_of_a_cell_has_one_in_ros() {
        for (cell, name) in [
            ("cell-1", "/cell_1"),
            ("1", "/_1"),
            ("a_b", "/a_b"),
            ("-", "/_"),
        ] {
            let joined = Name::ROOT.join(cell);
            assert_eq!(joined.to_string(), name);
            assert_eq!(Name::new(name).unwrap(), joined);
        }
    }

    #[test]
    fn keys_are_those_of_rmw_zenoh() {
        let node = |name: &str| NodeKey {
            domain: 2,
            session: "a1b2".to_owned(),
            name: Name::new(name).unwrap(),
        };
        let (topic, key) = (Name::new("/robot1/chatter").unwrap(), TfMessage::key());
        let of = "tf2_msgs::msg::dds_::TFMessage_/\
             RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087";
        assert_eq!(data(2, &topic, &key), format!("2/robot1/chatter/{of}"));
        assert_eq!(
            node("/talker").endpoint(11, PUBLISHER, &topic, &key, Qos::Services),
            format!("@ros2_lv/2/a1b2/0/11/MP/%/%/talker/%robot1%chatter/{of}/::,10:,:,:,,")
        );
        assert_eq!(
            node("/a/b/server").endpoint(5, SERVER, &topic, &Trigger::key(), Qos::Services),
            "@ros2_lv/2/a1b2/0/5/SS/%/%a%b/server/%robot1%chatter/std_srvs::srv::dds_::Trigger_/\
             RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f/::,10:,:,:,,"
        );
        assert_eq!(node("/talker").token(), "@ros2_lv/2/a1b2/0/0/NN/%/%/talker");
        assert_eq!(node("/a/b/c").token(), "@ros2_lv/2/a1b2/0/0/NN/%/%a%b/c");
    }
}
