//! Small worlds, in which everything is gone through that can happen.

use std::time::Duration;

use ppnpack_protocol_tests::Configuration;
use ppnpack_protocol_tests::configuration::Fault;
use ppnpack_protocol_tests::exhaust::exhaust;
use ppnpack_protocol_tests::shrink::{shrink, tell, written};

fn check(configuration: &Configuration) {
    let found = exhaust(configuration, Duration::from_secs(600), 2);
    println!(
        "{}: {} worlds, {} steps, {} deep",
        configuration.name, found.worlds, found.steps, found.depth
    );
    if let Some(story) = &found.broken {
        let story = shrink(story, configuration);
        let end = tell(&story, configuration).and_then(|world| world.broken());
        panic!("{end:?} after {}", written(&story));
    }
    assert!(found.is_complete && found.packs);
}

#[test]
fn nothing_fails() {
    check(&Configuration::automatic("quiet"));
}

#[test]
fn kills_and_late_requests() {
    let world = Configuration::automatic("kills")
        .with(Fault::KillBridge, 1)
        .with(Fault::KillPlanner, 1)
        .with(Fault::TimeOut, 1);
    check(&world);
}

#[test]
fn holds() {
    let world = Configuration::automatic("holds")
        .with(Fault::Hold, 1)
        .with(Fault::Hand, 1)
        .with(Fault::TimeOut, 1);
    check(&world);
}

#[test]
fn kills_and_holds() {
    let world = Configuration::automatic("kills and holds")
        .with(Fault::Hold, 1)
        .with(Fault::Hand, 1)
        .with(Fault::KillBridge, 1)
        .with(Fault::TimeOut, 1);
    check(&world);
}

#[test]
fn lost_disks() {
    let world = Configuration::automatic("lost disks")
        .with(Fault::KillBridge, 1)
        .with(Fault::KillPlanner, 1)
        .with(Fault::LoseJournal, 1)
        .with(Fault::LoseStore, 1)
        .with(Fault::TimeOut, 1);
    check(&world);
}

#[test]
fn restored() {
    let world = Configuration {
        followed: 64,
        ..Configuration::automatic("restored")
    };
    let world = world
        .with(Fault::KillBridge, 1)
        .with(Fault::KillPlanner, 1)
        .with(Fault::Restore, 1)
        .with(Fault::TimeOut, 1);
    check(&world);
}

#[test]
fn renewed() {
    let world = Configuration::automatic("renewed")
        .with(Fault::KillBridge, 1)
        .with(Fault::Renew, 1)
        .with(Fault::TimeOut, 1);
    check(&world);
}

#[test]
fn failing_robot() {
    let world = Configuration {
        may_fail: true,
        ..Configuration::automatic("failing")
    };
    check(&world.with(Fault::KillBridge, 1).with(Fault::TimeOut, 1));
}

#[test]
fn controllers() {
    let world = Configuration {
        controllers: 2,
        followed: 64,
        ..Configuration::automatic("controllers")
    };
    check(
        &world
            .with(Fault::KillBridge, 1)
            .with(Fault::TimeOut, 1)
            .with(Fault::Hold, 1),
    );
}

#[test]
fn simulated() {
    let world = Configuration {
        is_simulated: true,
        ..Configuration::automatic("simulated")
    };
    check(
        &world
            .with(Fault::KillBridge, 2)
            .with(Fault::KillPlanner, 1)
            .with(Fault::TimeOut, 1),
    );
}
