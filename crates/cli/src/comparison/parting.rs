//! Where the choices of two runs first part.

use serde::{Deserialize, Serialize};

/// Lengths and angles that differ by less are the same.
const SAME: f64 = 1e-9;

/// What `placements.csv` says of a choice.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Line {
    step: u64,
    arrival: usize,
    item: String,
    pose: usize,
    yaw_rad: f64,
    cell_x: usize,
    cell_y: usize,
    resting_height_m: f64,
}

/// Which item a step placed, and where.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Choice {
    arrival: usize,
    item: String,
    /// 0: as it was offered.
    pose: usize,
    yaw_rad: f64,
    /// The footprint's corner, and the lowest point's height.
    x_m: f64,
    y_m: f64,
    z_m: f64,
    /// The step's number, from 0.
    #[serde(skip)]
    step: u64,
}

/// The first step in which two runs do not do the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Parting {
    /// From 0.
    pub(crate) step: u64,
    /// What each chose; absent in one that had ended.
    pub(crate) a: Option<Choice>,
    pub(crate) b: Option<Choice>,
}

impl Choice {
    /// Of a line, on a grid of such cells.
    pub(super) fn of(line: Line, cell_m: f64) -> Self {
        Self {
            arrival: line.arrival,
            item: line.item,
            pose: line.pose,
            yaw_rad: line.yaw_rad,
            x_m: line.cell_x as f64 * cell_m,
            y_m: line.cell_y as f64 * cell_m,
            z_m: line.resting_height_m,
            step: line.step,
        }
    }

    /// Whether it is the same item in the same pose at the same place.
    fn is_same(&self, other: &Self) -> bool {
        let numbers = |choice: &Self| [choice.yaw_rad, choice.x_m, choice.y_m, choice.z_m];
        let mut pairs = numbers(self).into_iter().zip(numbers(other));
        let is_same_item = self.arrival == other.arrival && self.item == other.item;
        is_same_item && self.pose == other.pose && pairs.all(|(a, b)| (a - b).abs() < SAME)
    }

    fn told(&self) -> String {
        let [x_cm, y_cm, z_cm] = [self.x_m, self.y_m, self.z_m].map(|at_m| at_m * 100.0);
        format!(
            "{} (arrival {}, pose {}) at x {x_cm:.2} cm, y {y_cm:.2} cm, z {z_cm:.2} cm, turned by {:.0}°",
            self.item,
            self.arrival,
            self.pose,
            self.yaw_rad.to_degrees()
        )
    }
}

impl Parting {
    /// What each run did, for people.
    pub(crate) fn told(&self) -> String {
        let [a, b] = self.choices();
        format!("In step {} A placed {a}; B placed {b}.", self.step + 1)
    }

    /// What A and B placed, for people.
    pub(super) fn choices(&self) -> [String; 2] {
        [&self.a, &self.b].map(|choice| {
            let choice = choice.as_ref();
            choice.map_or_else(|| "nothing, as it had ended".to_owned(), Choice::told)
        })
    }
}

/// How many steps are the same from the first on, and what comes then.
pub(super) fn first(a: &[Choice], b: &[Choice]) -> (usize, Option<Parting>) {
    let same = a.iter().zip(b).take_while(|(a, b)| a.is_same(b)).count();
    let (a, b) = (a.get(same).cloned(), b.get(same).cloned());
    let step = a.as_ref().or(b.as_ref()).map(|choice| choice.step);
    (same, step.map(|step| Parting { step, a, b }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(step: u64, item: &str, x_m: f64) -> Choice {
        Choice {
            arrival: 0,
            item: item.to_owned(),
            pose: 0,
            yaw_rad: 0.0,
            x_m,
            y_m: 0.1,
            z_m: 0.0,
            step,
        }
    }

    #[test]
    fn choices_part_where_the_item_or_its_place_differ() {
        let one = [choice(0, "mug", 0.1), choice(1, "bowl", 0.1)];
        assert_eq!(first(&one, &one), (2, None));
        for other in [choice(1, "bowl", 0.11), choice(1, "spoon", 0.1)] {
            let two = [choice(0, "mug", 0.1 + 1e-12), other.clone()];
            let (same, parting) = first(&one, &two);
            let parting = parting.unwrap();
            assert_eq!((same, parting.step), (1, 1));
            assert_eq!(parting.b, Some(other));
            assert!(parting.told().contains("In step 2 A placed bowl"));
        }
    }

    #[test]
    fn a_run_that_ends_before_the_other_parts_there() {
        let one = [choice(0, "mug", 0.1)];
        let (same, parting) = first(&one, &[]);
        let parting = parting.unwrap();
        assert_eq!((same, parting.step), (0, 0));
        assert!(parting.told().contains("B placed nothing"));
    }
}
