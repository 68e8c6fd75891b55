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
    /// People at the cell.
    pub people: u8,
    /// Controllers that carry decisions out, where the planner does not by itself.
    pub controllers: u8,
    /// Whether the robot may fail: miss an item, lose it, not know.
    pub may_fail: bool,
    /// What is taken out of the software, to see that it is missed.
    pub sabotage: Option<Sabotage>,
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
    /// A request is given up by who asked; it may arrive all the same. So may a hold that was
    /// answered, once more.
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

/// A safeguard that is taken out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sabotage {
    /// The bridge carries out what was planned on any state.
    AnyState,
    /// The bridge begins placements while the cell is held.
    BeginsWhileHeld,
    /// A cell that is resumed goes on at the state at which it was held.
    SameStateAfterHold,
    /// What was decided before is not voided where somebody begins anew or acknowledges a failure.
    NothingIsVoided,
    /// The bridge says that it knows all that was done, and that what it knows nothing of was not.
    KnowsAll,
    /// A placement that was cut off counts as not placed in a real cell.
    CutOffIsNotPlaced,
    /// A session that was restored goes on by itself.
    RestoredGoesOn,
    /// Whatever a request to resume names, it ends all that holds the cell.
    AnyResume,
    /// In a cell that is held another one who holds it is not noted.
    FirstHoldStays,
    /// A real cell of which nothing is known begins.
    BeginsWithoutPast,
    /// Whatever failure is acknowledged, a session goes on.
    AnyFailure,
    /// A bridge that was killed does not go on with what was asked for.
    NeverStarts,
}

impl Configuration {
    /// One planner that packs by itself.
    pub fn automatic(name: &'static str) -> Self {
        Self {
            name,
            items: 2,
            decisions: 3,
            people: 1,
            controllers: 0,
            may_fail: false,
            sabotage: None,
            most: [0; Fault::COUNT],
        }
    }

    /// The worlds that are gone through from end to end, each in less than a minute.
    pub fn small() -> Vec<Self> {
        use Fault::*;
        let automatic = Self::automatic;
        vec![
            automatic("nothing fails"),
            automatic("kills").with(&[(KillBridge, 2), (KillPlanner, 1), (TimeOut, 2)]),
            automatic("holds").with(&[(Hold, 2), (Hand, 1), (TimeOut, 2)]),
            automatic("two people")
                .by_people(2)
                .with(&[(Hold, 2), (TimeOut, 1)]),
            automatic("kills and holds").with(&[
                (Hold, 1),
                (Hand, 1),
                (KillBridge, 1),
                (TimeOut, 1),
            ]),
            automatic("a held cell whose journal is lost").with(&[
                (Hold, 1),
                (KillBridge, 1),
                (LoseJournal, 1),
                (TimeOut, 1),
            ]),
            automatic("lost disks").with(&[
                (KillBridge, 1),
                (KillPlanner, 1),
                (LoseJournal, 1),
                (LoseStore, 1),
                (TimeOut, 1),
            ]),
            automatic("backups").with(&[
                (KillBridge, 1),
                (KillPlanner, 1),
                (Restore, 1),
                (TimeOut, 1),
            ]),
            automatic("a backup, then a new container").with(&[
                (KillPlanner, 1),
                (Restore, 1),
                (Renew, 1),
                (TimeOut, 1),
            ]),
            automatic("renewals").with(&[(KillBridge, 1), (Renew, 1), (Hold, 1), (TimeOut, 1)]),
            automatic("a robot that fails")
                .failing()
                .with(&[(KillBridge, 1), (TimeOut, 1)]),
            automatic("two people and a robot that fails")
                .failing()
                .by_people(2),
            automatic("two controllers").by_controllers(2).with(&[
                (KillBridge, 1),
                (Hold, 1),
                (TimeOut, 1),
            ]),
        ]
    }

    /// Worlds that are too large for that: everything in them at once.
    pub fn large() -> Vec<Self> {
        let all = |world: Self| Self {
            items: 4,
            decisions: 8,
            people: 2,
            most: [3; Fault::COUNT],
            ..world.failing()
        };
        vec![
            all(Self::automatic("everything, by itself")),
            all(Self::automatic("everything, by three controllers").by_controllers(3)),
        ]
    }

    /// The same, in which the robot may fail.
    #[must_use]
    pub fn failing(self) -> Self {
        Self {
            may_fail: true,
            ..self
        }
    }

    /// The same, in which so many controllers carry decisions out, in place of the planner.
    #[must_use]
    pub fn by_controllers(self, controllers: u8) -> Self {
        Self {
            controllers,
            ..self
        }
    }

    /// The same, with so many people.
    #[must_use]
    pub fn by_people(self, people: u8) -> Self {
        Self { people, ..self }
    }

    /// The same without a safeguard.
    #[must_use]
    pub fn without(self, sabotage: Sabotage) -> Self {
        Self {
            sabotage: Some(sabotage),
            ..self
        }
    }

    /// Whether a safeguard is taken out.
    pub(crate) fn lacks(&self, sabotage: Sabotage) -> bool {
        self.sabotage == Some(sabotage)
    }

    /// The same, in which each of these may happen so often.
    #[must_use]
    pub fn with(mut self, faults: &[(Fault, u8)]) -> Self {
        for (fault, most) in faults {
            if let Some(own) = self.most.get_mut(*fault as usize) {
                *own = *most;
            }
        }
        self
    }

    /// Gives how often something may happen.
    pub(crate) fn most(&self, fault: Fault) -> u8 {
        self.most.get(fault as usize).copied().unwrap_or_default()
    }
}
