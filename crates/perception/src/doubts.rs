//! Doubts of a scene. Nothing is to be planned on one that is doubtful.

use std::fmt;

use nalgebra::Point3;
use ppnpack_numbers::{settings, within};
use ppnpack_packing::kernel::grid::ContainerSize;

/// A reason not to plan on a scene.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Doubt {
    /// Too little of the container was seen: the sensor shows another place, unit or frame, or
    /// something is before it.
    #[error(
        "only {seen_cells} of {cells} cells are seen: does the sensor show this container, in metres (say `unit` of its \
         clouds where not) and in the frame that is set?"
    )]
    LittleSeen {
        /// Cells of which something was seen.
        seen_cells: usize,
        /// All cells.
        cells: usize,
    },
    /// A wall's top is not where it should be: the container or the sensor was moved, or something
    /// covers it.
    #[error(
        "the top of the wall at {wall} is not where it should be ({points_at_rim} of {points} points): was the container \
         or the sensor moved, or is the wall covered?"
    )]
    RimAway {
        /// The wall.
        wall: Wall,
        /// Points seen where its top should be.
        points: u64,
        /// Points among them at its height.
        points_at_rim: u64,
    },
    /// Nearly all of the surface lies above the rim: the sensor's pose is not that of this
    /// container.
    #[error(
        "{above_cells} of {seen_cells} cells seen lie above the rim: is the sensor's pose set, in metres and in the \
         container's frame?"
    )]
    AboveRim {
        /// Cells higher than the rim.
        above_cells: usize,
        /// Cells of which something was seen.
        seen_cells: usize,
    },
    /// Something reaches into the container from above, such as a hand or the arm.
    #[error(
        "something reaches into the container from above ({points} points, up to {highest_m:.2} m above the floor)"
    )]
    Intrusion {
        /// Points above the container and higher than its content may stand.
        points: u64,
        /// The highest of them, in metres above the floor.
        highest_m: f64,
    },
    /// The scene was not seen to be still for long enough.
    #[error(
        "the scene is not still: {clouds} of {needed} clouds agree, {moved_cells} cells moved in the last one"
    )]
    NotStill {
        /// Cells in which something came, went or moved since the earlier clouds.
        moved_cells: usize,
        /// Number of the latest clouds that agree.
        clouds: usize,
        /// Number of clouds that have to.
        needed: usize,
    },
}

/// A wall of the container.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// At x = 0.
    LowX,
    /// At the container's full x.
    HighX,
    /// At y = 0.
    LowY,
    /// At the container's full y.
    HighY,
}

impl fmt::Display for Wall {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::LowX => "x = 0",
            Self::HighX => "the far end of x",
            Self::LowY => "y = 0",
            Self::HighY => "the far end of y",
        })
    }
}

settings! {
    /// Limits beyond which a scene is doubtful.
    pub struct DoubtSettings with validate as "doubts." {
        /// At least this share of the cells must be seen, from 0 to 1.
        pub least_seen_share: f64 = 0.7 => within("0 to 1", 0.0..=1.0),
        /// Thickness of the walls, in metres. 0: that is not known, and their tops are looked for
        /// close to the opening, where anything is seen beside it.
        pub wall_thickness_m: f64 = 0.0 => within("0 to 1 m", 0.0..=1.0),
        /// The tops of the walls may be higher or lower by this, in metres.
        pub rim_tolerance_m: f64 = 0.006 => within("0 to 1 m", 0.0..=1.0),
        /// At least this share of the points above a wall must be at its top, from 0 to 1; where
        /// its thickness is not known, this share of its length must have some. With 0 the walls
        /// are not looked at.
        pub least_rim_share: f64 = 0.7 => within("0 to 1", 0.0..=1.0),
        /// At least so many points must be seen above each wall.
        pub least_rim_points: u64 = 50,
        /// Content may stand above the rim by this, in metres: what stands higher reaches in from
        /// above.
        pub reach_above_rim_m: f64 = 0.1 => within("0 to 1 m", 0.0..=1.0),
        /// Something reaches in where at least so many points show it.
        pub least_intruding_points: u64 = 30,
    }
}

/// Looks at points for what they tell of the container beside its content.
#[derive(Debug, Clone)]
pub(crate) struct Watch {
    container: ContainerSize,
    settings: DoubtSettings,
    /// Height above which points reach in.
    ceiling_m: f64,
    intruding: u64,
    highest_m: f64,
    walls: [WallTop; 4],
}

/// Points above a wall.
#[derive(Debug, Clone, Copy, Default)]
struct WallTop {
    points: u64,
    points_at_rim: u64,
    /// A bit for each of [`PARTS`] parts along the wall that has a point at the rim.
    parts_at_rim: u32,
}

/// Number of parts of a wall's length.
const PARTS: u32 = 32;

/// Maximum distance of walls' tops from the opening, in metres, where the thickness of walls is not
/// known.
const BESIDE_M: f64 = 0.015;

const WALLS: [Wall; 4] = [Wall::LowX, Wall::HighX, Wall::LowY, Wall::HighY];

impl Watch {
    pub(crate) fn new(container: ContainerSize, settings: DoubtSettings) -> Self {
        Self {
            container,
            ceiling_m: container.z_m + settings.reach_above_rim_m,
            settings,
            intruding: 0,
            highest_m: 0.0,
            walls: [WallTop::default(); 4],
        }
    }

    /// Forgets all points.
    pub(crate) fn clear(&mut self) {
        *self = Self::new(self.container, self.settings.clone());
    }

    /// Looks at a point, in the container's frame. One with a coordinate that is no number tells
    /// nothing.
    #[inline]
    pub(crate) fn look(&mut self, point: &Point3<f64>) {
        let (beyond_x, x_wall) = beyond(point.x, self.container.x_m);
        let (beyond_y, y_wall) = beyond(point.y, self.container.y_m);
        if beyond_x <= 0.0 && beyond_y <= 0.0 {
            if point.z > self.ceiling_m {
                self.intruding += 1;
                self.highest_m = self.highest_m.max(point.z);
            }
        } else if beyond_y <= 0.0 {
            self.look_at_wall(x_wall, beyond_x, point.y / self.container.y_m, point.z);
        } else if beyond_x <= 0.0 {
            self.look_at_wall(2 + y_wall, beyond_y, point.x / self.container.x_m, point.z);
        }
    }

    fn look_at_wall(&mut self, wall: usize, beyond_m: f64, along: f64, z_m: f64) {
        let thickness_m = self.settings.wall_thickness_m;
        let beside_m = match thickness_m > 0.0 {
            // Half of it, its middle: a point at an edge may lie between what is above and below.
            true => 0.25 * thickness_m..=0.75 * thickness_m,
            false => 0.0..=BESIDE_M,
        };
        let is_at_rim = (z_m - self.container.z_m).abs() <= self.settings.rim_tolerance_m;
        if beside_m.contains(&beyond_m)
            && let Some(top) = self.walls.get_mut(wall)
        {
            top.points += 1;
            top.points_at_rim += u64::from(is_at_rim);
            let part = ((along * f64::from(PARTS)) as u32).min(PARTS - 1);
            top.parts_at_rim |= u32::from(is_at_rim) << part;
        }
    }

    /// Gives the doubts that the points raise.
    pub(crate) fn doubts(&self) -> impl Iterator<Item = Doubt> {
        let settings = &self.settings;
        let walls = WALLS.into_iter().zip(self.walls);
        let away = walls.filter(|(_, top)| {
            let is_seen = top.points >= settings.least_rim_points;
            if settings.wall_thickness_m > 0.0 {
                let least = settings.least_rim_share * top.points as f64;
                return !is_seen || (top.points_at_rim as f64) < least;
            }
            // Clouds may hold the inside alone.
            let least = settings.least_rim_share * f64::from(PARTS);
            is_seen && f64::from(top.parts_at_rim.count_ones()) < least
        });
        let away = away.map(|(wall, top)| Doubt::RimAway {
            wall,
            points: top.points,
            points_at_rim: top.points_at_rim,
        });
        let reaches_in = self.intruding > 0 && self.intruding >= settings.least_intruding_points;
        let intrusion = reaches_in.then_some(Doubt::Intrusion {
            points: self.intruding,
            highest_m: self.highest_m,
        });
        away.chain(intrusion)
    }
}

/// Gives the distance of a coordinate beyond the nearer of two walls, negative between them, and
/// the wall: 0 for the one at 0.
fn beyond(coordinate_m: f64, length_m: f64) -> (f64, usize) {
    if coordinate_m < 0.5 * length_m {
        (-coordinate_m, 0)
    } else {
        (coordinate_m - length_m, 1)
    }
}
