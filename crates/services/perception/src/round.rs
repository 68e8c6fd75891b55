//! Clouds of all sensors of a cell that show the same state of it.

/// Collects a cloud `T` of each sensor.
pub(crate) struct Round<T> {
    /// With the state that it shows.
    clouds: Vec<Option<(u64, T)>>,
}

impl<T> Round<T> {
    pub(crate) fn new(sensors: usize) -> Self {
        Self {
            clouds: (0..sensors).map(|_| None).collect(),
        }
    }

    /// Takes a cloud of a sensor, in place of its last one; gives the clouds of all sensors once all show the same state.
    ///
    /// A state may be lower than one before: where the bridge has lost its journal or had an older one restored, it counts
    /// from there.
    pub(crate) fn take(&mut self, sensor: usize, state_number: u64, cloud: T) -> Option<Vec<T>> {
        if let Some(slot) = self.clouds.get_mut(sensor) {
            *slot = Some((state_number, cloud));
        }
        let shows_it = |slot: &Option<(u64, T)>| {
            slot.as_ref()
                .is_some_and(|(state, _)| *state == state_number)
        };
        if !self.clouds.iter().all(shows_it) {
            return None;
        }
        let clouds = self.clouds.iter_mut().filter_map(Option::take);
        Some(clouds.map(|(_, cloud)| cloud).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sensor_completes_a_round_by_itself() {
        let mut round = Round::new(1);
        assert_eq!(round.take(0, 0, 1), Some(vec![1]));
        assert_eq!(round.take(0, 5, 2), Some(vec![2]));
        assert_eq!(round.take(0, 1, 1), Some(vec![1]));
    }

    #[test]
    fn a_round_has_a_cloud_of_each_sensor_since_the_last() {
        let mut round = Round::new(2);
        assert_eq!(round.take(0, 0, 1), None);
        assert_eq!(round.take(0, 0, 2), None);
        assert_eq!(round.take(1, 0, 9), Some(vec![2, 9]));
        assert_eq!(round.take(1, 0, 10), None);
        assert_eq!(round.take(0, 0, 3), Some(vec![3, 10]));
    }

    #[test]
    fn clouds_of_different_states_are_not_put_together() {
        let mut round = Round::new(2);
        assert_eq!(round.take(0, 4, 1), None);
        assert_eq!(
            round.take(1, 5, 1),
            None,
            "the first is of the state before"
        );
        assert_eq!(round.take(0, 4, 2), None, "late");
        assert_eq!(round.take(0, 5, 3), Some(vec![3, 1]));
    }

    #[test]
    fn a_state_that_is_lower_than_one_before_is_taken_once_all_sensors_show_it() {
        let mut round = Round::new(2);
        assert_eq!(
            round.take(0, u64::MAX, 1),
            None,
            "of a journal that is lost"
        );
        assert_eq!(round.take(1, 3, 1), None);
        assert_eq!(round.take(0, 3, 2), Some(vec![2, 1]));
    }
}
