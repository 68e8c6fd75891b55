//! `objects.csv`: the order, names, units, masses and what may rest on a folder's objects.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::error::CatalogueError;
use crate::reader;
use crate::rows::rows;
use crate::unit::LengthUnit;

/// The file that lists a folder's objects.
pub(crate) const FILE_NAME: &str = "objects.csv";

/// Its columns that are read.
const COLUMNS: &[&str] = &["file", "index", "name", "unit", "mass_kg", "carries_kg"];

/// A mesh file of a folder, and what is known of it before it is read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Listed {
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    pub(crate) unit: Option<LengthUnit>,
    pub(crate) mass_kg: Option<f64>,
    pub(crate) carries_kg: Option<f64>,
}

/// A line of the table; other columns are ignored, and what is empty is as if it were not there.
#[derive(Debug, Deserialize)]
struct Row {
    file: String,
    index: Option<usize>,
    name: Option<String>,
    unit: Option<String>,
    mass_kg: Option<f64>,
    carries_kg: Option<f64>,
}

/// The objects of a folder: as its table lists them, else all mesh files by name.
pub(crate) fn list(folder: &Path) -> Result<Vec<Listed>, CatalogueError> {
    if !folder.is_dir() {
        return Err(CatalogueError(format!(
            "{} is no folder: give the folder that holds the mesh files",
            folder.display()
        )));
    }
    let table = folder.join(FILE_NAME);
    let listed = if table.is_file() {
        read_table(folder, &table)?
    } else {
        mesh_files(folder)?
    };
    if listed.is_empty() {
        return Err(CatalogueError(format!(
            "{} holds no .ply, .obj, .stl, .glb or .3mf file",
            folder.display()
        )));
    }
    let mut names = BTreeMap::new();
    for object in &listed {
        if let Some(first) = names.insert(&object.name, &object.path) {
            return Err(CatalogueError(format!(
                "the name '{}' stands for both {} and {}: rename one",
                object.name,
                first.display(),
                object.path.display()
            )));
        }
    }
    Ok(listed)
}

fn mesh_files(folder: &Path) -> Result<Vec<Listed>, CatalogueError> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable(folder))? {
        let path = entry.map_err(unreadable(folder))?.path();
        if reader::is_mesh_file(&path) && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    let listed = |path: PathBuf| Listed {
        name: stem(&path),
        path,
        unit: None,
        mass_kg: None,
        carries_kg: None,
    };
    Ok(paths.into_iter().map(listed).collect())
}

fn unreadable(path: &Path) -> impl Fn(std::io::Error) -> CatalogueError {
    move |error| CatalogueError(format!("{} cannot be read: {error}", path.display()))
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn read_table(folder: &Path, table: &Path) -> Result<Vec<Listed>, CatalogueError> {
    let wrong =
        |line: u64, reason: String| CatalogueError(format!("{}:{line}: {reason}", table.display()));
    let file = File::open(table).map_err(unreadable(table))?;
    let mut listed: BTreeMap<usize, (u64, Listed)> = BTreeMap::new();
    for (row_index, row) in rows::<Row>(file, COLUMNS, "the column 'file' is needed").enumerate() {
        let (line, row) = row.map_err(|(line, reason)| wrong(line, reason))?;
        let index = row.index.unwrap_or(row_index);
        let object = object(folder, row).map_err(|reason| wrong(line, reason))?;
        if let Some((other, _)) = listed.insert(index, (line, object)) {
            return Err(wrong(
                line,
                format!("the index {index} was given on line {other}: give each its own"),
            ));
        }
    }
    // Sequences refer to objects by index, so that a gap would shift all that follow it.
    if let Some((expected, (_, (line, _)))) = listed
        .iter()
        .enumerate()
        .find(|(expected, (index, _))| expected != *index)
    {
        return Err(wrong(
            *line,
            format!("no line has the index {expected}: number the objects from 0 without gaps"),
        ));
    }
    Ok(listed.into_values().map(|(_, object)| object).collect())
}

fn object(folder: &Path, row: Row) -> Result<Listed, String> {
    let path = folder.join(&row.file);
    if row.file.is_empty() || !path.is_file() {
        return Err(format!(
            "the file '{}' is not there: correct the column 'file'",
            row.file
        ));
    }
    let unit = row.unit.map(|unit| unit.parse()).transpose()?;
    if let Some(mass_kg) = row.mass_kg
        && !(mass_kg.is_finite() && mass_kg > 0.0)
    {
        return Err(format!("the mass of {mass_kg} kg is not positive"));
    }
    if let Some(carries_kg) = row.carries_kg
        && !(carries_kg.is_finite() && carries_kg >= 0.0)
    {
        return Err(format!(
            "carries_kg is {carries_kg}: give 0 where nothing may rest on it, or leave it empty"
        ));
    }
    let name = row.name.unwrap_or_else(|| stem(&path));
    Ok(Listed {
        name,
        path,
        unit,
        mass_kg: row.mass_kg,
        carries_kg: row.carries_kg,
    })
}
