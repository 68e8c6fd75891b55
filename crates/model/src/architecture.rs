//! Architectures of networks.

use serde::{Deserialize, Serialize};

/// A way to bring the features of the container and of an item together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fusion {
    /// Per channel, the item's features are correlated with the container's: the kernel moves as
    /// the item would.
    #[default]
    Correlation,
    /// The item's features lie beside the container's, centred.
    Concatenation,
}

/// The architecture of a placement proposal network.
///
/// Two encoders with one block per entry of `widths` (two 3 x 3 convolutions and a 2 x 2 maximum
/// pool), a fusion of their features at each resolution, and a decoder back to the container's
/// resolution.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Architecture {
    /// Channels of the encoder blocks, from the finest; their number is the depth.
    pub widths: Vec<usize>,
    /// Channels at the container's resolution, before the score.
    pub head: usize,
    /// The way in which the two encoders' features meet.
    pub fusion: Fusion,
    /// Whether the exact resting heights, a correlation of the two heightmaps in (max, +), are an
    /// input to the head.
    pub resting_heights: bool,
}

impl Default for Architecture {
    /// The architecture that ships: narrow enough for one core.
    fn default() -> Self {
        Self {
            widths: vec![8, 16, 16, 16],
            head: 8,
            fusion: Fusion::Correlation,
            resting_heights: true,
        }
    }
}

/// An architecture that cannot be built.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ArchitectureError {
    /// The number of blocks is out of range.
    #[error("a network has 1 to {MAX_DEPTH} blocks, but {0} widths are given")]
    Depth(usize),
    /// A number of channels is out of range.
    #[error("a network's layers have 1 to {MAX_WIDTH} channels, but {0} are asked for")]
    Width(usize),
}

/// Maximum number of blocks: each halves the resolution.
pub const MAX_DEPTH: usize = 6;
/// Maximum number of channels of a layer.
pub const MAX_WIDTH: usize = 1024;

impl Architecture {
    /// Gives the cells that every map's sides are a multiple of: each block halves the resolution.
    pub fn stride(&self) -> usize {
        1 << self.widths.len().clamp(1, MAX_DEPTH)
    }

    /// Checks that the network can be built.
    pub fn validate(&self) -> Result<(), ArchitectureError> {
        if self.widths.is_empty() || self.widths.len() > MAX_DEPTH {
            return Err(ArchitectureError::Depth(self.widths.len()));
        }
        let wrong = |width: &&usize| **width == 0 || **width > MAX_WIDTH;
        match self.widths.iter().chain([&self.head]).find(wrong) {
            Some(width) => Err(ArchitectureError::Width(*width)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_architectures_are_refused() {
        let with = |widths: &[usize], head| {
            let architecture = Architecture {
                widths: widths.to_vec(),
                head,
                ..Architecture::default()
            };
            architecture.validate()
        };
        assert_eq!(with(&[], 8), Err(ArchitectureError::Depth(0)));
        assert_eq!(with(&[8; 7], 8), Err(ArchitectureError::Depth(7)));
        assert_eq!(with(&[8, 0], 8), Err(ArchitectureError::Width(0)));
        assert_eq!(with(&[8], 2000), Err(ArchitectureError::Width(2000)));
        assert_eq!(with(&[8, 8], 8), Ok(()));
    }
}
