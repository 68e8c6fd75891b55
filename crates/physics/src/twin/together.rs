//! Placements that several threads try together, the first ones first.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use nalgebra::Isometry3;
use ppnpack_packing::checks::trial::{Settling, TrialLimits};

use super::{ATTEMPTS, Solid, Twin};
use crate::error::PhysicsError;

/// A solid at a place.
pub(crate) type Placed = (Solid, Isometry3<f64>);

/// Tries of placements, shared by the threads that make them.
struct Tries<'a> {
    twin: &'a Twin,
    placed: &'a [Placed],
    limits: &'a TrialLimits,
    progress: Mutex<Vec<Progress>>,
    changed: Condvar,
    /// The first placement that is known to be accepted; what comes after it is tried no more.
    accepted: AtomicUsize,
}

/// Attempts at one placement, in their order.
#[derive(Default)]
struct Progress {
    begun: usize,
    outcomes: [Option<Settling>; ATTEMPTS],
    /// The outcome of the whole try, as [`Twin::try_placement`] gives it.
    settling: Option<Settling>,
    /// Whether no attempt is left to make.
    is_over: bool,
}

/// What a thread does next.
enum Next {
    /// The attempt of this number at this placement.
    Attempt(usize, usize),
    /// It waits until another thread is done with something.
    Wait,
    /// Nothing is left.
    End,
}

impl Progress {
    /// Gives the number of the attempt that may begin now.
    fn next(&self, limits: &TrialLimits) -> Option<usize> {
        let rough = self.outcomes[0].as_ref();
        let may_begin = self.begun == 0
            || self.begun < ATTEMPTS && rough.is_some_and(|it| it.beyond(limits).is_none());
        (may_begin && !self.is_over).then_some(self.begun)
    }

    /// Ends the try where the attempts before the first unknown one decide it.
    fn decide(&mut self, limits: &TrialLimits) {
        let mut worst: Option<Settling> = None;
        for outcome in &self.outcomes {
            let Some(outcome) = outcome else {
                return;
            };
            let worse = worst.map_or(*outcome, |worst| worst.worse(outcome));
            worst = Some(worse);
            if worse.beyond(limits).is_some() {
                break;
            }
        }
        self.settling = worst;
        self.is_over = true;
    }
}

impl Twin {
    /// Tries placements on the threads of a pool, until one is accepted and all before it are
    /// tried. Gives what is known then: each outcome is that of [`try_placement`](Self::try_placement).
    pub(crate) fn try_together(
        &self,
        placed: &[Placed],
        limits: &TrialLimits,
        pool: &rayon::ThreadPool,
    ) -> Vec<Option<Settling>> {
        let tries = Tries {
            twin: self,
            placed,
            limits,
            progress: Mutex::new(placed.iter().map(|_| Progress::default()).collect()),
            changed: Condvar::new(),
            accepted: AtomicUsize::new(usize::MAX),
        };
        // This thread works, too: others that are busy with another cell's tries are not needed.
        let helpers = pool.current_num_threads().min(ATTEMPTS * placed.len());
        pool.in_place_scope(|scope| {
            for _ in 1..helpers {
                scope.spawn(|_| tries.work());
            }
            tries.work();
        });
        let progress = tries.progress.into_inner();
        let progress = progress.unwrap_or_else(PoisonError::into_inner);
        progress.into_iter().map(|it| it.settling).collect()
    }
}

/// Ends the work of all threads where one panics, so that none waits for it.
struct EndOfAll<'a>(&'a Tries<'a>);

impl Drop for EndOfAll<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let Self(tries) = self;
            let _progress = tries.lock();
            tries.accepted.store(0, Ordering::Relaxed);
            tries.changed.notify_all();
        }
    }
}

impl Tries<'_> {
    fn lock(&self) -> MutexGuard<'_, Vec<Progress>> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes attempts until none is left.
    fn work(&self) {
        let _end_of_all = EndOfAll(self);
        let mut progress = self.lock();
        loop {
            match self.next(&progress) {
                Next::Attempt(index, attempt) => {
                    if let Some(it) = progress.get_mut(index) {
                        it.begun += 1;
                    }
                    drop(progress);
                    let outcome = self.attempt(index, attempt).ok();
                    progress = self.lock();
                    self.enter(&mut progress, index, attempt, outcome);
                    self.changed.notify_all();
                }
                Next::Wait => {
                    let woken = self.changed.wait(progress);
                    progress = woken.unwrap_or_else(PoisonError::into_inner);
                }
                Next::End => return,
            }
        }
    }

    fn next(&self, progress: &[Progress]) -> Next {
        let accepted = self.accepted.load(Ordering::Relaxed);
        let wanted = || progress.iter().enumerate().take(accepted);
        let attempt = wanted().find_map(|(index, it)| Some((index, it.next(self.limits)?)));
        match attempt {
            Some((index, attempt)) => Next::Attempt(index, attempt),
            None if wanted().all(|(_, it)| it.is_over) => Next::End,
            None => Next::Wait,
        }
    }

    fn attempt(&self, index: usize, attempt: usize) -> Result<Settling, PhysicsError> {
        let (solid, pose) = self.placed.get(index).ok_or(PhysicsError::Late)?;
        let goes_on = || match self.accepted.load(Ordering::Relaxed) < index {
            true => Err(PhysicsError::Late),
            false => self.twin.in_time(),
        };
        self.twin
            .attempt(solid, pose, attempt, self.limits, goes_on)
    }

    fn enter(
        &self,
        progress: &mut [Progress],
        index: usize,
        attempt: usize,
        outcome: Option<Settling>,
    ) {
        let Some(it) = progress.get_mut(index).filter(|it| !it.is_over) else {
            return;
        };
        let Some(outcome) = outcome else {
            // Why there is none is said where it is asked about.
            it.is_over = true;
            return;
        };
        if let Some(of_attempt) = it.outcomes.get_mut(attempt) {
            *of_attempt = Some(outcome);
        }
        it.decide(self.limits);
        let solid = self.placed.get(index).map(|(solid, _)| solid);
        let is_accepted = it.settling.zip(solid).is_some_and(|(settling, solid)| {
            let limits = solid.limits(self.limits);
            settling.beyond(&limits).is_none()
        });
        if is_accepted {
            self.accepted.fetch_min(index, Ordering::Relaxed);
        }
    }
}
