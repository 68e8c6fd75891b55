//! Keys of topics and services, and the tokens by which others know who has them.
//!
//! | key | what |
//! |---|---|
//! | `<domain>/<topic>/<type>/<hash>` | what a topic carries; requests of a service |
//! | `@ros2_lv/<domain>/<session>/<node>/<node>/NN/%/<namespace>/<name>` | a node is there |
//! | `@ros2_lv/<domain>/<session>/<node>/<endpoint>/<kind>/%/<namespace>/<name>/<topic>/<type>/<hash>/<qos>` | an endpoint of it is there |
//!
//! In tokens each `/` of a name is written as `%`.

use std::fmt;

use crate::description::{Message, TypeHash};
use crate::names::Name;
use crate::qos::Qos;
use crate::service::Service;

/// A type as keys name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TypeKey {
    name: String,
    hash: TypeHash,
}

impl TypeKey {
    /// That of a message.
    pub fn of_message<M: Message>() -> Self {
        Self {
            name: mangled(&M::type_name()),
            hash: TypeHash::of_message::<M>(),
        }
    }

    /// That of a service.
    pub fn of_service<S: Service>() -> Self {
        Self {
            name: mangled(&S::type_name()),
            hash: TypeHash::of_service::<S>(),
        }
    }
}

/// As keys write the name of a type: `std_msgs/msg/String` is `std_msgs::msg::dds_::String_`.
fn mangled(type_name: &str) -> String {
    match type_name.rsplit_once('/') {
        Some((namespace, name)) => format!("{}::dds_::{name}_", namespace.replace('/', "::")),
        None => format!("{type_name}_"),
    }
}

/// The key of a topic or a service in a domain.
pub fn data(domain: u32, topic: &Name, of: &TypeKey) -> String {
    let topic = topic.as_str().trim_start_matches('/');
    format!("{domain}/{topic}/{}/{}", of.name, of.hash)
}

/// What an endpoint does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Publishes a topic.
    Publisher,
    /// Answers a service.
    Server,
}

impl Kind {
    fn as_str(self) -> &'static str {
        match self {
            Self::Publisher => "MP",
            Self::Server => "SS",
        }
    }
}

/// A node, as its tokens name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeKey {
    /// The domain that it belongs to.
    pub domain: u32,
    /// The Zenoh session that it is of.
    pub session: String,
    /// Its number in the session.
    pub id: u32,
    /// Its name: the last part is its own, what is before it its namespace.
    pub name: Name,
}

impl NodeKey {
    /// The token that says that it is there.
    pub fn token(&self) -> String {
        let id = self.id;
        self.any(id, "NN")
    }

    /// The token that says that an endpoint of it is there.
    pub fn endpoint(&self, id: u32, kind: Kind, topic: &Name, of: &TypeKey, qos: Qos) -> String {
        let begin = self.any(id, kind.as_str());
        let topic = topic.as_str().replace('/', "%");
        format!("{begin}/{topic}/{}/{}/{qos}", of.name, of.hash)
    }

    fn any(&self, id: u32, kind: impl fmt::Display) -> String {
        let Self {
            domain, session, ..
        } = self;
        let (namespace, name) = self.name.as_str().rsplit_once('/').unwrap_or_default();
        let namespace = match namespace {
            "" => "%".to_owned(),
            other => other.replace('/', "%"),
        };
        let node = self.id;
        format!("@ros2_lv/{domain}/{session}/{node}/{id}/{kind}/%/{namespace}/{name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::std_msgs::Text;
    use crate::messages::std_srvs::Trigger;

    fn node(name: &str) -> NodeKey {
        NodeKey {
            domain: 2,
            session: "a1b2".to_owned(),
            id: 4,
            name: Name::new(name).unwrap(),
        }
    }

    #[test]
    fn keys_are_those_of_rmw_zenoh() {
        let topic = Name::new("/robot1/chatter").unwrap();
        let text = TypeKey::of_message::<Text>();
        let hash = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
        assert_eq!(
            data(2, &topic, &text),
            format!("2/robot1/chatter/std_msgs::msg::dds_::String_/{hash}")
        );
        assert_eq!(
            node("/talker").endpoint(11, Kind::Publisher, &topic, &text, Qos::EVENTS),
            format!(
                "@ros2_lv/2/a1b2/4/11/MP/%/%/talker/%robot1%chatter/std_msgs::msg::dds_::String_/{hash}/::,10:,:,:,,"
            )
        );
        let trigger = TypeKey::of_service::<Trigger>();
        assert_eq!(
            node("/a/b/server").endpoint(5, Kind::Server, &topic, &trigger, Qos::EVENTS),
            "@ros2_lv/2/a1b2/4/5/SS/%/%a%b/server/%robot1%chatter/std_srvs::srv::dds_::Trigger_/\
             RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f/::,10:,:,:,,"
        );
    }

    #[test]
    fn nodes_have_tokens_with_and_without_a_namespace() {
        assert_eq!(node("/talker").token(), "@ros2_lv/2/a1b2/4/4/NN/%/%/talker");
        assert_eq!(
            node("/a/b/talker").token(),
            "@ros2_lv/2/a1b2/4/4/NN/%/%a%b/talker"
        );
    }
}
