//! `ppnpack experiment merge`: the runs of all shards of an experiment in one folder.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_files::write_whole;
use serde::Serialize;

use crate::runs::{SETTINGS_FILE, SHARD_EXTENSION};
use crate::shard::Shard;

/// Puts the runs of all shards of an experiment together. Then the same experiment without --shard, with the merged folder as
/// --runs (`physical`: as `runs` in its --out), makes its tables of them without packing anything again. Shards of other settings,
/// of another build, or that are not finished are refused.
#[derive(Debug, Args)]
pub(crate) struct MergeArguments {
    /// The --runs folders of the shards; several shards may have had the same one
    #[arg(required = true, value_name = "DIR")]
    shards: Vec<PathBuf>,

    /// Where the runs of all are put together
    #[arg(long, value_name = "DIR")]
    into: PathBuf,

    /// Print what was done as JSON
    #[arg(long)]
    json: bool,
}

/// What was put together.
#[derive(Debug, PartialEq, Eq, Serialize)]
struct Merged {
    shards: u32,
    runs: usize,
}

pub(crate) fn run(arguments: &MergeArguments) -> Outcome {
    let merged = merge(&arguments.shards, &arguments.into)?;
    if arguments.json {
        return Ok(print_json(&merged)?);
    }
    Ok(print_line(&format!(
        "{} runs of {} shards are in {}: the experiment makes its tables of them, with this folder as --runs",
        merged.runs,
        merged.shards,
        arguments.into.display()
    ))?)
}

/// The runs of one shard's folder: of each group of runs with the same settings the files by name.
type Groups = BTreeMap<String, BTreeMap<String, PathBuf>>;

fn merge(folders: &[PathBuf], into: &Path) -> Outcome<Merged> {
    let mut shards = BTreeSet::new();
    let mut files = Groups::new();
    let mut expected: Option<(&Path, Vec<String>)> = None;
    for folder in folders {
        let groups = groups(folder)?;
        let names: Vec<String> = groups.keys().cloned().collect();
        match &expected {
            None => expected = Some((folder, names)),
            Some((first, expected)) if *expected != names => {
                return Err(Failure::input(format_args!(
                    "the runs in {} are of other settings or of another build than those in {}: compare the {SETTINGS_FILE} \
                     files in them",
                    folder.display(),
                    first.display()
                )));
            }
            Some(_) => {}
        }
        shards.extend(finished_shards(folder, &groups)?);
        for (group, runs) in groups {
            add(files.entry(group).or_default(), runs)?;
        }
    }
    let count = complete(&shards)?;
    let mut runs = 0;
    for (group, members) in &files {
        let folder = into.join(group);
        for (name, path) in members {
            let target = folder.join(name);
            if target.exists() && !same(path, &target)? {
                return Err(differs(path, &target));
            }
            write_whole(&target, &fs::read(path).or_input()?)?;
            runs += usize::from(is_run(name));
        }
    }
    Ok(Merged {
        shards: count,
        runs,
    })
}

/// The groups of a folder of runs.
fn groups(folder: &Path) -> Outcome<Groups> {
    let mut groups = Groups::new();
    for path in entries(folder)? {
        if !path.join(SETTINGS_FILE).is_file() {
            continue;
        }
        let members = entries(&path)?.into_iter().map(|file| (name(&file), file));
        groups.insert(name(&path), members.collect());
    }
    if groups.is_empty() {
        return Err(Failure::input(format_args!(
            "there are no runs in {}: give the --runs folder of a shard",
            folder.display()
        )));
    }
    Ok(groups)
}

fn entries(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let read = fs::read_dir(folder).map_err(|error| {
        Failure::input(format_args!("{} cannot be read: {error}", folder.display()))
    })?;
    let paths = read.map(|entry| entry.map(|entry| entry.path()));
    paths.collect::<Result<_, _>>().or_input()
}

fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn is_run(name: &str) -> bool {
    name != SETTINGS_FILE && !is_shard_mark(name)
}

fn is_shard_mark(name: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|extension| extension == SHARD_EXTENSION)
}

/// The shards that are finished in all groups of a folder.
fn finished_shards(folder: &Path, groups: &Groups) -> Outcome<BTreeSet<Shard>> {
    let mut finished: Option<BTreeSet<Shard>> = None;
    for runs in groups.values() {
        let marks = runs.iter().filter(|(name, _)| is_shard_mark(name));
        let shards = marks.filter_map(|(_, path)| {
            let content = fs::read(path).ok()?;
            serde_json::from_slice::<Shard>(&content).ok()
        });
        let shards: BTreeSet<Shard> = shards.collect();
        finished = Some(match finished {
            None => shards,
            Some(finished) => finished.intersection(&shards).copied().collect(),
        });
    }
    finished
        .filter(|finished| !finished.is_empty())
        .ok_or_else(|| {
            Failure::input(format_args!(
                "no shard is finished in {}: repeat its command, which goes on where it was",
                folder.display()
            ))
        })
}

/// How many shards there are, where each of them is there.
fn complete(shards: &BTreeSet<Shard>) -> Outcome<u32> {
    let Some(first) = shards.first() else {
        return Err(Failure::input("there are no shards"));
    };
    if let Some(other) = shards.iter().find(|shard| shard.count() != first.count()) {
        return Err(Failure::input(format_args!(
            "shard {first} and shard {other} are parts of different divisions"
        )));
    }
    let missing: Vec<String> = first
        .all()
        .filter(|shard| !shards.contains(shard))
        .map(|shard| shard.to_string())
        .collect();
    if missing.is_empty() {
        return Ok(first.count());
    }
    Err(Failure::input(format_args!(
        "these shards are missing or not finished: {}",
        missing.join(", ")
    )))
}

/// Adds the files of a group to those of other shards; the same file may be in several.
fn add(known: &mut BTreeMap<String, PathBuf>, files: BTreeMap<String, PathBuf>) -> Outcome {
    for (name, path) in files {
        if let Some(other) = known.get(&name)
            && !same(other, &path)?
        {
            return Err(differs(&path, other));
        }
        known.insert(name, path);
    }
    Ok(())
}

fn same(one: &Path, other: &Path) -> Outcome<bool> {
    Ok(fs::read(one).or_input()? == fs::read(other).or_input()?)
}

fn differs(path: &Path, other: &Path) -> Failure {
    Failure::input(format_args!(
        "{} and {} are of the same run and differ: remove the wrong one",
        path.display(),
        other.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::Runs;

    /// A folder with the runs of some shards.
    fn folder(root: &Path, name: &str, settings: u32, shards: &[&str]) -> PathBuf {
        let folder = root.join(name);
        let runs = Runs::new(&folder, &settings).unwrap();
        for shard in shards {
            let shard: Shard = shard.parse().unwrap();
            for case in (0..6).filter(|case| shard.has(*case)) {
                let make = || Ok(case);
                runs.finish(&case.to_string(), |_| true, make).unwrap();
            }
            runs.finish_shard(shard).unwrap();
        }
        folder
    }

    fn refused(folders: &[PathBuf], into: &Path) -> String {
        merge(folders, into).unwrap_err().to_string()
    }

    #[test]
    fn merged_shards_hold_what_a_single_run_holds() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        let shards = [
            folder(root, "a", 1, &["0/3"]),
            folder(root, "b", 1, &["1/3", "2/3"]),
        ];
        let into = root.join("all");
        let merged = merge(&shards, &into).unwrap();
        assert_eq!(merged, Merged { shards: 3, runs: 6 });
        // All are found again: none is made.
        let runs = Runs::new(&into, &1).unwrap();
        for case in 0..6_usize {
            let found = runs.finish(&case.to_string(), |_| true, || Ok(99_usize));
            assert_eq!(found.unwrap(), case);
        }
        // Once more is no other thing.
        assert_eq!(merge(&shards, &into).unwrap(), merged);
    }

    #[test]
    fn shards_of_other_settings_and_missing_ones_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        let into = root.join("all");
        let first = folder(root, "a", 1, &["0/3"]);
        let other = folder(root, "b", 2, &["1/3", "2/3"]);
        assert!(refused(&[first.clone(), other], &into).contains("other settings"));
        let second = folder(root, "c", 1, &["1/3"]);
        let missing = refused(&[first.clone(), second], &into);
        assert!(missing.ends_with("not finished: 2/3"), "{missing}");
        let divided = folder(root, "d", 1, &["0/2", "1/2"]);
        assert!(refused(&[first, divided], &into).contains("different divisions"));
        let unfinished = folder(root, "e", 1, &[]);
        assert!(refused(&[unfinished], &into).contains("no shard is finished"));
        assert!(refused(&[root.join("nowhere")], &into).contains("nowhere"));
        assert!(!into.exists());
    }

    #[test]
    fn runs_that_differ_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        let one = folder(root, "a", 1, &["0/1"]);
        let other = folder(root, "b", 1, &["0/1"]);
        let changed = entries(&other).unwrap().remove(0).join("3.json");
        write_whole(&changed, b"7").unwrap();
        let refused = refused(&[one, other], &root.join("all"));
        assert!(
            refused.contains("3.json") && refused.contains("differ"),
            "{refused}"
        );
    }
}
