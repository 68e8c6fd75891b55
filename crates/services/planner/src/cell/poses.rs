//! Resting poses in which an item may be packed, by its announcement.

use ppnpack_wire::v1;

/// The resting poses that an announcement can allow.
pub(super) struct PossiblePoses {
    /// The number of those that may be used.
    pub(super) most: u32,
    /// Why no more may be used.
    pub(super) because: &'static str,
    /// The number of those that the item has.
    pub(super) known: u32,
}

impl PossiblePoses {
    /// Reads in how many poses an item may be packed at most, 0 for one; and the numbers of the
    /// only allowed ones in order, where they are named.
    pub(super) fn read(&self, item: &v1::Announcement) -> Result<(u32, Vec<u32>), String> {
        let Self {
            most,
            because,
            known,
        } = *self;
        let mut allowed = item.allowed_poses.clone();
        allowed.sort_unstable();
        let Some(last) = allowed.last() else {
            // 0: as many as may be used.
            return match item.poses {
                0 if most > 1 => Ok((most, allowed)),
                0 | 1 => Ok((0, allowed)),
                poses if poses <= most => Ok((poses, allowed)),
                poses => Err(format!(
                    "poses: {poses} where {most} is possible: {because}"
                )),
            };
        };
        if item.poses > 0 {
            return Err("poses and allowed_poses: give one of them".to_owned());
        }
        let mut pairs = allowed.iter().zip(allowed.iter().skip(1));
        if let Some((twice, _)) = pairs.find(|(one, next)| one == next) {
            return Err(format!("allowed_poses: {twice} is there twice"));
        }
        let (end, why) = match most <= known {
            true => (most, format!(": {because}")),
            false => (known, " that it has".to_owned()),
        };
        match *last < end {
            true => Ok((0, allowed)),
            false => Err(format!(
                "allowed_poses: {last} where {} is the last{why}",
                end.saturating_sub(1)
            )),
        }
    }
}
