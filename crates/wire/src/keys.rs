//! Every key expression of the wire, built and parsed here and nowhere else.
//!
//! | key | what |
//! |---|---|
//! | `ppnpack/v1/<cell>/<stream>` | data of a cell |
//! | `ppnpack/v1/<cell>/rpc/<service>/<method>` | a request to any instance of a service that serves the cell |
//! | `ppnpack/v1/<cell>/rpc/<service>/<method>/<instance>` | a request to this instance |
//! | `ppnpack/v1/<cell>/@live/<service>/<instance>/<start>` | there while this start of the instance is alive |
//!
//! Services of any cell are alive under the cell [`ALL_CELLS`]. Under it every instance also
//! answers `health`: to its name, and to that of its [`Start`], which no other process has.

use std::cmp::Reverse;
use std::fmt;

pub use crate::rpc::Method;

/// Prefix of all keys: the name of the protocol and its version.
const PREFIX: &str = "ppnpack/v1";

/// The cell of what belongs to no single cell. No cell may have this name.
pub const ALL_CELLS: &str = "all";

/// The reason for which a name or a key was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum KeyError {
    /// A name has characters that keys cannot have.
    #[error(
        "'{name}' is no name of a {what}: 1 to 64 characters of a-z, 0-9, _ and - are possible"
    )]
    Name {
        /// The kind of thing that it names.
        what: &'static str,
        /// Gives the name.
        name: String,
    },
    /// A cell has the name that stands for all cells.
    #[error("a cell cannot be called '{ALL_CELLS}'")]
    Reserved,
    /// It is no key of this protocol.
    #[error("'{0}' is no key of this protocol")]
    Unknown(String),
}

/// The name of a cell: 1 to 64 characters of `[a-z0-9_-]`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(String);

/// The name of a running process of a service: 1 to 64 characters of `[a-z0-9_-]`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instance(String);

/// A start of an instance, the fencing token of a cell's lease: it tells apart two of one name, and
/// of two holders the one that stays. In keys it has 24 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Start {
    /// The number of those known to have served the cell before, one after another.
    pub term: u32,
    /// The start of the process, in seconds since 1970, above 32 random bits.
    pub nonce: u64,
}

fn name(what: &'static str, text: &str) -> Result<String, KeyError> {
    let is_possible = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
    if (1..=64).contains(&text.len()) && text.bytes().all(is_possible) {
        return Ok(text.to_owned());
    }
    let name = text.chars().take(80).collect();
    Err(KeyError::Name { what, name })
}

impl Cell {
    /// Makes the cell of this name.
    ///
    /// # Errors
    /// [`KeyError::Name`] and [`KeyError::Reserved`].
    pub fn new(text: &str) -> Result<Self, KeyError> {
        if text == ALL_CELLS {
            return Err(KeyError::Reserved);
        }
        name("cell", text).map(Self)
    }

    /// Gives the name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Instance {
    /// Makes the instance of this name.
    ///
    /// # Errors
    /// [`KeyError::Name`].
    pub fn new(text: &str) -> Result<Self, KeyError> {
        name("service's instance", text).map(Self)
    }

    /// Gives the name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Start {
    /// Ranks those that serve one cell, of which the greatest stays: by their terms, else by which
    /// was there first.
    pub fn rank(self) -> impl Ord {
        (self.term, Reverse(self.nonce))
    }

    /// Gives the name to which its process alone answers `health`.
    pub fn name(self) -> Instance {
        Instance(format!("{:016x}", self.nonce))
    }

    fn parse(text: &str) -> Option<Self> {
        let is_digit = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
        let (term, nonce) = text.split_at_checked(8)?;
        (nonce.len() == 16 && text.bytes().all(is_digit)).then_some(())?;
        Some(Self {
            term: u32::from_str_radix(term, 16).ok()?,
            nonce: u64::from_str_radix(nonce, 16).ok()?,
        })
    }
}

impl fmt::Display for Start {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:08x}{:016x}", self.term, self.nonce)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl fmt::Display for Instance {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// An enum whose variants are chunks of keys.
macro_rules! chunks {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)*
        }

        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Gives its text in keys.
            pub fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }

            pub(crate) fn parse(text: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|known| known.as_str() == text)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(self.as_str())
            }
        }
    };
}
pub(crate) use chunks;

chunks! {
    /// A stream that a cell publishes.
    Stream {
        /// [`PointCloud`](crate::v1::PointCloud) of the sensor.
        Cloud = "cloud",
        /// [`PointCloud`](crate::v1::PointCloud) of the sensor above the tray.
        TrayCloud = "tray_cloud",
        /// [`Heightmap`](crate::v1::Heightmap): the container's content, from perception.
        Heightmap = "heightmap",
        /// [`CellState`](crate::v1::CellState), from the bridge.
        State = "state",
        /// [`Outcome`](crate::v1::Outcome) of placements, from the bridge.
        Outcome = "outcome",
        /// [`Decision`](crate::v1::Decision), from the planner.
        Plan = "plan",
        /// [`Session`](crate::v1::Session): the packing session, from the planner.
        Session = "session",
        /// [`PlanningRecord`](crate::v1::PlanningRecord) of steps, from the planner.
        Record = "record",
    }
}

chunks! {
    /// A service.
    Service {
        /// Point clouds to heightmaps.
        Perception = "perception",
        /// Proposals of the network.
        Ppn = "ppn",
        /// Values of placements.
        Heuristic = "heuristic",
        /// The cell itself: robot and container.
        Bridge = "bridge",
        /// Robots that are programs of their own, behind the bridge.
        Robot = "robot",
        /// Decisions.
        Planner = "planner",
        /// Passes messages on between the others.
        Router = "router",
        /// Streams and requests of the cells, in ROS 2.
        Ros = "ros",
        /// The operator's page.
        Console = "console",
    }
}

/// A key of the protocol.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Key {
    /// Data of a cell.
    Stream(Cell, Stream),
    /// A request; `None` for the cell is [`ALL_CELLS`], `None` for the instance any of them.
    Request(Option<Cell>, Service, Method, Option<Instance>),
    /// Says that an instance is alive; `None` for the cell is [`ALL_CELLS`].
    Alive(Option<Cell>, Service, Instance, Start),
}

impl Key {
    /// Parses a key.
    ///
    /// # Errors
    /// [`KeyError`] where it is none of this protocol.
    pub fn parse(text: &str) -> Result<Self, KeyError> {
        let unknown = || KeyError::Unknown(text.chars().take(200).collect());
        let rest = text.strip_prefix(PREFIX).ok_or_else(unknown)?;
        let chunks: Vec<&str> = rest.split('/').collect();
        let cell = |name: &str| match name {
            ALL_CELLS => Ok(None),
            name => Cell::new(name).map(Some),
        };
        match chunks.as_slice() {
            ["", name, stream] => {
                let stream = Stream::parse(stream).ok_or_else(unknown)?;
                Ok(Self::Stream(Cell::new(name)?, stream))
            }
            ["", name, "rpc", service, method, instance @ ..] => {
                let service = Service::parse(service).ok_or_else(unknown)?;
                let method = Method::parse(method).ok_or_else(unknown)?;
                let instance = match instance {
                    [] => None,
                    [instance] => Some(Instance::new(instance)?),
                    _ => return Err(unknown()),
                };
                Ok(Self::Request(cell(name)?, service, method, instance))
            }
            ["", name, "@live", service, instance, start] => {
                let service = Service::parse(service).ok_or_else(unknown)?;
                let instance = Instance::new(instance)?;
                let start = Start::parse(start).ok_or_else(unknown)?;
                Ok(Self::Alive(cell(name)?, service, instance, start))
            }
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Key {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cell = match self {
            Self::Stream(cell, _) => Some(cell),
            Self::Request(cell, ..) | Self::Alive(cell, ..) => cell.as_ref(),
        };
        write!(
            formatter,
            "{PREFIX}/{}",
            cell.map_or(ALL_CELLS, Cell::as_str)
        )?;
        match self {
            Self::Stream(_, stream) => write!(formatter, "/{stream}"),
            Self::Request(_, service, method, instance) => {
                write!(formatter, "/rpc/{service}/{method}")?;
                instance
                    .iter()
                    .try_for_each(|instance| write!(formatter, "/{instance}"))
            }
            Self::Alive(_, service, instance, start) => {
                write!(formatter, "/@live/{service}/{instance}/{start}")
            }
        }
    }
}

/// Gives the key expression of everything that belongs to this protocol.
pub fn everything() -> String {
    format!("{PREFIX}/**")
}

/// Gives the key expression of a stream of every cell.
pub fn every_cell(stream: Stream) -> String {
    format!("{PREFIX}/*/{stream}")
}

/// Gives the key expressions on which an instance answers a method, for one cell or every: sent to
/// any instance, and to each of its names.
pub fn answered(
    cell: Option<&Cell>,
    service: Service,
    method: Method,
    names: &[Instance],
) -> (String, Vec<String>) {
    let cell = cell.map_or("*", Cell::as_str);
    let any = format!("{PREFIX}/{cell}/rpc/{service}/{method}");
    let own = names.iter().map(|name| format!("{any}/{name}")).collect();
    (any, own)
}

/// Gives the key expression of everything that is alive: of one service, or of all.
pub fn everything_alive(service: Option<Service>) -> String {
    let service = service.map_or("*", Service::as_str);
    format!("{PREFIX}/*/@live/{service}/*/*")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_of<T: Copy + fmt::Debug + 'static>(all: &'static [T]) -> impl Strategy<Value = T> {
        proptest::sample::select(all)
    }

    fn any_cell() -> impl Strategy<Value = Cell> {
        "[a-z0-9_-]{1,64}".prop_filter_map("reserved", |name| Cell::new(&name).ok())
    }

    fn any_key() -> impl Strategy<Value = Key> {
        let instance = || "[a-z0-9_-]{1,64}".prop_map(|name| Instance::new(&name).unwrap());
        let cell = || proptest::option::of(any_cell());
        let start = (any::<u32>(), any::<u64>()).prop_map(|(term, nonce)| Start { term, nonce });
        prop_oneof![
            (any_cell(), any_of(Stream::ALL)).prop_map(|(cell, stream)| Key::Stream(cell, stream)),
            (
                cell(),
                any_of(Service::ALL),
                any_of(Method::ALL),
                proptest::option::of(instance())
            )
                .prop_map(|(cell, service, method, instance)| Key::Request(
                    cell, service, method, instance
                )),
            (cell(), any_of(Service::ALL), instance(), start).prop_map(
                |(cell, service, instance, start)| Key::Alive(cell, service, instance, start)
            ),
        ]
    }

    proptest! {
        #[test]
        fn every_key_is_parsed_as_it_was_built(key in any_key()) {
            prop_assert_eq!(Key::parse(&key.to_string()), Ok(key));
        }

        #[test]
        fn what_is_parsed_is_built_as_it_was(text in "(ppnpack/v1/)?[a-z@/*-]{0,40}") {
            if let Ok(key) = Key::parse(&text) {
                prop_assert_eq!(key.to_string(), text);
            }
        }
    }

    #[test]
    fn keys_are_what_the_protocol_says() {
        let cell = Cell::new("cell-1").unwrap();
        let instance = Instance::new("h1").unwrap();
        let start = Start {
            term: 2,
            nonce: 0xbeef,
        };
        assert_eq!(start.name().as_str(), "000000000000beef");
        let (planner, own) = (Service::Planner, Some(instance.clone()));
        for (key, text) in [
            (Key::Stream(cell.clone(), Stream::Cloud), "cell-1/cloud"),
            (
                Key::Request(Some(cell), planner, Method::Plan, None),
                "cell-1/rpc/planner/plan",
            ),
            (
                Key::Request(None, Service::Ppn, Method::Health, own),
                "all/rpc/ppn/health/h1",
            ),
            (
                Key::Alive(None, Service::Heuristic, instance, start),
                "all/@live/heuristic/h1/00000002000000000000beef",
            ),
        ] {
            let text = format!("ppnpack/v1/{text}");
            assert_eq!(key.to_string(), text);
            assert_eq!(Key::parse(&text), Ok(key));
        }
    }

    #[test]
    fn who_took_over_stays_and_else_who_was_there_first() {
        let start = |term, nonce| Start { term, nonce };
        assert!(start(0, 7).rank() > start(0, 8).rank());
        assert!(start(1, 8).rank() > start(0, 7).rank());
        assert!(start(1, 8).rank() > start(1, 9).rank());
    }

    #[test]
    fn other_names_and_keys_are_refused() {
        let long = "a".repeat(65);
        for name in ["", "A", "a/b", "*", "ä", long.as_str()] {
            assert!(Cell::new(name).is_err(), "{name}");
        }
        assert_eq!(Cell::new("all"), Err(KeyError::Reserved));
        for key in [
            "ppnpack/v2/c/cloud",
            "ppnpack/v1/c/clouds",
            "ppnpack/v1/c/rpc/planner",
            "ppnpack/v1/c/rpc/planner/plan/a/b",
            "ppnpack/v1/all/cloud",
            "ppnpack/v1/all/log",
            "ppnpack/v1/c/log/h1",
            "ppnpack/v1cell/cloud",
            "ppnpack/v1/all/@live/heuristic/h1",
            "ppnpack/v1/all/@live/heuristic/h1/2",
            "ppnpack/v1/all/@live/heuristic/h1/+0000002000000000000beef",
            "ppnpack/v1/all/@live/heuristic/h1/00000002000000000000BEEF",
        ] {
            assert!(Key::parse(key).is_err(), "{key}");
        }
    }
}
