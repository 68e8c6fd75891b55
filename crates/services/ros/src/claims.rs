//! Which cell has which name in ROS: what is asked under a name must reach one cell alone.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use ppnpack_ros::names::Name;
use ppnpack_wire::keys::Cell;

/// For how long a cell keeps its name when none of its services is found any more: those that are restarted come back to it.
const KEPT: Duration = Duration::from_secs(60);

/// The names that are taken.
#[derive(Debug, Default)]
pub(crate) struct Claims {
    holders: BTreeMap<Name, Holder>,
}

/// Who has a name.
#[derive(Debug)]
struct Holder {
    cell: Cell,
    /// When a service of it was found last.
    found_at: Instant,
}

/// What became of a claim.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Claim {
    /// The cell has the name.
    Held,
    /// The cell has it now; that one had it, and has gone.
    TakenFrom(Cell),
    /// That one has it.
    Refused(Cell),
}

impl Claims {
    /// A cell of which a service is found now claims its name.
    pub(crate) fn claim(&mut self, name: &Name, cell: &Cell, now: Instant) -> Claim {
        let holder = self.holders.entry(name.clone()).or_insert_with(|| Holder {
            cell: cell.clone(),
            found_at: now,
        });
        if holder.cell == *cell {
            holder.found_at = now;
            return Claim::Held;
        }
        if now.saturating_duration_since(holder.found_at) < KEPT {
            return Claim::Refused(holder.cell.clone());
        }
        holder.found_at = now;
        Claim::TakenFrom(std::mem::replace(&mut holder.cell, cell.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_goes_to_another_cell_only_when_its_own_has_long_gone() {
        let name = Name::new("/ppnpack/cell_1").unwrap();
        let [first, second] = ["cell-1", "cell_1"].map(|name| Cell::new(name).unwrap());
        let began = Instant::now();
        let at = |part: f64| began + KEPT.mul_f64(part);
        let mut claims = Claims::default();
        let mut claim = |cell: &Cell, now| claims.claim(&name, cell, now);
        assert_eq!(claim(&first, at(0.0)), Claim::Held);
        assert_eq!(claim(&second, at(0.5)), Claim::Refused(first.clone()));
        // The first one is still there: the time counts from now.
        assert_eq!(claim(&first, at(0.9)), Claim::Held);
        assert_eq!(claim(&second, at(1.5)), Claim::Refused(first.clone()));
        assert_eq!(claim(&second, at(1.9)), Claim::TakenFrom(first.clone()));
        assert_eq!(claim(&second, at(2.0)), Claim::Held);
        assert_eq!(claim(&first, at(2.0)), Claim::Refused(second));
    }
}
