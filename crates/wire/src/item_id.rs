//! The ids of items and solids: hashes of their content.

use prost::Message;

use crate::error::WireError;
use crate::v1;

/// The id of an item or a solid: the BLAKE3 hash of its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemId([u8; 32]);

impl ItemId {
    /// Makes the id of an item.
    pub fn of(item: &v1::Item) -> Self {
        Self(*blake3::hash(&item.encode_to_vec()).as_bytes())
    }

    /// Makes the id of a solid.
    pub fn of_solid(solid: &v1::Solid) -> Self {
        Self(*blake3::hash(&solid.encode_to_vec()).as_bytes())
    }

    /// Reads an id from its 32 bytes.
    ///
    /// # Errors
    /// [`WireError::Invalid`] where there are not 32.
    pub fn from_bytes(field: &'static str, bytes: &[u8]) -> Result<Self, WireError> {
        let wrong = |_| format!("{} bytes where 32 are needed", bytes.len());
        let id = bytes.try_into().map(Self).map_err(wrong);
        id.map_err(|reason| WireError::invalid(field, reason))
    }

    /// Gives the 32 bytes.
    pub fn to_bytes(self) -> Vec<u8> {
        self.0.to_vec()
    }
}

impl std::fmt::Display for ItemId {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(blake3::Hash::from(self.0).to_hex().get(..16).unwrap_or(""))
    }
}
