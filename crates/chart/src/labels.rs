//! Where the labels of points go, so that they cover neither points nor each other.

/// A position in pixels from the top left.
pub(crate) type Place = [f64; 2];

/// A rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Area {
    /// From one corner to the other, with room on all sides.
    pub(crate) fn of([from, to]: [Place; 2], room: f64) -> Self {
        Self {
            left: from[0].min(to[0]) - room,
            top: from[1].min(to[1]) - room,
            right: from[0].max(to[0]) + room,
            bottom: from[1].max(to[1]) + room,
        }
    }

    /// Its middle.
    pub(crate) fn middle(&self) -> Place {
        [
            (self.left + self.right) / 2.0,
            (self.top + self.bottom) / 2.0,
        ]
    }

    fn shared_with(&self, other: &Self) -> f64 {
        let width = self.right.min(other.right) - self.left.max(other.left);
        let height = self.bottom.min(other.bottom) - self.top.max(other.top);
        width.max(0.0) * height.max(0.0)
    }

    fn size(&self) -> f64 {
        (self.right - self.left) * (self.bottom - self.top)
    }
}

/// Places one label after the other: each takes the spot near its point that overlaps least with `obstacles` and the
/// labels before, and prefers the first spots.
pub(crate) fn placed(
    points: &[(Place, [f64; 2])],
    mut obstacles: Vec<Area>,
    bounds: Area,
) -> Vec<Area> {
    /// Directions from the point, in order of preference, and how far from it.
    const DIRECTIONS: [[f64; 2]; 8] = [
        [1.0, 0.0],
        [0.0, -1.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [1.0, -1.0],
        [1.0, 1.0],
        [-1.0, -1.0],
        [-1.0, 1.0],
    ];
    const DISTANCES: [f64; 5] = [10.0, 14.0, 18.0, 23.0, 30.0];

    let mut labels = Vec::with_capacity(points.len());
    for ([x, y], [width, height]) in points {
        let spots = DISTANCES.iter().flat_map(|distance| {
            DIRECTIONS.iter().map(move |[right, down]| {
                let diagonal = if right * down == 0.0 { 1.0 } else { 0.6 };
                let middle_x = x + right * (distance * diagonal + width / 2.0);
                let middle_y = y + down * (distance * diagonal + height / 2.0);
                let (half_x, half_y) = (width / 2.0, height / 2.0);
                let corner = [middle_x - half_x, middle_y - half_y];
                Area::of([corner, [middle_x + half_x, middle_y + half_y]], 0.0)
            })
        });
        let costs = spots.enumerate().map(|(rank, spot)| {
            let covered: f64 = obstacles.iter().map(|other| spot.shared_with(other)).sum();
            let outside = spot.size() - spot.shared_with(&bounds);
            (8.0 * covered + 20.0 * outside + 3.0 * rank as f64, spot)
        });
        if let Some((_, spot)) = costs.min_by(|(a, _), (b, _)| a.total_cmp(b)) {
            obstacles.push(spot);
            labels.push(spot);
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crowded_labels_do_not_overlap() {
        let bounds = Area::of([[0.0, 0.0], [400.0, 300.0]], 0.0);
        let points: Vec<(Place, [f64; 2])> =
            [[100.0, 100.0], [112.0, 104.0], [98.0, 112.0], [395.0, 5.0]]
                .map(|place| (place, [80.0, 14.0]))
                .to_vec();
        let obstacles = points.iter().map(|(place, _)| Area::of([*place; 2], 6.0));
        let labels = placed(&points, obstacles.collect(), bounds);
        assert_eq!(labels.len(), points.len());
        for (index, label) in labels.iter().enumerate() {
            assert!(
                labels[..index]
                    .iter()
                    .all(|other| label.shared_with(other) == 0.0)
            );
            assert_eq!(label.shared_with(&bounds), label.size());
        }
    }
}
