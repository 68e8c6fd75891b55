//! A container's inside from a mesh of it: the largest box or tote that stands nowhere in a wall.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Vector3};
use parry3d::math::Vector;
use parry3d::query::{Ray, RayCast};
use parry3d::shape::TriMesh;
use ppnpack_packing::kernel::grid::ContainerSize;

use crate::mesh::{Bounds, Mesh};

/// Directions in which walls are looked for at a height.
const DIRECTIONS: u32 = 180;

/// Heights at which the inside is checked.
const LEVELS: u32 = 9;

/// Places along either side of the mesh that are looked at from above.
const SAMPLES: u32 = 81;

/// Number of places on either side of a wall's middle where it is looked at.
const LOOKS: i32 = 8;

/// Distance of the outermost of them, as a share of that to the next wall: round corners begin
/// there.
const BESIDE: f64 = 0.4;

/// Distance of the heights at which leaning walls are measured from floor and rim, as a share of
/// the depth.
const END_SHARE: f64 = 0.15;

/// Minimum depth of an inside, in metres.
const LEAST_DEPTH_M: f64 = 0.01;

/// Number of heights among which the rim is looked for, and how often what is between two is halved
/// then.
const RIM_STEPS: u32 = 500;
const HALVINGS: u32 = 16;

/// Number of places to either side of the middle where the floor is looked at, and how many of all
/// have to have one.
const FLOOR_LOOKS: i32 = 4;
const LEAST_FLOOR: usize = 60;

/// Maximum height of what belongs to the floor, such as ribs, in metres.
const FLOOR_RIBS_M: f64 = 0.005;

/// Maximum that something may stand in the inside, in metres.
const TOLERANCE_M: f64 = 0.0015;

/// Minimum slope of a wall that leans.
const LEAST_SLOPE: f64 = 0.004;

/// Maximum slope of a wall: what leans further stands before it.
const MOST_SLOPE: f64 = 0.3;

/// Minimum share of a mesh's inside that a box or tote has to use.
const LEAST_USED: f64 = 0.9;

/// Why a mesh is no container.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoContainer {
    /// Nothing is enclosed below a rim.
    #[error(
        "it has no inside that is open at the top and at least 1 cm deep: z has to be up, and the \
         unit the file's"
    )]
    NoInside,
    /// A wall leans inwards.
    #[error("a wall leans inwards by {0:.1} degrees: items cannot be let down beside it")]
    LeansInwards(f64),
    /// The numbers that were found are impossible.
    #[error("{0}")]
    Shape(String),
    /// Something stands between the walls.
    #[error(
        "something stands {:.0} mm into its inside, {:.1} cm above the floor: leave it out of the \
         mesh and tell it by `taken`",
        1e3 * .by_m,
        1e2 * .height_m
    )]
    Within {
        /// How far it is from the nearest wall, or from the floor, in metres.
        by_m: f64,
        /// Its height above the floor, in metres.
        height_m: f64,
    },
    /// Much of the inside is beside every box and tote.
    #[error(
        "{0:.0} % of what is open at its top is beside the largest box or tote in it: its sides \
         have to be along x and y, and a divider is told by `taken` in place of the mesh"
    )]
    Beside(f64),
}

/// Finds the container's size, the common lean of its walls and the radius of its vertical edges:
/// in whole millimetres and tenths of a degree, so that all of it is inside. The mesh has z up.
///
/// # Errors
/// [`NoContainer`] where the inside is no box or tote along x and y.
pub fn inside(mesh: &Mesh) -> Result<ContainerSize, NoContainer> {
    let cavity = Cavity::of(mesh).ok_or(NoContainer::NoInside)?;
    let found = cavity.measure()?;
    let shape = found.size.validate_shape();
    shape.map_err(|error| NoContainer::Shape(error.to_string()))?;
    cavity.check(&found)?;
    Ok(found.size)
}

/// What is enclosed below the rim.
struct Cavity {
    shape: TriMesh,
    bounds: Bounds,
    floor_m: f64,
    rim_m: f64,
}

/// A container in the frame of the mesh.
struct Found {
    size: ContainerSize,
    /// Its corner on the floor.
    corner: Point3<f64>,
}

/// A wall at two heights: each with the distance of the wall from the middle of the mesh, in
/// metres.
#[derive(Clone, Copy)]
struct Wall {
    low: [f64; 2],
    high: [f64; 2],
}

impl Wall {
    /// Gives how far it leans outwards for its height.
    fn slope(&self) -> f64 {
        let ([low_m, at_low_m], [high_m, at_high_m]) = (self.low, self.high);
        (at_high_m - at_low_m) / (high_m - low_m)
    }

    /// Gives the distance at the rim of a wall that leans so far and stands nowhere in this one.
    fn at_rim_m(&self, rim_m: f64, draft_rad: f64) -> f64 {
        let from = |[height_m, at_m]: [f64; 2]| at_m + draft_rad.tan() * (rim_m - height_m);
        from(self.low).min(from(self.high))
    }
}

impl Cavity {
    /// Looks for floor and rim, with the middle of the mesh at the origin.
    fn of(mesh: &Mesh) -> Option<Self> {
        let is_finite = |corner: &Point3<f64>| corner.coords.sum().is_finite();
        let triangles = mesh
            .corners()
            .filter(|corners| corners.iter().all(is_finite));
        let corners: Vec<Point3<f64>> = triangles.flatten().collect();
        let bounds = Bounds::of(&corners)?;
        let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
        let vertices = corners.iter().map(|corner| vector(&(corner - middle)));
        let numbers =
            (0..corners.len() as u32 / 3).map(|number| [0, 1, 2].map(|at| 3 * number + at));
        let shape = TriMesh::new(vertices.collect(), numbers.collect()).ok()?;
        let highest = Point3::from(bounds.highest - middle);
        let mut cavity = Self {
            shape,
            bounds: Bounds {
                lowest: Point3::from(bounds.lowest - middle),
                highest,
            },
            floor_m: highest.z,
            rim_m: highest.z,
        };
        cavity.floor_m = cavity.floor_m()?;
        let step_m = (highest.z - cavity.floor_m) / f64::from(RIM_STEPS);
        let mut heights = (1..=RIM_STEPS).map(|step| highest.z - f64::from(step) * step_m);
        let below = heights.find(|z_m| cavity.is_enclosed(*z_m))?;
        let (mut below, mut above) = (below, below + step_m);
        for _ in 0..HALVINGS {
            let between = 0.5 * (below + above);
            match cavity.is_enclosed(between) {
                true => below = between,
                false => above = between,
            }
        }
        cavity.rim_m = below;
        (cavity.depth_m() >= LEAST_DEPTH_M).then_some(cavity)
    }

    /// Gives the height of what belongs to the floor.
    fn floor_m(&self) -> Option<f64> {
        let step_m = self.bounds.extents_m() * 0.25 / f64::from(FLOOR_LOOKS);
        let along = || (-FLOOR_LOOKS..=FLOOR_LOOKS).map(f64::from);
        let places = along().flat_map(|x| along().map(move |y| [x, y]));
        // A ray may slip through between two triangles.
        let tops = places.filter_map(|[x, y]| self.top_m(x * step_m.x, y * step_m.y));
        let mut tops: Vec<f64> = tops.collect();
        if tops.len() < LEAST_FLOOR {
            return None;
        }
        tops.sort_by(f64::total_cmp);
        let median_m = *tops.get(tops.len() / 2)?;
        tops.into_iter()
            .rfind(|top_m| *top_m <= median_m + FLOOR_RIBS_M)
    }

    fn depth_m(&self) -> f64 {
        self.rim_m - self.floor_m
    }

    /// Gives the height of what is seen at a place from above.
    fn top_m(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let above = Point3::new(x_m, y_m, self.bounds.highest.z + 1.0);
        Some(above.z - self.distance_m(&above, Vector3::new(0.0, 0.0, -1.0))?)
    }

    /// Says whether there is a wall in all directions at a height.
    fn is_enclosed(&self, z_m: f64) -> bool {
        directions().all(|angle_rad| {
            // A ray may slip through between two triangles.
            let mut looks = [angle_rad, angle_rad + 1e-3].into_iter();
            looks.any(|angle_rad| {
                self.wall_m(&Point3::new(0.0, 0.0, z_m), angle_rad)
                    .is_some()
            })
        })
    }

    fn wall_m(&self, from: &Point3<f64>, angle_rad: f64) -> Option<f64> {
        self.distance_m(from, Vector3::new(angle_rad.cos(), angle_rad.sin(), 0.0))
    }

    fn distance_m(&self, from: &Point3<f64>, towards: Vector3<f64>) -> Option<f64> {
        let ray = Ray::new(vector(&from.coords), vector(&towards));
        let found = self.shape.cast_local_ray(&ray, f32::MAX, false);
        found.map(f64::from)
    }

    /// Measures the nearest that a wall comes to the axis at a height: towards x, y, -x or -y.
    fn nearest_wall_m(&self, side: u8, z_m: f64) -> Option<f64> {
        let angle_rad = f64::from(side) * 0.5 * PI;
        let (sin, cos) = angle_rad.sin_cos();
        let axis = Point3::new(0.0, 0.0, z_m);
        let beside = Vector3::new(-sin, cos, 0.0);
        let looks = (-LOOKS..=LOOKS).filter_map(|look| {
            let share = f64::from(look) / f64::from(LOOKS) * BESIDE;
            let room_m = self.wall_m(&axis, angle_rad + 0.5 * PI * share.signum())?;
            self.wall_m(&(axis + beside * share * room_m), angle_rad)
        });
        looks.min_by(f64::total_cmp)
    }

    /// Measures a wall well above the floor and well below the rim; `None` where there is none.
    fn wall(&self, side: u8) -> Option<Wall> {
        let end_m = END_SHARE * self.depth_m();
        let [low_m, high_m] = [self.floor_m + end_m, self.rim_m - end_m];
        let at = |height_m| Some([height_m, self.nearest_wall_m(side, height_m)?]);
        Some(Wall {
            low: at(low_m)?,
            high: at(high_m)?,
        })
    }

    /// Gives the lean that all walls have at least room for, in radians.
    fn draft_rad(&self, walls: &[Wall; 4]) -> Result<f64, NoContainer> {
        let mut most = 0.0_f64;
        for wall in walls {
            let slope = wall.slope();
            if slope > MOST_SLOPE {
                return Err(NoContainer::Within {
                    by_m: wall.high[1] - wall.low[1],
                    height_m: wall.low[0] - self.floor_m,
                });
            }
            if slope < -LEAST_SLOPE {
                return Err(NoContainer::LeansInwards(-slope.atan().to_degrees()));
            }
            most = most.max(slope);
        }
        let leans = most >= LEAST_SLOPE;
        let draft = rounded_up(most.atan().to_degrees(), 0.1).to_radians();
        Ok(if leans { draft } else { 0.0 })
    }

    /// Takes the largest box or tote between the walls.
    fn measure(&self) -> Result<Found, NoContainer> {
        let walls = [0, 1, 2, 3].map(|side| self.wall(side));
        let [Some(right), Some(back), Some(left), Some(front)] = walls else {
            return Err(NoContainer::NoInside);
        };
        let walls = [right, back, left, front];
        let draft_rad = self.draft_rad(&walls)?;
        let [right, back, left, front] = walls.map(|wall| wall.at_rim_m(self.rim_m, draft_rad));
        let [x_m, y_m, z_m] = [right + left, back + front, self.depth_m()].map(rounded_down_mm);
        let corner = Point3::new(
            0.5 * (right - left - x_m),
            0.5 * (back - front - y_m),
            self.floor_m,
        );
        let mut size = ContainerSize::cuboid(x_m, y_m, z_m);
        size.draft_rad = draft_rad;
        let mut found = Found { size, corner };
        let heights_m = [walls[0].low[0], walls[0].high[0]];
        let radii_m = heights_m.map(|height_m| self.corner_radius_m(&found, height_m));
        let most_m = rounded_down_mm(0.5 * x_m.min(y_m) - size.setback_m(0.0));
        found.size.corner_radius_m = rounded_up(radii_m[0].max(radii_m[1]), 0.001).min(most_m);
        Ok(found)
    }

    /// Gives the largest radius of the vertical edges at a height: that of the arc which a ray to
    /// the corner meets where it meets the wall.
    fn corner_radius_m(&self, Found { size, corner }: &Found, z_m: f64) -> f64 {
        let middle = corner + Vector3::new(0.5 * size.x_m, 0.5 * size.y_m, z_m - corner.z);
        let setback_m = size.setback_m(z_m - self.floor_m);
        let [a, b] = [size.x_m, size.y_m].map(|side_m| 0.5 * side_m - setback_m);
        let corners = [(a, b), (-a, b), (-a, -b), (a, -b)];
        let radii = corners.map(|(x, y)| {
            let to_corner_m = a.hypot(b);
            let to_wall_m = self.wall_m(&middle, y.atan2(x)).unwrap_or(to_corner_m);
            let left = (1.0 - to_wall_m / to_corner_m).max(0.0);
            left * (a + b + (2.0 * a * b).sqrt())
        });
        radii.into_iter().fold(0.0, f64::max)
    }

    /// Checks that little of the inside is beside what was found, and nothing of the mesh within.
    fn check(&self, found: &Found) -> Result<(), NoContainer> {
        let sides_m = self.bounds.extents_m() / f64::from(SAMPLES);
        let along = |number: u32, side_m: f64| {
            (f64::from(number) + 0.5 - 0.5 * f64::from(SAMPLES)) * side_m
        };
        let samples = (0..SAMPLES * SAMPLES).filter_map(|sample| {
            let (x, y) = (sample / SAMPLES, sample % SAMPLES);
            let (x_m, y_m) = (along(x, sides_m.x), along(y, sides_m.y));
            Some(Point3::new(x_m, y_m, self.top_m(x_m, y_m)?))
        });
        let tops: Vec<Point3<f64>> = samples.collect();
        let depths_m = tops.iter().map(|top| (self.rim_m - top.z).max(0.0));
        let open_m3 = depths_m.sum::<f64>() * sides_m.x * sides_m.y;
        let used = found.size.volume_m3() / open_m3;
        if used < LEAST_USED {
            return Err(NoContainer::Beside(100.0 * (1.0 - used)));
        }
        let walls = self.walls_seen_from(found);
        let within = walls.map(|point| (found.within_m(&point), point));
        let tops = tops.iter().map(|top| {
            let height_m = top.z - self.floor_m;
            (height_m.min(found.within_m(top)), *top)
        });
        let mut within = within.chain(tops);
        match within.find(|(by_m, _)| *by_m > TOLERANCE_M) {
            Some((by_m, point)) => {
                let height_m = point.z - self.floor_m;
                Err(NoContainer::Within { by_m, height_m })
            }
            None => Ok(()),
        }
    }

    /// Gives the points of walls that are seen from the middle, at some heights. Where a wall has a
    /// hole, what is above and below it counts.
    fn walls_seen_from(&self, Found { size, corner }: &Found) -> impl Iterator<Item = Point3<f64>> {
        let middle = corner + Vector3::new(0.5 * size.x_m, 0.5 * size.y_m, 0.0);
        let step_m = size.z_m / f64::from(LEVELS);
        (0..LEVELS).flat_map(move |level| {
            let from = middle + Vector3::new(0.0, 0.0, step_m * (f64::from(level) + 0.5));
            directions().filter_map(move |angle_rad| {
                let towards = Vector3::new(angle_rad.cos(), angle_rad.sin(), 0.0);
                Some(from + towards * self.wall_m(&from, angle_rad)?)
            })
        })
    }
}

impl Found {
    /// Measures how far a point is from the nearest wall, on its inner side.
    fn within_m(&self, point: &Point3<f64>) -> f64 {
        -self.size.beyond_walls_m(&Point3::from(point - self.corner))
    }
}

/// The directions in which walls are looked for, in radians; none is along an axis.
fn directions() -> impl Iterator<Item = f64> {
    (0..DIRECTIONS).map(|number| (f64::from(number) + 0.37) * TAU / f64::from(DIRECTIONS))
}

fn vector(from: &Vector3<f64>) -> Vector {
    Vector::new(from.x as f32, from.y as f32, from.z as f32)
}

/// Rounds down to whole millimetres, but for what a mesh's numbers are rounded by.
fn rounded_down_mm(length_m: f64) -> f64 {
    (1e3 * length_m + 0.1).floor() / 1e3
}

/// Rounds up to a whole number of steps, but for what a mesh's numbers are rounded by.
fn rounded_up(value: f64, step: f64) -> f64 {
    let per_one = (1.0 / step).round();
    (value * per_one - 0.2).ceil().max(0.0) / per_one
}
