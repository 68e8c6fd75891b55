//! Datasets on disk: what is written comes back, whatever interrupts the writing.

use std::fs;

use crate::support::{content, items, record, settings, write, writer};
use ppnpack_dataset::{Corner, Dataset, DatasetError, DatasetWriter, Settings, Split, StepRecord};
use tempfile::tempdir;

const SECOND: &str = "sequence-00001.safetensors.zst";

fn of(sequences: u32, has_values: bool) -> Settings {
    Settings {
        sequences,
        ..settings(has_values)
    }
}

#[test]
fn what_is_written_comes_back() {
    for has_values in [false, true] {
        let (folder, settings) = (tempdir().unwrap(), settings(has_values));
        let dataset = write(folder.path(), &settings);
        assert_eq!(*dataset.settings(), settings);
        let records = (0..3).flat_map(|sequence| record(&settings, sequence).steps);
        let mut expected: Vec<_> = records.collect();
        let load = |with_values| dataset.load(Split::Train, with_values, &|_, _| {}).unwrap();
        assert_eq!(load(true), expected);
        for candidate in expected.iter_mut().flat_map(|step| &mut step.candidates) {
            candidate.values = None;
        }
        assert_eq!(load(false), expected);
    }
}

#[test]
fn items_come_back() {
    let folder = tempdir().unwrap();
    let dataset = write(folder.path(), &of(1, false));
    assert_eq!(dataset.items().len(), items().len());
    for (found, expected) in dataset.items().iter().zip(items()) {
        assert_eq!(found.views().len(), expected.views().len());
        for (found, expected) in found.views().iter().zip(expected.views()) {
            assert_eq!((found.nx(), found.ny()), (expected.nx(), expected.ny()));
            assert_eq!(
                (found.top(), found.bottom()),
                (expected.top(), expected.bottom())
            );
        }
    }
}

#[test]
fn every_tenth_sequence_is_for_testing() {
    let folder = tempdir().unwrap();
    let dataset = write(folder.path(), &of(20, false));
    let calls = std::cell::RefCell::new(vec![]);
    let test = dataset
        .load(Split::Test, true, &|done, total| {
            calls.borrow_mut().push((done, total));
        })
        .unwrap();
    let mut sequences: Vec<u32> = test.iter().map(|step| step.sequence).collect();
    sequences.dedup();
    assert_eq!(sequences, [9, 19]);
    assert_eq!(*calls.borrow(), [(1, 2), (2, 2)]);
    let train = dataset.load(Split::Train, true, &|_, _| {}).unwrap();
    assert!(train.iter().all(|step| step.sequence % 10 != 9));
}

#[test]
fn files_do_not_depend_on_order_threads_or_interruptions() {
    let settings = of(5, true);
    let (straight, resumed) = (tempdir().unwrap(), tempdir().unwrap());
    let expected = write(straight.path(), &settings);

    // The first process dies in between.
    let first = writer(resumed.path(), &settings);
    for sequence in [3, 1] {
        first.add(&record(&settings, sequence)).unwrap();
    }
    drop(first);
    assert!(Dataset::open(resumed.path()).is_err());

    let second = writer(resumed.path(), &settings);
    assert_eq!(second.missing(), [0, 2, 4]);
    std::thread::scope(|scope| {
        for sequence in second.missing() {
            let (second, settings) = (&second, &settings);
            scope.spawn(move || second.add(&record(settings, sequence)).unwrap());
        }
    });
    assert_eq!(second.finish().unwrap().hash(), expected.hash());
    assert_eq!(content(resumed.path()), content(straight.path()));
}

#[test]
fn damaged_files_are_named_and_made_again() {
    let (folder, settings) = (tempdir().unwrap(), settings(true));
    write(folder.path(), &settings);
    let expected = content(folder.path());
    let path = folder.path().join(SECOND);
    let whole = fs::read(&path).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 4;
    let longer = [&whole[..], b"x"].concat();
    for damaged in [&whole[..whole.len() / 2], &[], &flipped, &longer] {
        fs::write(&path, damaged).unwrap();
        let dataset = Dataset::open(folder.path()).unwrap();
        let error = dataset.load(Split::Train, true, &|_, _| {});
        assert!(matches!(error, Err(DatasetError::Damaged(path, _)) if path.ends_with(SECOND)));
        assert_eq!(writer(folder.path(), &settings).missing(), [1]);
        write(folder.path(), &settings);
        assert_eq!(content(folder.path()), expected);
    }
}

#[test]
fn a_dataset_grows() {
    let (grown, straight) = (tempdir().unwrap(), tempdir().unwrap());
    write(grown.path(), &of(3, false));
    let growing = writer(grown.path(), &of(5, false));
    assert_eq!(growing.missing(), [3, 4]);
    let unfinished = Dataset::open(grown.path()).unwrap_err().to_string();
    assert!(unfinished.contains("sequence-00003"), "{unfinished}");
    write(grown.path(), &of(5, false));
    write(straight.path(), &of(5, false));
    assert_eq!(content(grown.path()), content(straight.path()));
}

#[test]
fn other_settings_are_refused_by_name() {
    let (folder, settings) = (tempdir().unwrap(), settings(false));
    write(folder.path(), &settings);
    let mut other = settings.clone();
    other.seed = 4;
    other.cell["drop_m"] = 0.2.into();
    let error = DatasetWriter::open(folder.path(), other, items()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("cell.drop_m is 0.1 there, 0.2 is asked for"),
        "{text}"
    );
    assert!(text.contains("seed is 3 there, 4 is asked for"), "{text}");
    assert!(!text.contains("length"), "{text}");
    assert!(Dataset::open(folder.path()).is_ok(), "it is left alone");
}

#[test]
fn records_that_do_not_fit_are_refused() {
    let (folder, settings) = (tempdir().unwrap(), settings(true));
    let writer = writer(folder.path(), &settings);
    let good = record(&settings, 0);
    let refused = |damage: &dyn Fn(&mut StepRecord)| {
        let mut bad = good.clone();
        damage(&mut bad.steps[1]);
        let error = writer.add(&bad);
        assert!(matches!(error, Err(DatasetError::Record(0, _))));
    };
    refused(&|step| step.step = 0);
    refused(&|step| step.sequence = 1);
    refused(&|step| step.heightmap.truncate(3));
    refused(&|step| step.heightmap[0] = -1);
    refused(&|step| step.candidates.clear());
    refused(&|step| step.candidates.extend(step.candidates.clone()));
    refused(&|step| step.candidates[0].object = 5);
    refused(&|step| step.candidates[0].yaws.truncate(1));
    refused(&|step| step.candidates[0].values = None);
    refused(&|step| {
        for optima in &mut step.candidates[0].yaws {
            optima.placements.clear();
            optima.value = 1.0;
        }
    });
    let of_all = |step: &mut StepRecord, damage: fn(&mut Vec<Corner>)| {
        let yaws = step.candidates.iter_mut().flat_map(|found| &mut found.yaws);
        yaws.for_each(|optima| damage(&mut optima.placements));
    };
    refused(&|step| of_all(step, |corners| corners.iter_mut().for_each(|at| at.x += 12)));
    refused(&|step| of_all(step, |corners| corners.extend(corners.clone())));
    writer.add(&good).unwrap();
    assert!(writer.finish().is_err(), "two are missing");
}
