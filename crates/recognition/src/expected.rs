//! Views that the camera should have of an object in a pose, compared with what it sees.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_camera::{DepthBuffer, Intrinsics};
use ppnpack_catalogue::mesh::Mesh;

use crate::moments::centroid;
use crate::object::LibraryObject;
use crate::segmentation::Cluster;

/// Maximum number of pixels along a side of the window.
const MAX_SIDE: f64 = 512.0;

/// Minimum distance from the camera of what is drawn, in metres.
const NEAR_M: f64 = 0.02;

/// Minimum distance at which a point is not explained at all, in metres.
const UNEXPLAINED_M: f64 = 0.004;

/// Cosine of the steepest angle at which a facet counts: seen from the side it says nothing.
const STEEPEST_COSINE: f64 = 0.1;

/// A cluster as the camera sees it, at some resolution: expected views are compared with it.
pub(crate) struct Observation {
    intrinsics: Intrinsics,
    camera_from_support: Isometry3<f64>,
    seen: Vec<Seen>,
    /// Number of points that are the cluster's own.
    own: usize,
    /// Number of points, those included that are not compared.
    measured: usize,
    /// Memory for drawing expected views.
    buffer: DepthBuffer,
}

/// A point that was measured.
struct Seen {
    /// In the camera frame, in metres.
    point: Point3<f64>,
    column: usize,
    row: usize,
    /// The distance from the support, in metres.
    from_support_m: f64,
    is_own: bool,
}

/// Agreement of an expected view with what is seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Agreement {
    /// 1 where every point is where it should be, 0 where none is.
    pub fitness: f64,
    /// The share of the cluster's points that nothing explains.
    pub unexplained: f64,
    /// The share of the object's expected view that the camera looks through.
    pub contradicted: f64,
}

/// Gives the fitness that the noise of a sensor costs a perfect pose.
pub(crate) fn expected_loss(sensor_deviation_m: f64) -> f64 {
    (sensor_deviation_m / UNEXPLAINED_M).powi(2)
}

impl Observation {
    /// Makes a window on the cluster whose pixels are `pixel_m` wide at the support; at most `most`
    /// points of the cluster are compared. `None` where the cluster is not before the camera.
    pub(crate) fn new(cluster: &Cluster, pixel_m: f64, most: usize) -> Option<Self> {
        let middle = centroid(&cluster.points_m)?;
        let forward = (middle - cluster.eye_m).try_normalize(1e-6)?;
        let across = |axis: Vector3<f64>| forward.cross(&axis).try_normalize(1e-3);
        let right = across(Vector3::y()).or_else(|| across(Vector3::x()))?;
        let axes = Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
        let support_from_camera = Isometry3::from_parts(
            Translation3::from(cluster.eye_m.coords),
            UnitQuaternion::from_rotation_matrix(&axes),
        );
        let camera_from_support = support_from_camera.inverse();
        let focal = nalgebra::distance(&middle, &cluster.eye_m) / pixel_m;
        let stride = cluster.points_m.len().div_ceil(most.max(1)).max(1);
        let mut projected = Vec::new();
        let (mut lowest, mut highest) = (Vector2::repeat(f64::MAX), Vector2::repeat(f64::MIN));
        for (points_m, is_own) in [(&cluster.points_m, true), (&cluster.surroundings_m, false)] {
            for point in points_m.iter().step_by(stride) {
                let in_camera = camera_from_support * point;
                if in_camera.z < NEAR_M {
                    continue;
                }
                let place = in_camera.xy().coords * focal / in_camera.z;
                (lowest, highest) = (lowest.inf(&place), highest.sup(&place));
                projected.push((in_camera, place, point.z.abs(), is_own));
            }
        }
        let side = |low: f64, high: f64| (high - low + 3.0).clamp(3.0, MAX_SIDE) as usize;
        let (width, height) = (side(lowest.x, highest.x), side(lowest.y, highest.y));
        let (cx, cy) = (1.0 - lowest.x.round(), 1.0 - lowest.y.round());
        let seen = projected.into_iter();
        let seen = seen.map(|(point, place, from_support_m, is_own)| Seen {
            point,
            // Casts saturate; points beyond the window's limit are compared with nothing.
            column: (place.x + cx).round() as usize,
            row: (place.y + cy).round() as usize,
            from_support_m,
            is_own,
        });
        let seen = seen.filter(|seen| seen.column < width && seen.row < height);
        let seen: Vec<Seen> = seen.collect();
        let own = seen.iter().filter(|seen| seen.is_own).count();
        (own > 0).then_some(Self {
            intrinsics: Intrinsics {
                width,
                height,
                fx: focal,
                fy: focal,
                cx,
                cy,
            },
            camera_from_support,
            seen,
            own,
            measured: cluster.points_m.len() + cluster.surroundings_m.len(),
            buffer: DepthBuffer::default(),
        })
    }

    /// Compares with what should be seen of a mesh in a pose.
    ///
    /// A point of the cluster agrees as far as it is near the surface that should be seen at its
    /// pixel or the four around it, or near the support where that should be seen. A point of the
    /// surroundings counts only where the object should be seen: if it lies farther, the camera
    /// looks through the object.
    pub(crate) fn compare(
        &mut self,
        object: &LibraryObject,
        support_from_item: &Isometry3<f64>,
    ) -> Agreement {
        let mesh = &object.model.mesh;
        let camera_from_item = self.drawn(mesh, support_from_item);
        let item_from_camera = camera_from_item.inverse();
        let mut cost = 0.0;
        let (mut compared, mut unexplained, mut contradicted, mut expected) = (0, 0, 0, 0);
        for seen in &self.seen {
            let view = self.expected_at(seen, mesh, &camera_from_item);
            if !seen.is_own {
                // Only what the camera sees where the object should be speaks against it.
                if !view.is_object_everywhere || view.is_behind_seen {
                    continue;
                }
                expected += 1;
            }
            compared += 1;
            let mut distance_m = view.distance_m;
            if seen.is_own && distance_m > 0.5 * UNEXPLAINED_M {
                // One pixel shows much of a steep face: there the nearest surface tells, if it
                // faces the camera.
                distance_m = distance_m.min(facing_distance_m(object, seen, &item_from_camera));
            }
            let share = (distance_m / UNEXPLAINED_M).min(1.0);
            cost += share * share;
            if share >= 1.0 {
                unexplained += i32::from(seen.is_own);
                contradicted += i32::from(!seen.is_own);
            }
        }
        let share = |part: i32, whole: i32| f64::from(part) / f64::from(whole.max(1));
        let own = self.own as i32;
        Agreement {
            fitness: 1.0 - cost / f64::from(compared.max(1)),
            unexplained: share(unexplained, own),
            contradicted: share(contradicted, own + expected),
        }
    }

    /// Draws a mesh in a pose; gives that pose in the camera frame.
    fn drawn(&mut self, mesh: &Mesh, support_from_item: &Isometry3<f64>) -> Isometry3<f64> {
        let camera_from_item = self.camera_from_support * support_from_item;
        let Mesh {
            vertices,
            triangles,
        } = mesh;
        let (buffer, intrinsics) = (&mut self.buffer, &self.intrinsics);
        buffer.clear(intrinsics);
        buffer.draw(intrinsics, NEAR_M, &camera_from_item, vertices, triangles);
        camera_from_item
    }

    /// Gives the cost of a pose, with no tolerance for points beside their pixel: least where
    /// outlines fit, too.
    pub(crate) fn strict_cost(
        &mut self,
        object: &LibraryObject,
        support_from_item: &Isometry3<f64>,
    ) -> f64 {
        let mesh = &object.model.mesh;
        let camera_from_item = self.drawn(mesh, support_from_item);
        let mut cost = 0.0;
        for seen in &self.seen {
            let distance_m = match self.shown(seen.column, seen.row) {
                None if seen.is_own => seen.from_support_m,
                None => continue,
                Some((facet, surface)) => {
                    if !seen.is_own && seen.point.z < surface.z - UNEXPLAINED_M {
                        continue;
                    }
                    plane_distance_m(seen, &surface, mesh, facet, &camera_from_item)
                }
            };
            let share = (distance_m / UNEXPLAINED_M).min(1.0);
            cost += share * share;
        }
        cost
    }

    /// Gives the share of what should be seen of an object in a pose that is seen, about: neither
    /// unmeasured nor hidden.
    pub(crate) fn seen_share(
        &mut self,
        object: &LibraryObject,
        support_from_item: &Isometry3<f64>,
    ) -> f64 {
        self.drawn(&object.model.mesh, support_from_item);
        let nearness = self.buffer.nearness_per_m().iter();
        let pixels = nearness.filter(|nearness| **nearness > 0.0).count();
        // The points that are compared at such pixels and that nothing is before.
        let is_free = |seen: &&Seen| {
            let pixel = seen.row * self.intrinsics.width + seen.column;
            let depth_m = self.buffer.depth_m(pixel);
            depth_m.is_some_and(|depth_m| seen.point.z > f64::from(depth_m) - UNEXPLAINED_M)
        };
        let free = self.seen.iter().filter(is_free).count();
        let per_compared = (self.measured as f64 / (self.points() as f64).max(1.0)).max(1.0);
        (free as f64 * per_compared / pixels.max(1) as f64).min(1.0)
    }

    /// Counts the points that are compared.
    pub(crate) fn points(&self) -> usize {
        self.seen.len()
    }

    /// Gives the facet that a pixel should show, and its point there in the camera frame, in
    /// metres.
    #[inline]
    fn shown(&self, column: usize, row: usize) -> Option<(u32, Point3<f64>)> {
        let pixel = row * self.intrinsics.width + column;
        let facet = self.buffer.facet(pixel)?;
        let depth_m = self.buffer.depth_m(pixel)?;
        let ray = self.intrinsics.ray(column as f64, row as f64);
        Some((facet, Point3::from(ray * f64::from(depth_m))))
    }

    /// Looks at the expected view around the pixel of a point.
    fn expected_at(&self, seen: &Seen, mesh: &Mesh, camera_from_item: &Isometry3<f64>) -> Expected {
        let mut expected = Expected {
            distance_m: f64::INFINITY,
            is_object_everywhere: true,
            is_behind_seen: false,
        };
        for (du, dv) in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)] {
            // What lies before the first pixel wraps, and is beyond the last.
            let u = seen.column.wrapping_add_signed(du);
            let v = seen.row.wrapping_add_signed(dv);
            let is_inside = u < self.intrinsics.width && v < self.intrinsics.height;
            let shown = is_inside.then(|| self.shown(u, v)).flatten();
            let Some((facet, surface)) = shown else {
                expected.is_object_everywhere = false;
                expected.distance_m = expected.distance_m.min(seen.from_support_m);
                continue;
            };
            if seen.point.z < surface.z - UNEXPLAINED_M {
                expected.is_behind_seen = true;
            }
            let distance_m = plane_distance_m(seen, &surface, mesh, facet, camera_from_item);
            expected.distance_m = expected.distance_m.min(distance_m);
            // A point that agrees where it is need not be compared with its neighbours.
            if (du, dv) == (0, 0) && distance_m < 0.5 * UNEXPLAINED_M && seen.is_own {
                break;
            }
        }
        expected
    }
}

/// Gives the distance of a point from the nearest surface; infinite where that faces away from the
/// camera.
fn facing_distance_m(
    object: &LibraryObject,
    seen: &Seen,
    item_from_camera: &Isometry3<f64>,
) -> f64 {
    let point = item_from_camera * seen.point;
    let nearest = object.nearest.nearest(&point);
    let to_camera = item_from_camera.translation.vector - point.coords;
    let is_facing = nearest.normal.dot(&to_camera) > 0.0;
    if is_facing {
        nearest.distance_m
    } else {
        f64::INFINITY
    }
}

/// The expected view at a point's pixel and around it.
struct Expected {
    /// The distance of the point from it, in metres.
    distance_m: f64,
    /// Whether the object should be seen at all of these pixels.
    is_object_everywhere: bool,
    /// Whether what is seen lies before it: something else is in the way.
    is_behind_seen: bool,
}

/// Gives the distance of a point from the plane of the facet seen at a pixel; the plain one where
/// that is seen from the side.
fn plane_distance_m(
    seen: &Seen,
    surface: &Point3<f64>,
    mesh: &Mesh,
    facet: u32,
    camera_from_item: &Isometry3<f64>,
) -> f64 {
    let offset = seen.point - surface;
    let corner = |index: u32| mesh.vertices.get(index as usize).copied();
    let triangle = mesh.triangles.get(facet as usize);
    let normal = triangle.and_then(|triangle| {
        let [a, b, c] = triangle.map(|index| corner(index).unwrap_or_default());
        (b - a).cross(&(c - a)).try_normalize(0.0)
    });
    let normal = normal.map(|normal| camera_from_item.rotation * normal);
    let is_steep = |normal: &Vector3<f64>| {
        normal.dot(&surface.coords).abs() / surface.coords.norm() < STEEPEST_COSINE
    };
    let normal = normal.filter(|normal| !is_steep(normal));
    normal.map_or_else(|| offset.norm(), |normal| offset.dot(&normal).abs())
}
