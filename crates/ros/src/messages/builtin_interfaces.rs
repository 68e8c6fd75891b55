//! Times.

use super::messages;

/// Nanoseconds of a second.
const SECOND_NS: i64 = 1_000_000_000;

messages! {
    /// A point in time: since 1970.
    Time = "builtin_interfaces/msg/Time" {
        /// Whole seconds.
        sec: i32,
        /// The rest, in nanoseconds.
        nanosec: u32,
    }

    /// A span of time.
    Duration = "builtin_interfaces/msg/Duration" {
        /// Whole seconds.
        sec: i32,
        /// The rest, in nanoseconds.
        nanosec: u32,
    }
}

impl Time {
    /// The time so many nanoseconds after 1970; what it cannot tell is moved to where it can.
    pub fn from_ns(at_ns: i64) -> Self {
        let seconds = at_ns.div_euclid(SECOND_NS);
        let sec = seconds.clamp(i32::MIN.into(), i32::MAX.into());
        Self {
            sec: i32::try_from(sec).unwrap_or_default(),
            nanosec: u32::try_from(at_ns.rem_euclid(SECOND_NS)).unwrap_or_default(),
        }
    }

    /// In nanoseconds since 1970.
    pub fn to_ns(&self) -> i64 {
        i64::from(self.sec) * SECOND_NS + i64::from(self.nanosec)
    }

    /// The time of day.
    pub fn now() -> Self {
        Self::from_ns(crate::attachment::now_ns())
    }
}
