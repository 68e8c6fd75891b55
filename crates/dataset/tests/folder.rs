//! Datasets on disk: what is written comes back, whatever interrupts the writing.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic in a test is a failing test"
)]

mod support;

use std::fs;
use std::path::Path;

use ppnpack_dataset::{Dataset, DatasetError, DatasetWriter, Split, StepRecord};
use support::{content, grid, items, record, settings, write, writer};
use tempfile::tempdir;

fn all_steps(dataset: &Dataset) -> Vec<StepRecord> {
    let load = |split| dataset.load(split, true, &|_, _| {}).unwrap();
    let mut steps = load(Split::Train);
    steps.extend(load(Split::Test));
    steps.sort_by_key(|step| (step.sequence, step.step));
    steps
}

#[test]
fn what_is_written_comes_back() {
    for has_values in [false, true] {
        let (folder, settings) = (tempdir().unwrap(), settings(has_values));
        write(folder.path(), &settings, 3);
        let dataset = Dataset::open(folder.path()).unwrap();
        let records = (0..3).flat_map(|sequence| record(&settings, sequence).steps);
        let expected: Vec<_> = records.collect();
        assert_eq!(all_steps(&dataset), expected);
        let manifest = dataset.manifest();
        assert_eq!((manifest.sequences, manifest.shards.len()), (3, 2));
        assert_eq!(manifest.steps, expected.len() as u64);
        assert_eq!(*dataset.settings(), settings);
        let mut optima = dataset.load(Split::Train, false, &|_, _| {}).unwrap();
        assert!(
            optima
                .iter()
                .all(|step| step.candidates.iter().all(|found| found.values.is_none()))
        );
        for (step, expected) in optima.iter_mut().zip(expected) {
            let values = expected.candidates.iter().map(|found| found.values.clone());
            let candidates = step.candidates.iter_mut();
            candidates
                .zip(values)
                .for_each(|(found, values)| found.values = values);
            assert_eq!(*step, expected);
        }
    }
}

#[test]
fn items_come_back() {
    let folder = tempdir().unwrap();
    write(folder.path(), &settings(false), 1);
    let dataset = Dataset::open(folder.path()).unwrap();
    let cell_m = grid().resolution().cell_m();
    assert_eq!(dataset.items().len(), items().len());
    for (found, expected) in dataset.items().iter().zip(items()) {
        assert_eq!(found.name(), expected.name());
        assert_eq!(found.mesh_volume_m3(), expected.mesh_volume_m3());
        for (found, expected) in found.views().iter().zip(expected.views()) {
            assert_eq!((found.nx(), found.ny()), (expected.nx(), expected.ny()));
            assert_eq!(
                (found.top(), found.bottom()),
                (expected.top(), expected.bottom())
            );
            assert_eq!(
                found.origin_from_corner_m(),
                expected.origin_from_corner_m()
            );
            assert_eq!(
                found.centre_of_mass_m(cell_m),
                expected.centre_of_mass_m(cell_m)
            );
        }
    }
}

#[test]
fn every_tenth_sequence_is_for_testing() {
    let (folder, settings) = (tempdir().unwrap(), settings(false));
    write(folder.path(), &settings, 20);
    let dataset = Dataset::open(folder.path()).unwrap();
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
    assert_eq!((train.len() + test.len()) as u64, dataset.manifest().steps);
}

#[test]
fn files_do_not_depend_on_order_threads_or_interruptions() {
    let settings = settings(true);
    let (straight, resumed) = (tempdir().unwrap(), tempdir().unwrap());
    write(straight.path(), &settings, 5);

    // The first process dies with one whole shard, half of another, and a half-written file.
    let first = writer(resumed.path(), &settings, 5);
    for sequence in [3, 1, 2] {
        first.add(&record(&settings, sequence)).unwrap();
    }
    drop(first);
    fs::write(resumed.path().join(".unfinished-abc"), b"half").unwrap();
    assert!(Dataset::open(resumed.path()).is_err());

    let second = writer(resumed.path(), &settings, 5);
    assert_eq!(second.missing(), [0, 1, 4]);
    std::thread::scope(|scope| {
        for sequence in second.missing() {
            let (second, settings) = (&second, &settings);
            scope.spawn(move || second.add(&record(settings, sequence)).unwrap());
        }
    });
    second.finish().unwrap();
    assert_eq!(content(resumed.path()), content(straight.path()));
}

#[test]
fn shards_of_several_folders_are_one_dataset() {
    let settings = settings(true);
    let [straight, one, other, all] = [(); 4].map(|()| tempdir().unwrap());
    write(straight.path(), &settings, 6);
    for (folder, sequences) in [(&one, 0..2), (&other, 2..6)] {
        let writer = writer(folder.path(), &settings, 6);
        for sequence in sequences {
            writer.add(&record(&settings, sequence)).unwrap();
        }
    }
    let merging = writer(all.path(), &settings, 6);
    assert_eq!(merging.adopt(one.path()).unwrap(), 1);
    assert_eq!(merging.missing(), [2, 3, 4, 5]);
    assert_eq!(merging.adopt(other.path()).unwrap(), 2);
    assert_eq!(merging.adopt(other.path()).unwrap(), 0, "they are there");
    merging.finish().unwrap();
    assert_eq!(content(all.path()), content(straight.path()));

    let mut foreign = settings.clone();
    foreign.seed = 4;
    let folder = tempdir().unwrap();
    let merging = writer(folder.path(), &foreign, 6);
    let refused = merging.adopt(one.path()).unwrap_err();
    assert!(matches!(refused, DatasetError::OtherSettings { .. }));
    let damaged = one.path().join("shard-00000.bin");
    fs::write(&damaged, b"half").unwrap();
    let folder = tempdir().unwrap();
    let refused = writer(folder.path(), &settings, 6).adopt(one.path());
    assert!(matches!(refused, Err(DatasetError::Damaged { path, .. }) if path == damaged));
    assert!(
        writer(folder.path(), &settings, 6)
            .adopt(Path::new("/nowhere"))
            .is_err()
    );
}

#[test]
fn damaged_shards_are_made_again() {
    let (folder, settings) = (tempdir().unwrap(), settings(true));
    write(folder.path(), &settings, 5);
    let expected = content(folder.path());
    let path = folder.path().join("shard-00001.bin");
    let whole = fs::read(&path).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 4;
    let longer = [&whole[..], b"x"].concat();
    for damaged in [&whole[..whole.len() / 2], &[], &flipped, &longer] {
        fs::write(&path, damaged).unwrap();
        let error = Dataset::open(folder.path())
            .unwrap()
            .load(Split::Train, true, &|_, _| {});
        assert!(
            matches!(error, Err(DatasetError::Damaged { path, .. }) if path.ends_with("shard-00001.bin"))
        );
        assert_eq!(writer(folder.path(), &settings, 5).missing(), [2, 3]);
        write(folder.path(), &settings, 5);
        assert_eq!(content(folder.path()), expected);
    }
}

#[test]
fn a_dataset_grows_and_does_not_shrink() {
    let settings = settings(false);
    let (grown, straight) = (tempdir().unwrap(), tempdir().unwrap());
    write(grown.path(), &settings, 3);
    let growing = writer(grown.path(), &settings, 6);
    assert_eq!(growing.missing(), [2, 3, 4, 5]);
    assert!(
        Dataset::open(grown.path()).is_err(),
        "it is complete no more"
    );
    drop(growing);
    write(grown.path(), &settings, 6);
    write(straight.path(), &settings, 6);
    assert_eq!(content(grown.path()), content(straight.path()));
    let error = DatasetWriter::open(grown.path(), settings, items(), 3).unwrap_err();
    assert!(matches!(
        error,
        DatasetError::MoreSequences {
            found: 6,
            asked: 3,
            ..
        }
    ));
    assert!(Dataset::open(grown.path()).is_ok());
}

#[test]
fn other_settings_are_refused_by_name() {
    let (folder, settings) = (tempdir().unwrap(), settings(false));
    write(folder.path(), &settings, 1);
    let mut other = settings.clone();
    other.seed = 4;
    other.cell["drop_m"] = 0.2.into();
    let error = DatasetWriter::open(folder.path(), other.clone(), items(), 1).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("cell.drop_m is 0.1 there, 0.2 is asked for"),
        "{text}"
    );
    assert!(text.contains("seed is 3 there, 4 is asked for"), "{text}");
    assert!(!text.contains("length"), "{text}");
    assert!(Dataset::open(folder.path()).is_ok(), "it is left alone");

    // A shard that was copied in from other settings is not taken for one of these.
    let foreign = tempdir().unwrap();
    write(foreign.path(), &other, 1);
    let name = "shard-00000.bin";
    fs::copy(foreign.path().join(name), folder.path().join(name)).unwrap();
    assert_eq!(writer(folder.path(), &settings, 1).missing(), [0]);
}

#[test]
fn one_process_writes_at_a_time() {
    let (folder, settings) = (tempdir().unwrap(), settings(false));
    let _first = writer(folder.path(), &settings, 1);
    let second = DatasetWriter::open(folder.path(), settings, items(), 1);
    assert!(matches!(second, Err(DatasetError::InUse { .. })));
}

#[test]
fn records_that_do_not_fit_are_refused() {
    let (folder, settings) = (tempdir().unwrap(), settings(true));
    let writer = writer(folder.path(), &settings, 2);
    let good = record(&settings, 0);
    let refused = |damage: &dyn Fn(&mut StepRecord)| {
        let mut bad = good.clone();
        damage(&mut bad.steps[1]);
        let error = writer.add(&bad);
        assert!(matches!(
            error,
            Err(DatasetError::Record { sequence: 0, .. })
        ));
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
    refused(&|step| {
        for optima in step.candidates.iter_mut().flat_map(|found| &mut found.yaws) {
            optima
                .placements
                .iter_mut()
                .for_each(|corner| corner.x += 12);
        }
    });
    refused(&|step| {
        for optima in step.candidates.iter_mut().flat_map(|found| &mut found.yaws) {
            optima.placements.extend(optima.placements.clone());
        }
    });
    writer.add(&good).unwrap();
    assert!(matches!(
        writer.finish(),
        Err(DatasetError::Unfinished { count: 1, first: 1 })
    ));
}
