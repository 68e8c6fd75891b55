//! `unique_identifier_msgs`.

use super::messages;

messages! {
    /// A name that nobody else has.
    Uuid = "unique_identifier_msgs/msg/UUID" {
        /// Its bytes.
        uuid: [u8; 16],
    }
}

impl std::fmt::Display for Uuid {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.uuid
            .iter()
            .try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}
