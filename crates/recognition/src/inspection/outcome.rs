//! What an inspection is made from, and what it tells.

use nalgebra::Point3;

use crate::inspection::lying::Lying;

/// What a depth camera above a container sees.
#[derive(Debug, Clone, Copy)]
pub struct ContainerCloud<'points> {
    /// Points in the container frame, in metres. Those with a coordinate that is not finite are left out.
    pub points_m: &'points [Point3<f64>],
    /// Where the camera is in the container frame, in metres.
    pub eye_m: Point3<f64>,
}

/// What became of an item that was placed.
#[derive(Debug, Clone, PartialEq)]
pub enum Inspection {
    /// It lies as planned, within the settings' limits.
    AsPlanned(Lying),
    /// It lies elsewhere or is turned, on the side that was planned to be down.
    Moved(Lying),
    /// It lies on another side, or leans.
    Toppled(Lying),
    /// It is not in the container: nothing new is seen, and it has nowhere to hide.
    Missing(Absence),
    /// What is seen does not tell.
    Unclear(Unclear),
}

/// What was seen in place of an item.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Absence {
    /// The area in which something new is seen, in square metres.
    pub new_m2: f64,
    /// The least area in which the item would be seen, in square metres.
    pub least_m2: f64,
    /// The share of the container that is seen.
    pub seen_share: f64,
}

/// An inspection that does not tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unclear {
    /// Why.
    pub reason: UnclearReason,
    /// The pose that agrees best, where there is one. It is not to be relied on.
    pub best: Option<Lying>,
}

/// Why an inspection does not tell.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnclearReason {
    /// Sizes and poses are finite, the surface has samples, and the camera is above the rim.
    #[error(
        "the container, its surface or a pose is impossible, or the camera is not above the rim"
    )]
    Unusable,
    /// Too little of the container is seen.
    #[error("only {:.0} % of the container is seen", 100.0 * seen_share)]
    LittleSeen {
        /// The share of the container that is seen.
        seen_share: f64,
    },
    /// Little or nothing is new, but the item could lie where that would not be noticed.
    #[error("hardly anything is new in the container, but the item could lie hidden")]
    CouldHide,
    /// Something is new, but in too few points to tell what.
    #[error("something is new, but in {points} points only")]
    FewPoints {
        /// How many.
        points: usize,
    },
    /// Something is new, but the item does not fit it.
    #[error("something is new, but the item does not fit it")]
    DoesNotFit,
    /// The item fits what is new, but too much of it is hidden.
    #[error("the item fits what is new, but only {:.0} % of its view is seen", 100.0 * seen_share)]
    ItemHidden {
        /// The share of its view that is seen.
        seen_share: f64,
    },
    /// The item fits what is new in several ways.
    #[error("the item fits what is new in several ways")]
    Ambiguous,
}

impl Inspection {
    /// How the item lies, where that is known.
    pub fn lying(&self) -> Option<&Lying> {
        match self {
            Self::AsPlanned(lying) | Self::Moved(lying) | Self::Toppled(lying) => Some(lying),
            Self::Missing(_) | Self::Unclear(_) => None,
        }
    }
}
