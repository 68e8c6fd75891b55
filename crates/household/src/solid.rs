//! Closed surfaces in millimetres, the unit in which everyday goods are specified.

use nalgebra::{Point3, Rotation3, Vector3};

use ppnpack_catalogue::mesh::{Bounds, Mesh};

/// Rolling a lying body from one edge of its outline to the next ends long before this.
const MAX_ROLLS: usize = 64;

/// Mesh coordinates are whole micrometres, so that flat bottoms are flat to the last bit.
const MICROMETRES_PER_MM: f64 = 1e3;
const MICROMETRES_PER_M: f64 = 1e6;

/// A closed triangle surface in millimetres, z up, triangles counter-clockwise seen from outside.
#[derive(Debug, Clone, Default)]
pub(crate) struct Solid {
    pub(crate) vertices_mm: Vec<Point3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Solid {
    fn map(mut self, place: impl Fn(&Point3<f64>) -> Point3<f64>) -> Self {
        for vertex in &mut self.vertices_mm {
            *vertex = place(vertex);
        }
        self
    }

    /// Raises what was drawn flat: the outline's y becomes height, its height becomes depth.
    pub(crate) fn raised(self) -> Self {
        self.map(|v| Point3::new(v.x, -v.z, v.y))
    }

    /// Lays a standing solid on its side, top towards +x, and lets it roll in the x-z plane until
    /// its centre of mass is above the edge it lies on. Bodies that taper come to lie tilted.
    pub(crate) fn laid_down(self) -> Self {
        let mut lying = self.map(|v| Point3::new(v.z, v.y, -v.x));
        for _ in 0..MAX_ROLLS {
            let Some(slope) = lying.slope_below_centre() else {
                break;
            };
            if slope.abs() < 1e-9 {
                break;
            }
            let level = Rotation3::from_axis_angle(&Vector3::y_axis(), slope);
            lying = lying.map(|v| level * v);
        }
        lying
    }

    /// The inclination, in radians, of the lower hull of the x-z outline below the centre of mass.
    fn slope_below_centre(&self) -> Option<f64> {
        let mut outline: Vec<(f64, f64)> = self.vertices_mm.iter().map(|v| (v.x, v.z)).collect();
        outline.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        // Andrew's monotone chain, lower half.
        let mut hull: Vec<(f64, f64)> = Vec::new();
        for point in outline {
            while let [.., before, last] = hull.as_slice() {
                let turn = (last.0 - before.0) * (point.1 - before.1)
                    - (last.1 - before.1) * (point.0 - before.0);
                if turn > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        let centre_x = self.centre_of_mass_mm()?.x;
        let below = hull
            .iter()
            .zip(hull.iter().skip(1))
            .find(|(_, right)| right.0 >= centre_x)?;
        Some((below.1.1 - below.0.1).atan2(below.1.0 - below.0.0))
    }

    fn centre_of_mass_mm(&self) -> Option<Point3<f64>> {
        let vertex = |index: u32| self.vertices_mm.get(index as usize).map(|v| v.coords);
        let mut volume = 0.0;
        let mut moment = Vector3::zeros();
        for [a, b, c] in &self.triangles {
            let (a, b, c) = (vertex(*a)?, vertex(*b)?, vertex(*c)?);
            let tetrahedron = a.dot(&b.cross(&c)) / 6.0;
            volume += tetrahedron;
            moment += (a + b + c) * (tetrahedron / 4.0);
        }
        (volume > 0.0).then(|| Point3::from(moment / volume))
    }

    /// Flattens the lowest `depth_mm`, as weight does. A ball that touches the ground in one vertex
    /// has no support polygon; pressed by half a millimetre it has one.
    pub(crate) fn pressed(self, depth_mm: f64) -> Self {
        let lowest = self
            .vertices_mm
            .iter()
            .map(|v| v.z)
            .fold(f64::INFINITY, f64::min);
        self.map(|v| Point3::new(v.x, v.y, v.z.max(lowest + depth_mm)))
    }

    /// The solid [laid down](Self::laid_down), and [pressed](Self::pressed) where it lies.
    pub(crate) fn lying(self, depth_mm: f64) -> Self {
        self.laid_down().pressed(depth_mm)
    }

    /// The solid as a mesh in metres, centred in x and y, its lowest point at z = 0.
    pub(crate) fn into_mesh(self) -> Mesh {
        let origin = Bounds::of(&self.vertices_mm).map_or_else(Point3::origin, |bounds| {
            let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
            Point3::new(middle.x, middle.y, bounds.lowest.z)
        });
        let metres = |mm: f64| (mm * MICROMETRES_PER_MM).round() / MICROMETRES_PER_M;
        Mesh {
            vertices: self
                .vertices_mm
                .iter()
                .map(|v| (v - origin.coords).map(metres))
                .collect(),
            triangles: self.triangles,
        }
    }
}
