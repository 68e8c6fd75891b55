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

    /// A cloud of a sensor and a state, and the round that it completes, if any.
    type Put<'round> = (usize, u64, i32, Option<&'round [i32]>);

    #[test]
    fn a_round_has_a_cloud_of_each_sensor_that_shows_the_same_state() {
        let alone: &[Put<'_>] = &[
            (0, 0, 1, Some(&[1])),
            (0, 5, 2, Some(&[2])),
            (0, 1, 1, Some(&[1])),
        ];
        let in_turn: &[Put<'_>] = &[
            (0, 0, 1, None),
            (0, 0, 2, None),
            (1, 0, 9, Some(&[2, 9])),
            (1, 0, 10, None),
            (0, 0, 3, Some(&[3, 10])),
        ];
        // The first is of the state before, the third is late.
        let of_two_states: &[Put<'_>] = &[
            (0, 4, 1, None),
            (1, 5, 1, None),
            (0, 4, 2, None),
            (0, 5, 3, Some(&[3, 1])),
        ];
        // The first is of a journal that is lost.
        let counting_anew: &[Put<'_>] = &[
            (0, u64::MAX, 1, None),
            (1, 3, 1, None),
            (0, 3, 2, Some(&[2, 1])),
        ];
        for (sensors, clouds) in [
            (1, alone),
            (2, in_turn),
            (2, of_two_states),
            (2, counting_anew),
        ] {
            let mut round = Round::new(sensors);
            for (sensor, state_number, cloud, completed) in clouds {
                round.put(*sensor, *state_number, *cloud);
                assert_eq!(
                    round.take(*state_number).as_deref(),
                    *completed,
                    "{clouds:?}"
                );
            }
        }
    }

    #[test]
    fn clouds_that_no_round_came_of_are_given_back() {
        let mut round = Round::new(2);
        assert_eq!(round.put(0, 4, 1), None);
        assert_eq!(round.put(0, 4, 2), Some(1));
        assert_eq!(round.put(1, 4, 3), None);
        assert_eq!(round.take(4), Some(vec![2, 3]));
        assert_eq!(round.put(0, 5, 4), None);
    }
}
