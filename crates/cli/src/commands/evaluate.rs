//! `ppnpack evaluate`: one object on one container, at every offset.

use std::fs::File;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use nalgebra::Vector3;
use ndarray::Array2;
use ndarray_npy::NpzReader;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Units};
use ppnpack_packing::heightmap::Heightmap;
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::{Heuristic, Weights};
use ppnpack_packing::survey::{Surveyed, survey};
use serde::Serialize;

use crate::failure::{Failure, OrInput, Outcome};
use crate::output::print_json;

/// Evaluates one object on one container at every offset, and prints the results as JSON.
///
/// The case is an .npz file with `container` (int16 [nx, ny], heights in units of 0.2 cm on cells of 1 cm) and
/// `object_top`, `object_bottom` (int16 [w, d], -1 where the object has no material). The result has one value per
/// offset of the footprint: `drop` (resting height, -1 where it does not fit), `fits`, `stable` (the published
/// test) and `value` (with the balance term, null where it does not fit).
#[derive(Debug, Args)]
pub(crate) struct EvaluateArguments {
    /// The case
    #[arg(long, value_name = "FILE.npz")]
    case: PathBuf,

    /// What placements are judged by
    #[arg(long, value_enum, default_value = "sdf")]
    heuristic: CaseHeuristic,

    /// The container's height
    #[arg(long, value_name = "LENGTH", default_value = "30cm", value_parser = crate::length::parse_length)]
    height: f64,

    /// Print JSON, as is done in any case
    #[arg(long = "json")]
    _json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum CaseHeuristic {
    /// SDF minimisation
    #[value(alias = "sdfm")]
    Sdf,
    /// Deepest bottom-left
    Dbl,
    /// Heightmap minimisation
    Hm,
    /// Maximum touching area
    Mta,
}

/// The result, indexed by the footprint's offset along x, then y.
#[derive(Debug, Serialize)]
struct Evaluation {
    drop: Vec<Vec<Units>>,
    fits: Vec<Vec<u8>>,
    stable: Vec<Vec<u8>>,
    value: Vec<Vec<Option<f64>>>,
}

pub(crate) fn run(arguments: &EvaluateArguments) -> Outcome {
    let (heightmap, item) = read(&arguments.case)?;
    let resolution = Resolution::reference();
    let container = ContainerSize {
        x_m: heightmap.nx() as f64 * resolution.cell_m(),
        y_m: heightmap.ny() as f64 * resolution.cell_m(),
        z_m: arguments.height,
    };
    let grid = Grid::new(container, resolution).or_input()?;
    let heuristic = match arguments.heuristic {
        CaseHeuristic::Sdf => Heuristic::Sdfm,
        CaseHeuristic::Dbl => Heuristic::Dbl,
        CaseHeuristic::Hm => Heuristic::Hm,
        CaseHeuristic::Mta => Heuristic::Mta,
    };
    let view = item
        .views()
        .first()
        .ok_or_else(|| Failure::input("the object has no view"))?;
    let surveyed = survey(&grid, &heightmap, view, heuristic, &Weights::default()).or_input()?;
    print_json(&tables(&surveyed))?;
    Ok(())
}

fn tables(surveyed: &[Surveyed]) -> Evaluation {
    let rows: Vec<&[Surveyed]> = surveyed.chunk_by(|a, b| a.x == b.x).collect();
    fn table<T>(rows: &[&[Surveyed]], entry: impl Fn(&Surveyed) -> T) -> Vec<Vec<T>> {
        rows.iter()
            .map(|row| row.iter().map(&entry).collect())
            .collect()
    }
    Evaluation {
        drop: table(&rows, |at| if at.fits { at.resting_height } else { -1 }),
        fits: table(&rows, |at| u8::from(at.fits)),
        stable: table(&rows, |at| u8::from(at.fits && at.is_stable)),
        value: table(&rows, |at| at.fits.then_some(at.value)),
    }
}

fn read(path: &Path) -> Outcome<(Heightmap, Item)> {
    let wrong = |what: &str, why: &dyn std::fmt::Display| {
        Failure::input(format_args!("{}: {what}: {why}", path.display()))
    };
    let file = File::open(path).map_err(|error| wrong("cannot be opened", &error))?;
    let mut npz =
        NpzReader::new(file).map_err(|error| wrong("is no complete .npz file", &error))?;
    let mut map = |name: &str| -> Outcome<Array2<i16>> {
        npz.by_name(name).map_err(|error| {
            wrong(
                &format!("has no readable int16 [x, y] array '{name}'"),
                &error,
            )
        })
    };
    let (container, top, bottom) = (map("container")?, map("object_top")?, map("object_bottom")?);
    let (nx, ny) = container.dim();
    let heightmap = Heightmap::from_units(nx, ny, container.into_iter().collect())
        .map_err(|error| wrong("container", &error))?;
    let (nx, ny) = top.dim();
    let surfaces = ViewSurfaces {
        nx,
        ny,
        top: top.into_iter().collect(),
        bottom: bottom.into_iter().collect(),
        underside: None,
        origin_from_corner_m: Vector3::zeros(),
        centre_of_mass_m: None,
    };
    let item =
        Item::new("the object", vec![surfaces], 0.0).map_err(|error| wrong("object", &error))?;
    Ok((heightmap, item))
}
