//! What can be set of a tray.

use ppnpack_recognition::recognise::RecognitionSettings;
use ppnpack_recognition::segmentation::SegmentationSettings;
use serde::{Deserialize, Serialize};

/// The tray of a cell, or a region of its belt: where items wait, seen by a sensor above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraySettings {
    /// How points become items; the world is the container frame.
    pub segmentation: SegmentationSettings,
    /// How items are recognised.
    #[serde(default)]
    pub recognition: RecognitionSettings,
}

impl TraySettings {
    pub(crate) fn validate(&self) -> Result<(), String> {
        self.segmentation
            .validate()
            .map_err(|error| format!("segmentation.{error}"))?;
        self.recognition
            .validate()
            .map_err(|error| format!("recognition.{error}"))
    }
}
