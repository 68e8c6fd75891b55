//! A field's surface as triangles, by surface nets.
//!
//! Space is cut into cubic cells. Where the surface crosses a cell's edges, the cell gets one
//! vertex for each separate piece of surface in it, the mean of the piece's crossings; around every
//! lattice edge with a change of sign, the four cells' vertices make a quad. This is the dual of
//! marching cubes (Nielson, "Dual marching cubes", 2004): sheets that pass through one cell, as at
//! a thin wall or an acute notch, are not pinched together as in nets with one vertex per cell,
//! such as those of the crate `fast-surface-nets`. The
//! net is closed by construction, and a manifold but where two pieces of surface meet twice across
//! one cell face; no object of the set is sampled so coarsely, and its tests would show it.
#![allow(
    clippy::indexing_slicing,
    reason = "lattice indices stay below `Lattice::points`; a cell's axes, corners and edges are \
              below 3, 8 and 12"
)]

use nalgebra::{Point3, Vector3};

use super::field::Field;
use super::simplify::simplify;
use super::solid::Solid;

/// Lattice points, per axis, of the blocks that are skipped whole where the surface is far.
const BLOCK: usize = 8;

/// The layer of cells that contains the ground.
const GROUND_LAYER: usize = 1;

/// A cell's edges: edge `4 axis + i + 2 j` runs along the axis, `i` cells out along the next axis
/// and `j` along the one after.
const EDGES: usize = 12;

/// A cell's corners, as steps from its lowest.
const CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [1, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
    [1, 1, 1],
];

/// Marks a cell that the surface does not cross.
const UNCROSSED: u32 = u32::MAX;

impl Field {
    /// The part of the field above the ground as a solid, sampled in cells of the given size, in
    /// millimetres, and simplified.
    ///
    /// The ground z = 0 lies in the middle of a layer of cells, whose vertices are put on it
    /// exactly: what stands on the ground has a flat underside with a sharp rim.
    pub(crate) fn carved(&self, cell_mm: f64) -> Solid {
        simplify(surface_nets(self, cell_mm))
    }
}

/// Sampled distances on a lattice; x varies fastest.
struct Lattice {
    origin: Point3<f64>,
    cell_mm: f64,
    points: [usize; 3],
    distances: Vec<f64>,
}

impl Lattice {
    fn sample(field: &Field, cell_mm: f64) -> Self {
        let (lowest, highest) = field.bounds_mm();
        // One and a half cells of margin, so that no surface reaches the lattice's border.
        let margin = 1.5 * cell_mm;
        let origin = Point3::new(lowest.x - margin, lowest.y - margin, -margin);
        let reach = highest + Vector3::repeat(margin) - origin;
        let points = [reach.x, reach.y, reach.z]
            .map(|length| (length / cell_mm).ceil().max(1.0) as usize + 1);
        let count = points.iter().product();
        let mut lattice = Self {
            origin,
            cell_mm,
            points,
            distances: vec![cell_mm; count],
        };
        for block in between([0; 3], points.map(|count| count.div_ceil(BLOCK))) {
            lattice.sample_block(field, block.map(|number| number * BLOCK));
        }
        lattice
    }

    /// Samples a block of points. One further from the surface than its own size, and a cell more,
    /// is filled with the centre's value: only its sign will be looked at.
    fn sample_block(&mut self, field: &Field, start: [usize; 3]) {
        let above_ground = |p: &Point3<f64>| field.distance_mm(p).max(-p.z);
        let middle = Vector3::from(start.map(|first| first as f64 + (BLOCK - 1) as f64 / 2.0));
        let centre = above_ground(&(self.origin + middle * self.cell_mm));
        let radius = self.cell_mm * ((BLOCK - 1) as f64 / 2.0 * 3.0_f64.sqrt() + 1.0);
        let end = [0, 1, 2].map(|axis| (start[axis] + BLOCK).min(self.points[axis]));
        for at in between(start, end) {
            let index = self.index(at);
            self.distances[index] = if centre.abs() > radius {
                centre
            } else {
                above_ground(&self.position(at))
            };
        }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.points[1] + y) * self.points[0] + x
    }

    fn position(&self, at: [usize; 3]) -> Point3<f64> {
        self.origin + Vector3::from(at.map(|step| step as f64)) * self.cell_mm
    }

    fn is_inside(&self, at: [usize; 3]) -> bool {
        self.distances[self.index(at)] < 0.0
    }

    /// Where the surface crosses each edge of the cell above and beyond a lattice point; `None` if
    /// it crosses none.
    fn crossings(&self, cell: [usize; 3]) -> Option<[Option<Vector3<f64>>; EDGES]> {
        let is_inside = self.is_inside(cell);
        let is_corner_inside = |corner| self.is_inside(beyond(cell, corner));
        if CORNERS
            .into_iter()
            .all(|corner| is_corner_inside(corner) == is_inside)
        {
            return None;
        }
        let mut found = [None; EDGES];
        for (edge, crossing) in found.iter_mut().enumerate() {
            let axis = edge / 4;
            let mut from = cell;
            from[(axis + 1) % 3] += edge % 2;
            from[(axis + 2) % 3] += edge / 2 % 2;
            let mut to = from;
            to[axis] += 1;
            let [a, b] = [from, to].map(|at| self.distances[self.index(at)]);
            if (a < 0.0) != (b < 0.0) {
                let (start, end) = (self.position(from).coords, self.position(to).coords);
                *crossing = Some(start.lerp(&end, a / (a - b)));
            }
        }
        Some(found)
    }

    /// For each edge of a cell, a number that it shares with the edges crossed by the same piece of
    /// surface. On a face that is crossed four times, the two inside corners are kept apart; both
    /// cells at the face decide alike, since they see the same corners.
    fn pieces(
        &self,
        cell: [usize; 3],
        crossings: &[Option<Vector3<f64>>; EDGES],
    ) -> [usize; EDGES] {
        let mut pieces: [usize; EDGES] = std::array::from_fn(|edge| edge);
        let mut link = |edge: usize, other: usize| {
            let (kept, dropped) = (pieces[edge], pieces[other]);
            for piece in pieces.iter_mut().filter(|piece| **piece == dropped) {
                *piece = kept;
            }
        };
        for (normal, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            let (u, v) = ((normal + 1) % 3, (normal + 2) % 3);
            // Counter-clockwise; corner k lies between edges k - 1 and k.
            let edges = [
                4 * u + 2 * side,
                4 * v + side + 2,
                4 * u + 1 + 2 * side,
                4 * v + side,
            ];
            let crossed: Vec<usize> = edges
                .into_iter()
                .filter(|edge| crossings[*edge].is_some())
                .collect();
            if let [edge, other] = *crossed {
                link(edge, other);
            } else if crossed.len() == 4 {
                for (corner, (along_u, along_v)) in
                    [(0, 0), (1, 0), (1, 1), (0, 1)].into_iter().enumerate()
                {
                    let mut at = cell;
                    at[normal] += side;
                    at[u] += along_u;
                    at[v] += along_v;
                    if self.is_inside(at) {
                        link(edges[(corner + 3) % 4], edges[corner]);
                    }
                }
            }
        }
        pieces
    }

    /// Gives each piece of the surface within a cell its vertex, and each edge that it crosses that vertex.
    fn piece_vertices(
        &self,
        cell: [usize; 3],
        crossings: &[Option<Vector3<f64>>; EDGES],
        solid: &mut Solid,
    ) -> [u32; EDGES] {
        let pieces = self.pieces(cell, crossings);
        let mut vertices = [0; EDGES];
        for piece in 0..EDGES {
            let edges: Vec<usize> = (0..EDGES).filter(|edge| pieces[*edge] == piece).collect();
            let points: Vec<_> = edges.iter().filter_map(|edge| crossings[*edge]).collect();
            if points.is_empty() {
                continue;
            }
            let mut mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
            if cell[2] == GROUND_LAYER {
                mean.z = 0.0;
            }
            for edge in edges {
                vertices[edge] = solid.vertices_mm.len() as u32;
            }
            solid.vertices_mm.push(Point3::from(mean));
        }
        vertices
    }
}

/// All steps from the first to before the last along each axis; x varies fastest.
fn between(first: [usize; 3], last: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [xs, ys, zs] = [0, 1, 2].map(|axis| first[axis]..last[axis]);
    zs.flat_map(move |z| ys.clone().map(move |y| (y, z)))
        .flat_map(move |(y, z)| xs.clone().map(move |x| [x, y, z]))
}

fn beyond(at: [usize; 3], steps: [usize; 3]) -> [usize; 3] {
    [at[0] + steps[0], at[1] + steps[1], at[2] + steps[2]]
}

/// The crossed cells' vertices, by edge.
struct CellVertices {
    /// Position in `by_edge` for each lattice point, the cell's lowest corner.
    crossed: Vec<u32>,
    /// The vertex whose piece of surface crosses the edge; meaningless for other edges.
    by_edge: Vec<[u32; EDGES]>,
}

impl CellVertices {
    /// Makes the vertices, and notes where they are.
    fn place(lattice: &Lattice, solid: &mut Solid) -> Self {
        let mut placed = Self {
            crossed: vec![UNCROSSED; lattice.distances.len()],
            by_edge: Vec::new(),
        };
        for cell in between([0; 3], lattice.points.map(|count| count - 1)) {
            let Some(crossings) = lattice.crossings(cell) else {
                continue;
            };
            let vertices = lattice.piece_vertices(cell, &crossings, solid);
            placed.crossed[lattice.index(cell)] = placed.by_edge.len() as u32;
            placed.by_edge.push(vertices);
        }
        placed
    }
}

fn surface_nets(field: &Field, cell_mm: f64) -> Solid {
    let lattice = Lattice::sample(field, cell_mm);
    let mut solid = Solid::default();
    let vertices = CellVertices::place(&lattice, &mut solid);
    // Edges on the lattice's low border have no four cells around them, and no crossing either.
    for from in between([1; 3], lattice.points.map(|count| count - 1)) {
        for axis in 0..3 {
            add_quad(&lattice, &vertices, from, axis, &mut solid);
        }
    }
    solid
}

/// Adds the quad around the lattice edge that leaves `from` along `axis`, if its ends differ in
/// sign.
fn add_quad(
    lattice: &Lattice,
    vertices: &CellVertices,
    from: [usize; 3],
    axis: usize,
    solid: &mut Solid,
) {
    let mut to = from;
    to[axis] += 1;
    let leaves = lattice.is_inside(from);
    if leaves == lattice.is_inside(to) {
        return;
    }
    // Counter-clockwise seen from the edge's far end.
    let around = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(back_u, back_v)| {
        let mut cell = from;
        cell[(axis + 1) % 3] -= back_u;
        cell[(axis + 2) % 3] -= back_v;
        let crossed = vertices.crossed[lattice.index(cell)];
        vertices.by_edge[crossed as usize][4 * axis + back_u + 2 * back_v]
    });
    let [a, b, c, d] = if leaves {
        around
    } else {
        [around[3], around[2], around[1], around[0]]
    };
    let gap = |u: u32, v: u32| {
        (solid.vertices_mm[u as usize] - solid.vertices_mm[v as usize]).norm_squared()
    };
    // The shorter diagonal makes the rounder triangles.
    if gap(a, c) <= gap(b, d) {
        solid.triangles.extend([[a, b, c], [a, c, d]]);
    } else {
        solid.triangles.extend([[b, c, d], [b, d, a]]);
    }
}
