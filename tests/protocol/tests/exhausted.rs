//! Small worlds, in which everything is gone through that can happen; and the same without one of
//! the safeguards, which is missed.
#![cfg(test)]

use std::time::Duration;

use ppnpack_protocol_tests::configuration::{Configuration, Fault, Sabotage};
use ppnpack_protocol_tests::exhaust::exhaust;
use ppnpack_protocol_tests::wander::{end_of, shrink, wander};
use ppnpack_protocol_tests::{Action, Broken};

/// Longer than any of them takes; it is here so that one that grows is noticed.
const LIMIT: Duration = Duration::from_secs(300);

/// How a story ends, and the story, as short as it can be.
fn told(story: &[Action], configuration: &Configuration) -> (Option<Broken>, String) {
    let story = shrink(story, configuration);
    (end_of(&story, configuration), format!("{story:?}"))
}

/// Goes through a small world, in which every promise is kept. It has at least so many states:
/// fewer would be a model from which something fell out.
fn exhausted(name: &str, least: usize) {
    let small = Configuration::small();
    let configuration = small.iter().find(|world| world.name == name).unwrap();
    let found = exhaust(configuration, LIMIT);
    if let Some(story) = &found.broken {
        let (end, story) = told(story, configuration);
        panic!("{end:?} after {story}");
    }
    println!("{name}: {found:?}");
    assert!(found.is_complete && found.packs, "{found:?}");
    assert!(found.worlds >= least, "{found:?}");
}

/// Makes a test of each small world.
macro_rules! worlds {
    ($($test:ident: $world:literal, $least:literal;)*) => {
        $(#[test] fn $test() { exhausted($world, $least); })*
    };
}

worlds! {
    where_nothing_fails_everything_is_packed: "nothing fails", 40;
    kills_and_late_requests_break_nothing: "kills", 10_000;
    holds_and_hands_break_nothing: "holds", 20_000;
    two_people_who_hold_and_resume_break_nothing: "two people", 25_000;
    two_people_who_acknowledge_break_nothing: "two people and a robot that fails", 700;
    a_lost_journal_of_a_held_cell_breaks_nothing: "a held cell whose journal is lost", 25_000;
    kills_of_held_cells_break_nothing: "kills and holds", 15_000;
    lost_disks_break_nothing: "lost disks", 13_000;
    backups_that_are_put_back_break_nothing: "backups", 60_000;
    a_new_container_after_a_backup_was_put_back_breaks_nothing: "a backup, then a new container", 35_000;
    renewals_break_nothing: "renewals", 80_000;
    a_robot_that_fails_breaks_nothing: "a robot that fails", 6_000;
    two_controllers_break_nothing: "two controllers", 250_000;
}

/// What breaks in this world without this safeguard.
fn broken_without(sabotage: Sabotage, world: Configuration) -> Broken {
    let configuration = world.without(sabotage);
    let found = exhaust(&configuration, LIMIT);
    let story = found
        .broken
        .unwrap_or_else(|| panic!("{sabotage:?} is not missed"));
    told(&story, &configuration).0.unwrap()
}

#[test]
fn each_safeguard_is_missed_where_it_is_taken_out() {
    use Fault::*;
    use Sabotage::*;
    let world = || Configuration::automatic("sabotaged");
    let held = || world().with(&[(Hold, 1), (TimeOut, 1)]);
    let killed = || world().with(&[(KillBridge, 1), (TimeOut, 1)]);
    // Of three items two are lost, and the third one is decided on.
    let failing = Configuration {
        items: 3,
        ..world().failing()
    };
    let restarted = || killed().with(&[(KillPlanner, 1)]);
    for (sabotage, world) in [
        (AnyState, held()),
        (BeginsWhileHeld, held()),
        (SameStateAfterHold, held()),
        (NothingIsVoided, restarted().with(&[(LoseStore, 1)])),
        (KnowsAll, killed().with(&[(LoseJournal, 1)])),
        (CutOffIsNotPlaced, killed()),
        (AnyResume, held().with(&[(Hold, 2)])),
        (FirstHoldStays, held().by_people(2).with(&[(Hold, 2)])),
        (
            BeginsWithoutPast,
            killed().with(&[(Hold, 1), (LoseJournal, 1)]),
        ),
        (AnyFailure, failing),
        (RestoredGoesOn, restarted().with(&[(Restore, 1)])),
        (NeverStarts, killed()),
    ] {
        let broken = broken_without(sabotage, world);
        let expected: &[Broken] = match sabotage {
            BeginsWhileHeld | AnyResume | FirstHoldStays | BeginsWithoutPast => {
                &[Broken::BegunWhileHeld]
            }
            AnyFailure => &[Broken::NobodyLooked],
            NeverStarts => &[Broken::Stuck],
            _ => &[
                Broken::ItemPlacedTwice,
                Broken::WasPlaced,
                Broken::BegunAfterItWasSettled,
            ],
        };
        assert!(expected.contains(&broken), "{sabotage:?}: {broken:?}");
    }
}

/// `PPNPACK_WAYS` has it go other than 1,500 ways through each.
#[test]
fn random_ways_through_large_worlds_break_nothing() {
    let ways = std::env::var("PPNPACK_WAYS").map_or(1_500, |ways| ways.parse().unwrap());
    for configuration in Configuration::large() {
        let mut packed = 0;
        for seed in 0..ways {
            let way = wander(&configuration, seed, 400);
            if let Some(broken) = way.broken {
                let (_, story) = told(&way.story, &configuration);
                panic!(
                    "{}, seed {seed}: {broken:?} after {story}",
                    configuration.name
                );
            }
            packed += usize::from(way.packs);
        }
        let name = configuration.name;
        println!("{name}: all packed at the end of {packed} of {ways} ways");
        assert!(packed > 0, "{name}: nothing was ever packed");
    }
}
