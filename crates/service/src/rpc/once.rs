//! Requests that must not happen twice.

use std::collections::VecDeque;

const KEPT: usize = 256;

/// The idempotency keys of the last requests that were carried out, which are their ids.
#[derive(Debug, Default)]
pub struct Once(VecDeque<String>);

impl Once {
    /// Says whether a request of this id was carried out. One without an id never was.
    pub fn has(&self, request_id: &str) -> bool {
        self.0.iter().any(|own| own == request_id)
    }

    /// Remembers a request that was carried out.
    pub fn add(&mut self, request_id: &str) {
        if request_id.is_empty() {
            return;
        }
        if self.0.len() >= KEPT {
            self.0.pop_front();
        }
        self.0.push_back(request_id.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_remembered_as_long_as_there_is_room() {
        let mut once = Once::default();
        for id in ["a", ""] {
            assert!(!once.has(id));
            once.add(id);
        }
        assert!(once.has("a") && !once.has(""));
        (1..KEPT).for_each(|number| once.add(&number.to_string()));
        assert!(once.has("a"));
        once.add("b");
        assert!(once.has("b") && !once.has("a"));
    }
}
