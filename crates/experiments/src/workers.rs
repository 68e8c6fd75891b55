//! Independent jobs on several threads.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use ppnpack_cli::failure::Outcome;
use ppnpack_cli::progress;

/// Default number of workers: one per core, so that each times its decisions undisturbed.
pub(crate) fn default_count() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Does all jobs, each on one thread, with a progress bar; gives what they came to in the order of
/// the jobs. The first failure ends the work after the jobs under way.
pub(crate) fn map<J: Sync, R: Send + Sync>(
    what: &'static str,
    jobs: &[J],
    workers: usize,
    work: impl Fn(&J) -> Outcome<R> + Sync,
) -> Outcome<Vec<R>> {
    let bar = progress::bar(what, jobs.len() as u64);
    let next = AtomicUsize::new(0);
    let done: Vec<OnceLock<Outcome<R>>> = jobs.iter().map(|_| OnceLock::new()).collect();
    std::thread::scope(|scope| {
        for _ in 0..workers.clamp(1, jobs.len().max(1)) {
            scope.spawn(|| {
                let take = || next.fetch_add(1, Ordering::Relaxed);
                while let Some((job, done)) = jobs.iter().zip(&done).nth(take()) {
                    if done.get_or_init(|| work(job)).is_err() {
                        next.store(jobs.len(), Ordering::Relaxed);
                    }
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    let done = done.into_iter().filter_map(OnceLock::into_inner);
    done.collect()
}

#[cfg(test)]
mod tests {
    use ppnpack_cli::failure::Failure;

    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_jobs() {
        let jobs: Vec<usize> = (0..100).collect();
        let doubled = map("Doubling", &jobs, 4, |job| Ok(2 * job)).unwrap();
        let expected: Vec<usize> = jobs.iter().map(|job| 2 * job).collect();
        assert_eq!(doubled, expected);
    }

    #[test]
    fn the_first_failure_is_given() {
        let fail = |job: &usize| match job {
            3 => Err(Failure::input("three")),
            _ => Ok(()),
        };
        let failed = map("Failing", &[1, 2, 3, 4], 1, fail).unwrap_err();
        assert_eq!(failed.to_string(), "three");
    }
}
