//! Recording an episode.

use ppnpack_packing::ranking::step::{StageError, StepInput};
use ppnpack_packing::streams::episode::{Observer, Step};

use crate::expert::Expert;
use crate::record::{SequenceRecord, StepRecord};

/// Watches an episode and records every step with the expert's labels.
pub struct Recorder {
    expert: Expert,
    objects: Vec<u32>,
    recorded: SequenceRecord,
    error: Option<StageError>,
}

impl Recorder {
    /// Records sequence number `sequence`, whose arrivals are these objects.
    pub fn new(expert: Expert, sequence: u32, objects: Vec<u32>) -> Self {
        Self {
            expert,
            objects,
            recorded: SequenceRecord {
                sequence,
                steps: Vec::new(),
            },
            error: None,
        }
    }

    /// Gives the record.
    ///
    /// # Errors
    /// [`StageError`] that kept a step from being labelled.
    pub fn finish(self) -> Result<SequenceRecord, StageError> {
        self.error.map_or(Ok(self.recorded), Err)
    }

    fn record(&mut self, input: &StepInput<'_>) -> Result<StepRecord, StageError> {
        let mut candidates = Vec::with_capacity(input.candidates.len());
        for (index, held) in input.candidates.iter().enumerate() {
            if held.pose > 0 {
                return Err("objects are recorded in one pose each".into());
            }
            let object = self.objects.get(held.arrival).copied();
            let object = object.ok_or_else(|| format!("there is no arrival {}", held.arrival))?;
            candidates.push(self.expert.label(input, index, object)?);
        }
        Ok(StepRecord {
            sequence: self.recorded.sequence,
            step: u32::try_from(input.step)?,
            heightmap: input.scene.heightmap().heights().to_vec(),
            candidates,
        })
    }
}

impl Observer for Recorder {
    fn on_step(&mut self, _step: &Step, input: &StepInput<'_>) {
        if self.error.is_some() {
            return;
        }
        match self.record(input) {
            Ok(step) => self.recorded.steps.push(step),
            Err(error) => self.error = Some(error),
        }
    }
}
