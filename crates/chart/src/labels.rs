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
    /// A square around a centre.
    pub(crate) fn around([x, y]: Place, reach: f64) -> Self {
        Self {
            left: x - reach,
            top: y - reach,
            right: x + reach,
            bottom: y + reach,
        }
    }

    /// A line along an axis, with the room that its ends take.
    pub(crate) fn of_line([from, to]: [Place; 2]) -> Self {
        Self {
            left: from[0].min(to[0]) - 4.0,
            right: from[0].max(to[0]) + 4.0,
            top: from[1].min(to[1]) - 4.0,
            bottom: from[1].max(to[1]) + 4.0,
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
                Area {
                    left: middle_x - width / 2.0,
                    right: middle_x + width / 2.0,
                    top: middle_y - height / 2.0,
                    bottom: middle_y + height / 2.0,
                }
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
        let bounds = Area {
            left: 0.0,
            top: 0.0,
            right: 400.0,
            bottom: 300.0,
        };
        let points: Vec<(Place, [f64; 2])> =
            [[100.0, 100.0], [112.0, 104.0], [98.0, 112.0], [395.0, 5.0]]
                .map(|place| (place, [80.0, 14.0]))
                .to_vec();
        let obstacles = points
            .iter()
            .map(|(place, _)| Area::around(*place, 6.0))
            .collect();
        let labels = placed(&points, obstacles, bounds);
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
