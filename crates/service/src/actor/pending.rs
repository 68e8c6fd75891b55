//! Requests that cannot be answered yet.

use std::time::Instant;

use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::Status;

use crate::rpc::Incoming;

/// Pending requests, each with the time by which it has to be answered.
pub struct PendingRequests<T> {
    requests: Vec<(Instant, T)>,
    capacity: usize,
}

impl<T> PendingRequests<T> {
    /// Makes room for so many.
    pub fn new(capacity: usize) -> Self {
        Self {
            requests: Vec::new(),
            capacity,
        }
    }

    /// Keeps a request that has to be answered by then.
    ///
    /// # Errors
    /// The request, where too many are pending already.
    pub fn keep(&mut self, request: T, answer_by: Instant) -> Result<(), T> {
        if self.requests.len() >= self.capacity {
            return Err(request);
        }
        self.requests.push((answer_by, request));
        Ok(())
    }

    /// Takes out those that can be answered now, oldest first.
    pub fn take(&mut self, mut can_be_answered: impl FnMut(&T) -> bool) -> Vec<T> {
        self.extract(|_, request| can_be_answered(request))
    }

    /// Finds the oldest of this kind.
    pub fn find(&mut self, mut is_it: impl FnMut(&T) -> bool) -> Option<&mut T> {
        let mut requests = self.requests.iter_mut().map(|(_, request)| request);
        requests.find(|request| is_it(request))
    }

    /// Takes out the oldest.
    pub fn take_first(&mut self) -> Option<T> {
        let is_there = !self.requests.is_empty();
        is_there.then(|| self.requests.remove(0).1)
    }

    /// Takes out those that have to be answered now.
    pub fn take_expired(&mut self) -> Vec<T> {
        let now = Instant::now();
        self.extract(|by, _| by <= now)
    }

    fn extract(&mut self, mut goes: impl FnMut(Instant, &T) -> bool) -> Vec<T> {
        let requests = &mut self.requests;
        let taken = requests.extract_if(.., |(by, request)| goes(*by, request));
        taken.map(|(_, request)| request).collect()
    }

    /// Gives the time by which the next one has to be answered.
    pub fn next_expiry(&self) -> Option<Instant> {
        self.requests.iter().map(|(by, _)| *by).min()
    }
}

impl<R: Request> PendingRequests<Incoming<R>> {
    /// Keeps a request until [`Incoming::answer_by`]; refuses it with `STATUS_BUSY` where too many
    /// are pending already.
    pub fn keep_or_refuse(&mut self, incoming: Incoming<R>) {
        let answer_by = incoming.answer_by();
        if let Err(incoming) = self.keep(incoming, answer_by) {
            incoming.refuse(Status::Busy, "too many wait already");
        }
    }

    /// Refuses those that have to be answered now with `STATUS_TIMED_OUT`, and says why.
    pub fn refuse_expired(&mut self, why: impl Fn(&Incoming<R>) -> String) {
        for incoming in self.take_expired() {
            let why = why(&incoming);
            incoming.refuse(Status::TimedOut, why);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn requests_wait_until_they_are_answered_or_expire() {
        let mut pending = PendingRequests::new(3);
        assert_eq!(pending.next_expiry(), None);
        let now = Instant::now();
        let later = now + Duration::from_secs(60);
        assert_eq!(pending.keep(1, later), Ok(()));
        assert_eq!(pending.keep(2, now), Ok(()));
        assert_eq!(pending.keep(3, later), Ok(()));
        assert_eq!(pending.keep(4, later), Err(4), "too many");
        assert_eq!(pending.next_expiry(), Some(now));
        assert_eq!(pending.take_expired(), [2]);
        assert_eq!(pending.next_expiry(), Some(later));
        assert!(pending.take_expired().is_empty());
        assert_eq!(pending.keep(5, later), Ok(()));
        assert_eq!(pending.find(|request| *request > 1), Some(&mut 3));
        assert_eq!(pending.take_first(), Some(1));
        assert_eq!(pending.take(|request| request % 2 == 1), [3, 5]);
        assert_eq!(pending.take_first(), None);
    }
}
