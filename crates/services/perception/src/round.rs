//! Clouds of all sensors of a cell that show the same state of it.

use std::time::Instant;

use crate::slot::Arrived;

/// Collects a cloud of each sensor.
pub(crate) struct Round {
    clouds: Vec<Option<Arrived>>,
}

impl Round {
    pub(crate) fn new(sensors: usize) -> Self {
        Self {
            clouds: (0..sensors).map(|_| None).collect(),
        }
    }

    /// Takes a cloud; the clouds of all sensors once each has sent one. Clouds of an earlier state than the others show
    /// another scene, and are dropped.
    pub(crate) fn take(&mut self, arrived: Arrived) -> Option<Vec<Arrived>> {
        let state_number = arrived.cloud.state_number;
        let waiting = self.clouds.iter().flatten();
        if waiting
            .map(|cloud| cloud.cloud.state_number)
            .any(|other| other > state_number)
        {
            return None;
        }
        for place in &mut self.clouds {
            place.take_if(|cloud| cloud.cloud.state_number < state_number);
        }
        if let Some(place) = self.clouds.get_mut(arrived.sensor) {
            *place = Some(arrived);
        }
        if self.clouds.iter().all(Option::is_some) {
            Some(self.clouds.iter_mut().filter_map(Option::take).collect())
        } else {
            None
        }
    }
}

/// When the first of some clouds came.
pub(crate) fn first_at(clouds: &[Arrived]) -> Instant {
    let moments = clouds.iter().map(|cloud| cloud.at);
    moments.min().unwrap_or_else(Instant::now)
}

#[cfg(test)]
mod tests {
    use ppnpack_wire::v1;

    use super::*;

    fn cloud(sensor: usize, state_number: u64, sequence: u64) -> Arrived {
        Arrived {
            cloud: v1::PointCloud {
                state_number,
                sequence,
                ..v1::PointCloud::default()
            },
            sensor,
            at: Instant::now(),
        }
    }

    fn sequences(clouds: Option<Vec<Arrived>>) -> Option<Vec<u64>> {
        clouds.map(|clouds| clouds.iter().map(|cloud| cloud.cloud.sequence).collect())
    }

    #[test]
    fn one_sensor_completes_a_round_by_itself() {
        let mut round = Round::new(1);
        assert_eq!(sequences(round.take(cloud(0, 0, 1))), Some(vec![1]));
        assert_eq!(sequences(round.take(cloud(0, 5, 2))), Some(vec![2]));
        assert_eq!(sequences(round.take(cloud(0, 1, 1))), Some(vec![1]));
    }

    #[test]
    fn a_round_has_a_cloud_of_each_sensor_since_the_last() {
        let mut round = Round::new(2);
        assert_eq!(sequences(round.take(cloud(0, 0, 1))), None);
        assert_eq!(sequences(round.take(cloud(0, 0, 2))), None);
        assert_eq!(sequences(round.take(cloud(1, 0, 9))), Some(vec![2, 9]));
        assert_eq!(sequences(round.take(cloud(1, 0, 10))), None);
        assert_eq!(sequences(round.take(cloud(0, 0, 3))), Some(vec![3, 10]));
    }

    #[test]
    fn clouds_of_different_states_are_not_put_together() {
        let mut round = Round::new(2);
        assert_eq!(sequences(round.take(cloud(0, 4, 1))), None);
        assert_eq!(
            sequences(round.take(cloud(1, 5, 1))),
            None,
            "the first is of the state before"
        );
        assert_eq!(sequences(round.take(cloud(0, 4, 2))), None, "late");
        assert_eq!(sequences(round.take(cloud(0, 5, 3))), Some(vec![3, 1]));
    }
}
