//! Clouds that inspections are made from, and their outcomes.

use nalgebra::Point3;

use crate::inspection::lying::Lying;

/// The cloud of a depth camera above a container.
#[derive(Debug, Clone, Copy)]
pub struct ContainerCloud<'points> {
    /// Points in the container frame, in metres. Those with a coordinate that is not finite are
    /// left out.
    pub points_m: &'points [Point3<f64>],
    /// The place of the camera in the container frame, in metres.
    pub eye_m: Point3<f64>,
}

/// The outcome of an inspection of an item that was placed.
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
    /// Its pose cannot be told from what is seen.
    Unclear(Unclear),
}

/// Areas seen in place of an item.
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
    /// The reason.
    pub reason: UnclearReason,
    /// The pose that agrees best, where there is one. It is not to be relied on.
    pub best: Option<Lying>,
}

/// A reason why an inspection does not tell.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnclearReason {
    /// Sizes or poses that are not finite, a surface without samples, or a camera that is not above
    /// the rim.
    #[error(
        "the container, its surface or a pose is impossible, or the camera is not above the rim"
    )]
    Unusable,
    /// Too small a share of the container that is seen.
    #[error("only {:.0} % of the container is seen", 100.0 * .0)]
    LittleSeen(f64),
    /// Little or nothing is new, but the item could lie where that would not be noticed.
    #[error("hardly anything is new in the container, but the item could lie hidden")]
    CouldHide,
    /// Something is new, but in too few points, so many, to tell what.
    #[error("something is new, but in {0} points only")]
    FewPoints(usize),
    /// Something is new, but the item does not fit it.
    #[error("something is new, but the item does not fit it")]
    DoesNotFit,
    /// The item fits what is new, but too much of it is hidden: only this share of its view is
    /// seen.
    #[error("the item fits what is new, but only {:.0} % of its view is seen", 100.0 * .0)]
    ItemHidden(f64),
    /// The item fits what is new in several ways.
    #[error("the item fits what is new in several ways")]
    Ambiguous,
}

impl Inspection {
    /// Gives the pose of the item, where that is known.
    pub fn lying(&self) -> Option<&Lying> {
        match self {
            Self::AsPlanned(lying) | Self::Moved(lying) | Self::Toppled(lying) => Some(lying),
            Self::Missing(_) | Self::Unclear(_) => None,
        }
    }
}
