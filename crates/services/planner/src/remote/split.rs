//! How the work of a step is split over replicas: by yaw, and by item where there are more replicas than yaws.

use ppnpack_packing::placement::Placement;
use ppnpack_packing::proposals::{CandidateProposals, Proposals, YawRange};
use ppnpack_packing::step::Candidate;

/// What is searched of one candidate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    /// Index into the input's candidates.
    pub(crate) candidate: usize,
    pub(crate) yaws: YawRange,
    /// The proposed placements, all of these yaws; `None` for every one.
    pub(crate) proposals: Option<Vec<Placement>>,
}

/// The parts of a group of candidates, one each.
pub(crate) fn parts(group: &[usize], candidates: &[Candidate], proposals: &Proposals) -> Vec<Part> {
    let part = |candidate: &usize| {
        let item = &candidates.get(*candidate)?.item;
        let (yaws, proposals) = match proposals.of(*candidate) {
            CandidateProposals::All => (YawRange::all(item), None),
            CandidateProposals::AllAt(yaws) => (yaws, None),
            CandidateProposals::Some(placements) => {
                (YawRange::all(item), Some(placements.to_vec()))
            }
        };
        Some(Part {
            candidate: *candidate,
            yaws,
            proposals,
        })
    };
    group.iter().filter_map(part).collect()
}

/// Splits parts over `replicas`, each with at most one part of a candidate. The same yaws go to the same replica from
/// step to step, which has their resting heights from the step before.
pub(crate) fn split(parts: &[Part], candidates: &[Candidate], replicas: usize) -> Vec<Vec<Part>> {
    let ends = parts.iter().map(|part| part.yaws.end);
    let yaws = ends.max().unwrap_or(1).max(1);
    let slots = replicas.clamp(1, yaws);
    let groups = (replicas / slots).max(1);
    let mut shares = vec![Vec::new(); replicas.max(1)];
    for part in parts {
        let held = candidates.get(part.candidate);
        let arrival = held.map_or(0, |held| held.arrival);
        for slot in 0..slots {
            let range = YawRange {
                first: (yaws * slot / slots).max(part.yaws.first),
                end: (yaws * (slot + 1) / slots).min(part.yaws.end),
            };
            if range.first >= range.end {
                continue;
            }
            let replica = slot + slots * (arrival % groups);
            if let Some(share) = shares.get_mut(replica) {
                share.extend(restricted(part, range));
            }
        }
    }
    shares
}

/// A part at some of its yaws; `None` where nothing is proposed there.
fn restricted(part: &Part, yaws: YawRange) -> Option<Part> {
    let proposals = part.proposals.as_ref().map(|placements| {
        let here = placements.iter().filter(|at| yaws.contains(at.yaw));
        here.copied().collect::<Vec<_>>()
    });
    if proposals.as_ref().is_some_and(Vec::is_empty) {
        return None;
    }
    Some(Part {
        candidate: part.candidate,
        yaws,
        proposals,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(candidate: usize, yaws: usize, proposals: Option<Vec<Placement>>) -> Part {
        Part {
            candidate,
            yaws: YawRange {
                first: 0,
                end: yaws,
            },
            proposals,
        }
    }

    fn covered(shares: &[Vec<Part>], candidate: usize) -> Vec<usize> {
        let parts = shares.iter().flatten();
        let parts = parts.filter(|part| part.candidate == candidate);
        let yaws = parts.flat_map(|part| part.yaws.first..part.yaws.end);
        let mut yaws: Vec<usize> = yaws.collect();
        yaws.sort_unstable();
        yaws
    }

    #[test]
    fn every_yaw_of_every_candidate_is_searched_once_by_any_number_of_replicas() {
        for replicas in 1..12 {
            let parts = [part(0, 4, None), part(1, 4, None), part(2, 4, None)];
            let shares = split(&parts, &[], replicas);
            assert_eq!(shares.len(), replicas);
            for candidate in 0..3 {
                assert_eq!(
                    covered(&shares, candidate),
                    [0, 1, 2, 3],
                    "{replicas} replicas"
                );
            }
        }
    }

    #[test]
    fn proposals_go_with_their_yaw() {
        let at = |yaw| Placement { yaw, x: 1, y: 2 };
        let parts = [part(0, 4, Some(vec![at(3), at(0), at(3)]))];
        let shares = split(&parts, &[], 2);
        assert_eq!(shares[0][0].proposals, Some(vec![at(0)]));
        assert_eq!(shares[1][0].proposals, Some(vec![at(3), at(3)]));
    }
}
