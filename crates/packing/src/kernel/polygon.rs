//! Convex support polygons.

use nalgebra::Point2;

/// Twice the signed area of the triangle `a b c`; positive where it turns left.
fn turn(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

/// A convex hull under construction; its buffers are reused from call to call.
#[derive(Debug, Clone, Default)]
pub(crate) struct SupportPolygon {
    contacts: Vec<Point2<f64>>,
    hull: Vec<Point2<f64>>,
}

impl SupportPolygon {
    pub(crate) fn clear(&mut self) {
        self.contacts.clear();
    }

    /// Adds the contacts of row `x` in the middles of cells, which say along y whether they are
    /// one: the outermost alone can be corners of the hull. The cells' edge gives the unit of
    /// length.
    #[inline]
    pub(crate) fn add_row(
        &mut self,
        x: usize,
        mut are_contacts: impl DoubleEndedIterator<Item = bool> + ExactSizeIterator,
        cell: f64,
    ) {
        let middle = |y: usize| Point2::new(x as f64 + 0.5, y as f64 + 0.5) * cell;
        if let Some(first) = are_contacts.position(|is_contact| is_contact) {
            self.contacts.push(middle(first));
            let after = are_contacts.rposition(|is_contact| is_contact);
            self.contacts
                .extend(after.map(|after| middle(first + 1 + after)));
        }
    }

    /// Depth of a point inside the hull: the distance to the nearest edge, negative outside.
    ///
    /// Minus infinity where the hull has no area.
    pub(crate) fn depth(&mut self, point: Point2<f64>) -> f64 {
        convex_hull(&mut self.contacts, &mut self.hull);
        if self.hull.len() < 3 {
            return f64::NEG_INFINITY;
        }
        let ends = self.hull.iter().cycle().skip(1);
        self.hull
            .iter()
            .zip(ends)
            .map(|(start, end)| turn(*start, *end, point) / (end - start).norm())
            .fold(f64::INFINITY, f64::min)
    }
}

/// The convex hull of points, counter-clockwise, without collinear points, by Andrew's monotone
/// chain. The points are left sorted, each once.
pub(crate) fn convex_hull(points: &mut Vec<Point2<f64>>, hull: &mut Vec<Point2<f64>>) {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    hull.clear();
    for point in points.iter() {
        extend(hull, *point, 0);
    }
    let lower = hull.len().saturating_sub(1);
    for point in points.iter().rev().skip(1) {
        extend(hull, *point, lower);
    }
    hull.pop();
}

/// Adds a point to a chain that starts at index `first`, dropping those that no longer turn left.
fn extend(hull: &mut Vec<Point2<f64>>, point: Point2<f64>, first: usize) {
    while let [.., before, last] = hull.as_slice() {
        if hull.len() < first + 2 || turn(*before, *last, point) > 0.0 {
            break;
        }
        hull.pop();
    }
    hull.push(point);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(contacts: &[(f64, f64)], point: (f64, f64)) -> f64 {
        let mut polygon = SupportPolygon::default();
        let contacts = contacts.iter().map(|(x, y)| Point2::new(*x, *y));
        polygon.contacts.extend(contacts);
        polygon.depth(Point2::new(point.0, point.1))
    }

    #[test]
    fn depth_is_the_distance_to_the_nearest_edge() {
        let sides = [(0.0, 0.0), (0.0, 4.0), (4.0, 0.0), (4.0, 4.0)];
        let square = [&sides[..], &[(2.0, 2.0), (4.0, 2.0)]].concat();
        assert!((depth(&square, (1.0, 2.0)) - 1.0).abs() < 1e-12);
        assert!((depth(&square, (5.0, 2.0)) + 1.0).abs() < 1e-12);
        let triangle = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)];
        assert!((depth(&triangle, (1.0, 1.0)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn points_and_lines_support_nothing() {
        let line = [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)];
        for contacts in [&[], &line[1..2], &line] {
            assert_eq!(depth(contacts, (1.0, 1.0)), f64::NEG_INFINITY);
        }
    }
}
