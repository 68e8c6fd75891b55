//! Fewer hulls from many. Written here, as parry's decomposition takes a number of hulls but does
//! not keep to it.

use crate::hull::hull;
use crate::mesh::Mesh;

/// The most pieces of an object.
pub const MAX_PIECES: usize = 8;

/// How far hulls are merged though there is room for more, in cubic metres.
pub(super) struct MergeLimits {
    /// The volume that a merger may add.
    pub(super) added_m3: f64,
    /// The volume that all hulls together may have after a merger that adds more.
    pub(super) total_m3: f64,
}

/// Merges hulls until [`MAX_PIECES`] are left and a further merger would exceed both limits.
pub(super) fn merged(hulls: Vec<Mesh>, limits: &MergeLimits) -> Vec<Mesh> {
    struct Pair {
        members: [usize; 2],
        joint: Mesh,
        added_m3: f64,
    }
    let pair = |hulls: &[Option<Mesh>], members: [usize; 2]| {
        let [a, b] = members.map(|member| hulls.get(member)?.as_ref());
        let (a, b) = (a?, b?);
        let points: Vec<_> = a.vertices.iter().chain(&b.vertices).copied().collect();
        let joint = hull(&points)?;
        let added_m3 = joint.signed_volume_m3() - a.signed_volume_m3() - b.signed_volume_m3();
        Some(Pair {
            members,
            joint,
            added_m3,
        })
    };
    let mut total_m3: f64 = hulls.iter().map(Mesh::signed_volume_m3).sum();
    // A merged hull is appended; those it was made from leave gaps.
    let mut hulls: Vec<Option<Mesh>> = hulls.into_iter().map(Some).collect();
    let mut pairs: Vec<Pair> = (0..hulls.len())
        .flat_map(|second| (0..second).map(move |first| [first, second]))
        .filter_map(|members| pair(&hulls, members))
        .collect();
    loop {
        let best = pairs
            .iter()
            .enumerate()
            .min_by(|(_, a), (_, b)| a.added_m3.total_cmp(&b.added_m3))
            .map(|(index, best)| (index, best.added_m3));
        let Some((index, added_m3)) = best else { break };
        let much = added_m3 >= limits.added_m3 && total_m3 + added_m3 >= limits.total_m3;
        if hulls.iter().flatten().count() <= MAX_PIECES && much {
            break;
        }
        total_m3 += added_m3;
        let Pair { members, joint, .. } = pairs.swap_remove(index);
        pairs.retain(|pair| !pair.members.iter().any(|member| members.contains(member)));
        for member in members {
            if let Some(hull) = hulls.get_mut(member) {
                *hull = None;
            }
        }
        let last = hulls.len();
        hulls.push(Some(joint));
        pairs.extend((0..last).filter_map(|other| pair(&hulls, [other, last])));
    }
    let mut left: Vec<Mesh> = hulls.into_iter().flatten().collect();
    // Pairs without a joint hull cannot be merged; the largest pieces matter most.
    left.sort_by(|a, b| b.signed_volume_m3().total_cmp(&a.signed_volume_m3()));
    left.truncate(MAX_PIECES);
    left
}
