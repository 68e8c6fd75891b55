//! In which resting poses an item may be packed, by what its announcement says of that.

use ppnpack_wire::v1;

/// The resting poses that an announcement can allow.
pub(super) struct PossiblePoses {
    /// How many may be used.
    pub(super) most: usize,
    /// Why no more may be used.
    pub(super) because: &'static str,
    /// How many the item has.
    pub(super) known: usize,
}

impl PossiblePoses {
    /// In how many poses an item may be packed at most, and the numbers of those in which alone, in order, where they are named.
    pub(super) fn read(&self, item: &v1::Announcement) -> Result<(usize, Vec<usize>), String> {
        match (item.poses, item.allowed_poses.as_slice()) {
            (poses, []) => Ok((self.count(poses)?, Vec::new())),
            (0, allowed) => Ok((1, self.numbers(allowed)?)),
            _ => Err("poses and allowed_poses: give one of them".to_owned()),
        }
    }

    /// 0: as many as may be used.
    fn count(&self, poses: u32) -> Result<usize, String> {
        let Self { most, because, .. } = self;
        match usize::try_from(poses).unwrap_or(usize::MAX) {
            0 => Ok(*most),
            poses if poses <= *most => Ok(poses),
            poses => Err(format!(
                "poses: {poses} where {most} is possible: {because}"
            )),
        }
    }

    fn numbers(&self, allowed: &[u32]) -> Result<Vec<usize>, String> {
        let mut numbers = Vec::new();
        for number in allowed {
            let number = usize::try_from(*number).unwrap_or(usize::MAX);
            if numbers.contains(&number) {
                return Err(format!("allowed_poses: {number} is there twice"));
            }
            self.check(number)?;
            numbers.push(number);
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    fn check(&self, number: usize) -> Result<(), String> {
        let Self {
            most,
            because,
            known,
        } = self;
        if number >= *most {
            let last = most.saturating_sub(1);
            return Err(format!(
                "allowed_poses: {number} where {last} is the last: {because}"
            ));
        }
        if number >= *known {
            let last = known.saturating_sub(1);
            return Err(format!(
                "allowed_poses: {number} where {last} is the last that it has"
            ));
        }
        Ok(())
    }
}
