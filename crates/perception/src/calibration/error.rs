//! Refusals of a calibration.

use ppnpack_numbers::SettingError;

use super::LEAST_POINTS;

/// A cloud in which no container was found, or one that is not trusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// A setting that is not possible.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Too few points with three finite coordinates.
    #[error("the cloud has {0} measured points where {LEAST_POINTS} are needed")]
    FewPoints(usize),
    /// Points nearer or farther than a container can be, by their median distance in metres.
    #[error(
        "points are {0:.3} m from the sensor in the median, where 0.1 to 10 m are possible: is the cloud in \
         millimetres, or not in the sensor's frame?"
    )]
    Distance(f64),
    /// There is no direction along which heights concentrate.
    #[error("the cloud shows no level surface from above")]
    NoLevel,
    /// The sensor looks from the side.
    #[error("the sensor looks at the container {:.0} degrees from above, where {:.0} are possible: tilt it less", angle_rad.to_degrees(), limit_rad.to_degrees())]
    Side {
        /// The angle between the sensor's view and straight down, in radians.
        angle_rad: f64,
        /// The greatest that is possible, in radians.
        limit_rad: f64,
    },
    /// Points that are too far apart, by the distance of neighbouring ones in metres.
    #[error("points are {0:.4} m apart where 0.007 m is too coarse to see a rim")]
    Sparse(f64),
    /// No rim.
    #[error("no raised rim encloses a hole with a floor: the whole rim must be seen, from above")]
    NoRim,
    /// A side of what seems the rim has no level top.
    #[error("the rim is not seen along a side: is the whole rim in view?")]
    RimUnseen,
    /// An area, in square metres, that is higher than the rim.
    #[error(
        "{0:.4} m^2 within the walls are higher than what seems the rim: is the whole rim in view, and nothing above it?"
    )]
    AboveRim(f64),
    /// More than one container.
    #[error(
        "more than one container is seen: leave one in view, or give the size of the one that is meant"
    )]
    Several,
    /// Too small a share of the floor that is seen.
    #[error("too little of a floor is seen within the rim ({:.0} %)", 100.0 * .0)]
    NoFloor(f64),
    /// A side of the hole is not seen.
    #[error(
        "a side of the container is not seen: neither the inner face of its wall nor its rim's inner edge"
    )]
    SideUnseen,
    /// The container is not empty.
    #[error("the container is not empty: {area_m2:.4} m^2 lie {} its floor", if *.is_above { "above" } else { "below what seems" })]
    NotEmpty {
        /// The area that is not floor, in square metres.
        area_m2: f64,
        /// Whether it is above the floor or below.
        is_above: bool,
    },
    /// A wall is not plane.
    #[error("a wall is bent or leans by {bow_m:.4} m where {limit_m} m is possible")]
    Bent {
        /// The wall's distance from plane and upright, in metres.
        bow_m: f64,
        /// The greatest that is possible, in metres.
        limit_m: f64,
    },
    /// A wall's inner face is not below the rim's inner edge.
    #[error(
        "a wall's inner face and its rim's inner edge are {apart_m:.4} m apart where {limit_m:.4} m is possible"
    )]
    Lip {
        /// The distance between them, in metres.
        apart_m: f64,
        /// The greatest that is possible, in metres.
        limit_m: f64,
    },
    /// The sides make no rectangle, or floor and rim are not parallel.
    #[error("{what} are {:.2} degrees off where {:.2} is possible", angle_rad.to_degrees(), limit_rad.to_degrees())]
    Skew {
        /// Sides, or floor and rim.
        what: &'static str,
        /// The angle, in radians.
        angle_rad: f64,
        /// The greatest that is possible, in radians.
        limit_rad: f64,
    },
    /// Points do not lie on a plane.
    #[error(
        "the points of the {what} are {rms_m:.4} m from a plane (root mean square) where {limit_m} m is possible"
    )]
    Rough {
        /// Floor, rim or walls.
        what: &'static str,
        /// The root mean square of their distances, in metres.
        rms_m: f64,
        /// The greatest that is possible, in metres.
        limit_m: f64,
    },
    /// The size is not the known one.
    #[error("the container's {side} side was measured as {measured_m:.4} m, but is {known_m} m")]
    Size {
        /// `x`, `y` or `z`.
        side: &'static str,
        /// The measured length, in metres.
        measured_m: f64,
        /// The given length, in metres.
        known_m: f64,
    },
}
