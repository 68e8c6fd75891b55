//! The search in this process: all of it, or by parts where time is short.

use ppnpack_packing::proposals::Proposals;
use ppnpack_packing::step::{StageError, StepInput};
use ppnpack_packing::valid::{BestValid, ValidSearch};

use super::merge::merge;
use super::split::Part;

/// Searches parts of a step.
pub(crate) struct LocalSearch(ValidSearch);

impl LocalSearch {
    pub(crate) fn new(search: ValidSearch) -> Self {
        Self(search)
    }

    /// The best `limit` placements of all parts.
    pub(crate) fn all(
        &mut self,
        input: &StepInput<'_>,
        parts: &[Part],
        limit: usize,
    ) -> Result<BestValid, StageError> {
        let mut proposals = Proposals::default();
        for candidate in 0..input.candidates.len() {
            match parts.iter().find(|part| part.candidate == candidate) {
                None => proposals.push([]),
                Some(part) => match &part.proposals {
                    None => proposals.push_all_at(part.yaws),
                    Some(placements) => proposals.push(placements.iter().copied()),
                },
            }
        }
        let group: Vec<usize> = parts.iter().map(|part| part.candidate).collect();
        Ok(self.0.best(input, &group, &proposals, limit)?)
    }

    /// The same, one part after the other until it is late: the best of the first parts, and how many these are.
    pub(crate) fn until(
        &mut self,
        input: &StepInput<'_>,
        parts: &[Part],
        limit: usize,
        is_late: &mut dyn FnMut() -> bool,
    ) -> Result<(BestValid, usize), StageError> {
        let mut found = Vec::with_capacity(parts.len());
        for part in parts {
            if is_late() {
                break;
            }
            found.push(self.all(input, std::slice::from_ref(part), limit)?);
        }
        let searched = found.len();
        let mut best = merge(found, limit);
        best.is_complete &= searched == parts.len();
        Ok((best, searched))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use ppnpack_packing::grid::Grid;
    use ppnpack_packing::heightmap::{Heightmap, Scene};
    use ppnpack_packing::item::{Item, ViewSurfaces};
    use ppnpack_packing::proposals::YawRange;
    use ppnpack_packing::search::SearchSettings;
    use ppnpack_packing::step::Candidate;

    use super::*;

    fn block(cells: usize, height: i16) -> Arc<Item> {
        let view = ViewSurfaces {
            nx: cells,
            ny: cells,
            top: vec![height; cells * cells],
            bottom: vec![0; cells * cells],
            underside: None,
            origin_from_corner_m: nalgebra::Vector3::zeros(),
            centre_of_mass_m: None,
        };
        Arc::new(Item::new("block", vec![view; 4], 0.0).unwrap())
    }

    #[test]
    fn part_after_part_finds_what_one_search_finds_and_stops_when_it_is_late() {
        let grid = Grid::reference();
        let scene = Scene::from_heightmap(Heightmap::empty(&grid));
        let items = [block(3, 10), block(5, 20), block(8, 7)];
        let candidates: Vec<Candidate> = (0..)
            .zip(items)
            .map(|(arrival, item)| Candidate { arrival, item })
            .collect();
        let input = StepInput {
            grid: &grid,
            scene: &scene,
            candidates: &candidates,
            step: 0,
        };
        let part = |candidate: usize| Part {
            candidate,
            yaws: YawRange { first: 0, end: 4 },
            proposals: None,
        };
        let parts = [part(0), part(1), part(2)];
        let search = ValidSearch::new(&grid, &SearchSettings::default(), Vec::new()).unwrap();
        let mut local = LocalSearch::new(search);
        let whole = local.all(&input, &parts, 50).unwrap();
        let (by_parts, searched) = local.until(&input, &parts, 50, &mut || false).unwrap();
        assert_eq!(searched, 3);
        assert_eq!(by_parts.placements, whole.placements);
        assert_eq!(by_parts.is_complete, whole.is_complete);
        let possible = |best: &BestValid| {
            let counts = best.tallies.iter().map(|tally| tally.counts.possible);
            counts.collect::<Vec<_>>()
        };
        assert_eq!(possible(&by_parts), possible(&whole));

        let mut looks = 0;
        let mut is_late = || {
            looks += 1;
            looks > 2
        };
        let (cut, searched) = local.until(&input, &parts, 50, &mut is_late).unwrap();
        let first_two = local.all(&input, &parts[..2], 50).unwrap();
        assert_eq!((cut.placements, searched), (first_two.placements, 2));
        assert!(!cut.is_complete);
    }
}
