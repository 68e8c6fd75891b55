//! How topics are carried.

use std::fmt;

/// How many messages a depth says that goes without saying: `RMW_ZENOH_DEFAULT_HISTORY_DEPTH`.
const DEFAULT_DEPTH: u32 = 42;

/// How a topic is carried. Zenoh matches publishers and subscribers of any quality: it tells others what to expect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// Whether every message is wanted; otherwise late ones are not.
    pub is_reliable: bool,
    /// Whether who comes later is given the last message: "transient local".
    pub is_latched: bool,
    /// How many messages wait for a slow reader.
    pub depth: u32,
}

impl Qos {
    /// What sensors see.
    pub const SENSOR: Self = Self {
        is_reliable: false,
        is_latched: false,
        depth: 5,
    };

    /// What happens, and services.
    pub const EVENTS: Self = Self {
        is_reliable: true,
        is_latched: false,
        depth: 10,
    };

    /// What is so until it is said otherwise.
    pub const LATCHED: Self = Self {
        is_reliable: true,
        is_latched: true,
        depth: 1,
    };
}

/// As it stands in tokens: what is as by default is left out.
impl fmt::Display for Qos {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reliability = if self.is_reliable { "" } else { "2" };
        let durability = if self.is_latched { "1" } else { "" };
        write!(formatter, "{reliability}:{durability}:,")?;
        if self.depth != DEFAULT_DEPTH {
            write!(formatter, "{}", self.depth)?;
        }
        // No deadline, no lifespan, automatic liveliness without a lease.
        formatter.write_str(":,:,:,,")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn qualities_are_written_as_others_write_them() {
        assert_eq!(Qos::EVENTS.to_string(), "::,10:,:,:,,");
        assert_eq!(Qos::LATCHED.to_string(), ":1:,1:,:,:,,");
        assert_eq!(Qos::SENSOR.to_string(), "2::,5:,:,:,,");
        let usual = Qos {
            depth: DEFAULT_DEPTH,
            ..Qos::EVENTS
        };
        assert_eq!(usual.to_string(), "::,:,:,:,,");
    }
}
