//! Changes by each placement of how everything lies.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

/// Items that lie elsewhere, or otherwise, after a placement than before it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Moves {
    /// Those in the container, the placed one among them, by their places in the sequence of
    /// arrivals: the poses of their own frames in that of the container.
    pub lies: Vec<(usize, Isometry3<f64>)>,
    /// Those that left the container, by their places in the sequence of arrivals.
    pub gone: Vec<usize>,
}

/// The poses of everything when it was last looked at; at first nothing lies there.
#[derive(Debug, Clone, Default)]
pub struct LastPoses {
    poses: BTreeMap<usize, Isometry3<f64>>,
}

impl LastPoses {
    /// Tells what changed since the last look. `now` is all that lies in or on the container, by
    /// its place in the sequence of arrivals.
    pub fn changed(&mut self, now: impl IntoIterator<Item = (usize, Isometry3<f64>)>) -> Moves {
        let now: BTreeMap<usize, Isometry3<f64>> = now.into_iter().collect();
        let moved = now
            .iter()
            .filter(|(arrival, pose)| self.poses.get(*arrival) != Some(*pose));
        let lies = moved.map(|(arrival, pose)| (*arrival, *pose)).collect();
        let before = self.poses.keys().copied();
        let gone = before
            .filter(|arrival| !now.contains_key(arrival))
            .collect();
        self.poses = now;
        Moves { lies, gone }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_moved_came_or_left_is_told() {
        let at = |x_m: f64| Isometry3::translation(x_m, 0.0, 0.0);
        let mut last = LastPoses::default();
        let first = last.changed([(4, at(0.1))]);
        assert_eq!(first.lies, [(4, at(0.1))]);
        let second = last.changed([(4, at(0.1)), (2, at(0.2))]);
        assert_eq!((second.lies, second.gone), (vec![(2, at(0.2))], Vec::new()));
        let third = last.changed([(2, at(0.3))]);
        assert_eq!((third.lies, third.gone), (vec![(2, at(0.3))], vec![4]));
        assert_eq!(last.changed([(2, at(0.3))]), Moves::default());
    }
}
