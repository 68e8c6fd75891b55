//! Settings of a tray.

use ppnpack_recognition::recognise::RecognitionSettings;
use ppnpack_recognition::segmentation::SegmentationSettings;
use serde::{Deserialize, Serialize};

/// The tray of a cell, or a region of its belt: where items wait, seen by a sensor above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraySettings {
    /// Settings of the segmentation of points into items; the world is the container frame.
    pub segmentation: SegmentationSettings,
    /// Settings of the recognition of items.
    #[serde(default)]
    pub recognition: RecognitionSettings,
}
