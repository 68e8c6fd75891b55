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

    /// Puts a cloud of a sensor in place of its last one, if that is of no complete round, and
    /// gives that one back.
    ///
    /// It may show a lower state than those before: where the bridge has lost its journal or had an
    /// older one restored, it counts from there.
    pub(crate) fn put(&mut self, sensor: usize, state_number: u64, cloud: T) -> Option<T> {
        let slot = self.clouds.get_mut(sensor)?;
        slot.replace((state_number, cloud)).map(|(_, cloud)| cloud)
    }

    /// Takes the clouds of all sensors, once all show this state.
    pub(crate) fn take(&mut self, state_number: u64) -> Option<Vec<T>> {
        let mut clouds = self.clouds.iter().map(Option::as_ref);
        if !clouds.all(|cloud| cloud.is_some_and(|(state, _)| *state == state_number)) {
            return None;
        }
        let clouds = self.clouds.iter_mut().filter_map(Option::take);
        Some(clouds.map(|(_, cloud)| cloud).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put(
        round: &mut Round<i32>,
        sensor: usize,
        state_number: u64,
        cloud: i32,
    ) -> Option<Vec<i32>> {
        round.put(sensor, state_number, cloud);
        round.take(state_number)
    }

    #[test]
    fn one_sensor_completes_a_round_by_itself() {
        let mut round = Round::new(1);
        assert_eq!(put(&mut round, 0, 0, 1), Some(vec![1]));
        assert_eq!(put(&mut round, 0, 5, 2), Some(vec![2]));
        assert_eq!(put(&mut round, 0, 1, 1), Some(vec![1]));
    }

    #[test]
    fn a_round_has_a_cloud_of_each_sensor_since_the_last() {
        let mut round = Round::new(2);
        assert_eq!(put(&mut round, 0, 0, 1), None);
        assert_eq!(put(&mut round, 0, 0, 2), None);
        assert_eq!(put(&mut round, 1, 0, 9), Some(vec![2, 9]));
        assert_eq!(put(&mut round, 1, 0, 10), None);
        assert_eq!(put(&mut round, 0, 0, 3), Some(vec![3, 10]));
    }

    #[test]
    fn clouds_of_different_states_are_not_put_together() {
        let mut round = Round::new(2);
        assert_eq!(put(&mut round, 0, 4, 1), None);
        assert_eq!(
            put(&mut round, 1, 5, 1),
            None,
            "the first is of the state before"
        );
        assert_eq!(put(&mut round, 0, 4, 2), None, "late");
        assert_eq!(put(&mut round, 0, 5, 3), Some(vec![3, 1]));
    }

    #[test]
    fn a_state_that_is_lower_than_one_before_is_taken_once_all_sensors_show_it() {
        let mut round = Round::new(2);
        assert_eq!(
            put(&mut round, 0, u64::MAX, 1),
            None,
            "of a journal that is lost"
        );
        assert_eq!(put(&mut round, 1, 3, 1), None);
        assert_eq!(put(&mut round, 0, 3, 2), Some(vec![2, 1]));
    }

    #[test]
    fn what_no_round_came_of_is_given_back() {
        let mut round = Round::new(2);
        assert_eq!(round.put(0, 4, 1), None);
        assert_eq!(round.put(0, 4, 2), Some(1));
        assert_eq!(round.put(1, 4, 3), None);
        assert_eq!(round.take(4), Some(vec![2, 3]));
        assert_eq!(round.put(0, 5, 4), None);
    }
}
