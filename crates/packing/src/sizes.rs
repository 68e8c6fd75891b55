//! Which size a container is that is opened next, where there are several: by what waits for it.

use crate::candidate::Candidate;
use crate::closing::Fill;
use crate::grid::Grid;

/// The volume of an empty container, in cubic metres.
fn volume_m3(grid: &Grid) -> f64 {
    Fill::of(0.0, grid.container()).container_m3
}

/// Whether an item may lie at all in an empty container, by its extents in this pose, at some yaw.
pub fn takes(grid: &Grid, held: &Candidate) -> bool {
    let (nx, ny) = (grid.nx(), grid.ny());
    let mut views = held.item.views().iter();
    views.any(|view| view.nx() <= nx && view.ny() <= ny && view.fits_at(grid, 0))
}

/// The size to open for what waits, by its place among these: the smallest in which so much volume is expected to fit, where containers
/// come to be filled to `expected_percent`, otherwise the largest. Only those are asked that take every item that waits, in one of its
/// poses, but for items that none takes; where there is none that does, it is the largest of all. `None` without any size.
pub fn size_to_open(
    sizes: &[Grid],
    waiting: &[Candidate],
    waiting_m3: f64,
    expected_percent: f64,
) -> Option<usize> {
    let takes_item = |grid: &Grid, arrival: usize| {
        let mut poses = waiting.iter().filter(|held| held.arrival == arrival);
        poses.any(|held| takes(grid, held))
    };
    let counts = |held: &&Candidate| sizes.iter().any(|grid| takes_item(grid, held.arrival));
    let takes_all = |grid: &Grid| {
        let mut items = waiting.iter().filter(counts);
        items.all(|held| takes_item(grid, held.arrival))
    };
    let holds_m3 = |grid: &Grid| volume_m3(grid) * expected_percent / 100.0;
    let by_volume = |(_, a): &(usize, &Grid), (_, b): &(usize, &Grid)| {
        // Of equal ones the first is both the smallest and the largest.
        volume_m3(a).total_cmp(&volume_m3(b))
    };
    let all = || sizes.iter().enumerate();
    let able = || all().filter(|(_, grid)| takes_all(grid));
    let enough = able().filter(|(_, grid)| holds_m3(grid) >= waiting_m3);
    let smallest = enough.min_by(by_volume);
    let largest = || able().rev().max_by(by_volume);
    let any = || all().rev().max_by(by_volume);
    let (at, _) = smallest.or_else(largest).or_else(any)?;
    Some(at)
}
