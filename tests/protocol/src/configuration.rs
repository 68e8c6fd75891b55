//! How large a world is, and what may happen in it.

/// How large a world is, and how often what may happen.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// What it is called.
    pub name: &'static str,
    /// The items that wait at the beginning.
    pub items: u8,
    /// The most decisions that are made.
    pub decisions: u8,
    /// Controllers that carry decisions out, where the planner does not by itself.
    pub controllers: u8,
    /// Whether the cell is simulated: what it did and did not write down has not happened.
    pub is_simulated: bool,
    /// Whether the robot may fail: miss an item, lose it, not know.
    pub may_fail: bool,
    /// Of how many worlds one is followed, to see whether it goes on when all faults have ended.
    pub followed: u64,
    /// How often something may happen, by [`Fault`].
    pub most: [u8; Fault::COUNT],
}

/// Something that may only happen so often.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The bridge is killed.
    KillBridge,
    /// The planner is killed.
    KillPlanner,
    /// A request is given up by who asked; it may arrive all the same.
    TimeOut,
    /// The journal is lost, while the bridge is down.
    LoseJournal,
    /// The session store is lost, while the planner is down.
    LoseStore,
    /// A backup of journal or store is put back, while its process is down.
    Restore,
    /// The cell is held by somebody.
    Hold,
    /// A hand takes an item out of the held cell.
    Hand,
    /// The container is renewed.
    Renew,
}

impl Fault {
    /// How many there are.
    pub const COUNT: usize = 9;
}

impl Configuration {
    /// One planner that packs by itself.
    pub fn automatic(name: &'static str) -> Self {
        Self {
            name,
            items: 2,
            decisions: 3,
            controllers: 0,
            is_simulated: false,
            may_fail: false,
            followed: 1,
            most: [0; Fault::COUNT],
        }
    }

    /// The same, in which something may happen so often.
    #[must_use]
    pub fn with(mut self, fault: Fault, most: u8) -> Self {
        if let Some(own) = self.most.get_mut(fault as usize) {
            *own = most;
        }
        self
    }

    /// Whether something may happen at all.
    pub fn allows(&self, fault: Fault) -> bool {
        self.most.get(fault as usize).is_some_and(|most| *most > 0)
    }
}
