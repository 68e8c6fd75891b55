//! Fewer hulls from many. Written here, as parry's decomposition takes a number of hulls but does not keep to it.

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
pub(super) fn merged(mut hulls: Vec<Mesh>, limits: &MergeLimits) -> Vec<Mesh> {
    struct Pair {
        first: usize,
        second: usize,
        joint: Mesh,
        added_m3: f64,
    }
    let pair = |hulls: &[Mesh], first: usize, second: usize| {
        let (a, b) = (hulls.get(first)?, hulls.get(second)?);
        let points: Vec<_> = a.vertices.iter().chain(&b.vertices).copied().collect();
        let joint = hull(&points)?;
        let added_m3 = joint.signed_volume_m3() - a.signed_volume_m3() - b.signed_volume_m3();
        Some(Pair {
            first,
            second,
            joint,
            added_m3,
        })
    };
    let all = 0..hulls.len();
    let mut pairs: Vec<Pair> = all
        .clone()
        .flat_map(|second| (0..second).map(move |first| (first, second)))
        .filter_map(|(first, second)| pair(&hulls, first, second))
        .collect();
    // A merged hull is appended; those it was made from stay in their place, without any pair.
    let mut alive = vec![true; hulls.len()];
    let mut total_m3: f64 = hulls.iter().map(Mesh::signed_volume_m3).sum();
    loop {
        let left = alive.iter().filter(|alive| **alive).count();
        let best = pairs
            .iter()
            .enumerate()
            .min_by(|(_, a), (_, b)| a.added_m3.total_cmp(&b.added_m3))
            .map(|(index, best)| (index, best.added_m3));
        let Some((index, added_m3)) = best else { break };
        let much = added_m3 >= limits.added_m3 && total_m3 + added_m3 >= limits.total_m3;
        if left <= MAX_PIECES && much {
            break;
        }
        total_m3 += added_m3;
        let Pair {
            first,
            second,
            joint,
            ..
        } = pairs.swap_remove(index);
        pairs.retain(|pair| {
            ![pair.first, pair.second]
                .iter()
                .any(|member| [first, second].contains(member))
        });
        for gone in [first, second] {
            if let Some(alive) = alive.get_mut(gone) {
                *alive = false;
            }
        }
        hulls.push(joint);
        alive.push(true);
        let last = hulls.len() - 1;
        let others = (0..last).filter(|other| alive.get(*other) == Some(&true));
        pairs.extend(others.filter_map(|other| pair(&hulls, other, last)));
    }
    let mut left: Vec<Mesh> = hulls
        .into_iter()
        .zip(alive)
        .filter_map(|(hull, alive)| alive.then_some(hull))
        .collect();
    // Pairs without a joint hull cannot be merged; the largest pieces matter most.
    left.sort_by(|a, b| b.signed_volume_m3().total_cmp(&a.signed_volume_m3()));
    left.truncate(MAX_PIECES);
    left
}
