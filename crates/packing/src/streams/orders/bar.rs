//! Why a container may not take an item, wherever it would lie there.

use std::sync::Arc;

use super::ties::Tie;

/// Why an item may not go into a container.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Bar {
    /// There is no such container.
    #[error("broken invariant \"what may take an item is open\": there is no container {0}")]
    NotOpen(usize),
    /// The container is for one order, and this is another one's.
    #[error("the container is for order {0}")]
    OtherOrder(Arc<str>),
    /// It must not travel with what is in there.
    #[error("{0} must not travel with {1}")]
    GroupsApart(Arc<str>, Arc<str>),
    /// The container would be too heavy.
    #[error("the container would be {over_kg:.2} kg too heavy")]
    TooHeavy {
        /// Excess, in kilograms.
        over_kg: f64,
    },
    /// It must travel with items that are in another container.
    #[error("{tie}, and others of them are in {}", if *.is_closed { "a container that was closed" } else { "another container" })]
    TiedElsewhere {
        /// Tie to those items.
        tie: Tie,
        /// Whether nothing can follow them any more.
        is_closed: bool,
    },
    /// It must travel with items that have to follow others into another container.
    #[error("{0}, and others of them have to follow items in another container")]
    ChainedElsewhere(Tie),
    /// The container may not take what has to travel with the item.
    #[error("{tie}, and of all of them together: {bar}")]
    WithOthers {
        /// Tie of the item.
        tie: Tie,
        /// Why not.
        bar: Box<Bar>,
    },
    /// The container is kept for items that have to follow others, with which the item does not go.
    #[error("{tie}, and others of them have to follow into this container: {bar}")]
    KeptFor {
        /// Tie of those items.
        tie: Tie,
        /// Why the item does not go with them.
        bar: Box<Bar>,
    },
    /// Other items of its order lie in another open container. Gives way.
    #[error("order {0} is in another container")]
    OrderElsewhere(Arc<str>),
    /// Orders are packed one after another, and one before it waits. Gives way.
    #[error("order {0} comes before")]
    EarlierOrder(Arc<str>),
}

impl Bar {
    /// Whether it is broken where nothing else could be packed.
    pub fn gives_way(&self) -> bool {
        matches!(self, Self::OrderElsewhere(_) | Self::EarlierOrder(_))
    }
}
