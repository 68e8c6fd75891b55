//! `ppnpack catalogue`: lists, checks and draws the objects of a folder.

use std::iter::once;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use nalgebra::Vector3;
use ppnpack_catalogue::object::{CatalogueObject, Model};
use ppnpack_catalogue::poses::probability;
use ppnpack_catalogue::report::{ObjectReport, inspect};
use ppnpack_files::write_whole;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_picture::{Colour, Tile, TriangleMesh, contact_sheet};
use serde::Serialize;

use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::options::{CatalogueOptions, Conditions, GridOptions};
use crate::output::{self, print_line};
use crate::quantity::centimetres;
use crate::text::template;

/// Look at the objects of a folder or of the built-in set.
#[derive(Debug, Args)]
pub(crate) struct CatalogueArguments {
    #[command(subcommand)]
    command: CatalogueCommand,
}

#[derive(Debug, Subcommand)]
enum CatalogueCommand {
    /// List the objects with their sizes, volumes and masses; with several --poses, which pose has
    /// which number. The numbers are those of a cell with this grid
    List {
        #[command(flatten)]
        listing: Listing,

        #[command(flatten)]
        grid: GridOptions,
    },
    /// Check every mesh file: what was repaired, what is wrong with it, and what to do
    Check(Listing),
    /// Draw a picture sheet of the objects
    Show {
        #[command(flatten)]
        options: CatalogueOptions,

        /// The PNG file to write
        #[arg(long, value_name = "FILE", default_value = "out/catalogue.png")]
        out: PathBuf,

        /// The width of each object's picture, in pixels
        #[arg(long, value_name = "PIXELS", default_value_t = 200, value_parser = clap::value_parser!(u32).range(32..=2000))]
        tile: u32,
    },
}

#[derive(Debug, Args)]
struct Listing {
    #[command(flatten)]
    options: CatalogueOptions,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &CatalogueArguments) -> Outcome {
    match &arguments.command {
        CatalogueCommand::List { listing, grid } => list(listing, grid),
        CatalogueCommand::Check(listing) => check(listing),
        CatalogueCommand::Show { options, out, tile } => show(options, out, *tile),
    }
}

#[derive(Debug, Serialize)]
struct ListedObject {
    index: usize,
    name: String,
    extents_m: [f64; 3],
    volume_m3: f64,
    mass_kg: f64,
    /// The mass that may rest on it; absent where there is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    carries_kg: Option<f64>,
    triangles: usize,
    convex_pieces: usize,
    resting_poses: usize,
    /// The poses in which it may be packed, by their numbers.
    poses: Vec<ListedPose>,
}

/// A pose in which an object may be packed.
#[derive(Debug, Serialize)]
struct ListedPose {
    pose: usize,
    probability: f64,
    /// The direction of the object's own frame that points up.
    up: [f64; 3],
    extents_m: [f64; 3],
}

impl ListedPose {
    fn all(object: &CatalogueObject) -> Vec<Self> {
        let up = Vector3::z();
        let further = object.poses.iter();
        let further = further.map(|posed| (&posed.model, posed.rotation.inverse() * up));
        let poses = once((&object.model, up)).chain(further);
        let listed = poses.enumerate().map(|(pose, (model, up))| Self {
            pose,
            probability: probability(model),
            up: up.into(),
            extents_m: extents_m(model),
        });
        listed.collect()
    }
}

impl ListedObject {
    fn new((index, object): (usize, &CatalogueObject)) -> Self {
        let model = &object.model;
        Self {
            index,
            name: model.name.clone(),
            extents_m: extents_m(model),
            volume_m3: model.volume_m3,
            mass_kg: model.mass.mass_kg,
            carries_kg: model.carries_kg,
            triangles: model.mesh.triangles.len(),
            convex_pieces: model.pieces.len(),
            resting_poses: model.resting_poses.len(),
            poses: ListedPose::all(object),
        }
    }
}

fn extents_m(model: &Model) -> [f64; 3] {
    let bounds = model.mesh.bounds();
    bounds.map_or([0.0; 3], |bounds| bounds.extents_m().into())
}

fn list(listing: &Listing, grid: &GridOptions) -> Outcome {
    let grid = grid.grid(Conditions::Robot)?;
    // Pose 0 is the same on every grid, and a coarse one is prepared sooner.
    let coarse = Resolution::reference();
    let (resolution, text) = match listing.options.poses > 1 {
        true => (grid.resolution(), template!("catalogue_poses.txt")),
        false => (&coarse, template!("catalogue_list.txt")),
    };
    let catalogue = listing.options.load(resolution)?;
    let objects = catalogue.objects.iter().enumerate();
    let objects: Vec<ListedObject> = objects.map(ListedObject::new).collect();
    Ok(output::print(&objects, listing.json, text)?)
}

fn check(listing: &Listing) -> Outcome {
    let (source, settings) = (listing.options.source(), listing.options.settings());
    let reports = inspect(&source, &settings).or_input()?;
    let checked: Vec<CheckedObject> = reports.iter().map(CheckedObject::new).collect();
    output::print(&checked, listing.json, template!("catalogue_check.txt"))?;
    let (all, bad) = (
        checked.len(),
        checked.iter().filter(|object| !object.ok).count(),
    );
    match bad {
        0 => Ok(()),
        _ => Err(Failure::input(format_args!(
            "{bad} of {all} objects cannot be packed"
        ))),
    }
}

#[derive(Debug, Serialize)]
struct CheckedObject {
    path: String,
    ok: bool,
    error: Option<String>,
    repairs: Vec<String>,
    triangles: Option<usize>,
    volume_m3: Option<f64>,
}

impl CheckedObject {
    fn new(report: &ObjectReport) -> Self {
        let object = report.outcome.as_ref().ok();
        let repairs = object.iter().flat_map(|object| &object.repairs);
        let model = object.map(|object| &object.model);
        Self {
            path: report.path.display().to_string(),
            ok: report.outcome.is_ok(),
            error: report.outcome.as_ref().err().map(ToString::to_string),
            repairs: repairs.map(ToString::to_string).collect(),
            triangles: model.map(|model| model.mesh.triangles.len()),
            volume_m3: model.map(|model| model.volume_m3),
        }
    }
}

fn show(options: &CatalogueOptions, out: &std::path::Path, tile_px: u32) -> Outcome {
    let catalogue = options.load(&Resolution::reference())?;
    let models = || catalogue.objects.iter().map(|object| &object.model);
    let details: Vec<String> = models().map(|model| detail(model)).collect();
    let tiles = models().zip(&details).enumerate();
    let tiles = tiles.map(|(index, (model, detail))| Tile {
        mesh: TriangleMesh {
            vertices: &model.mesh.vertices,
            triangles: &model.mesh.triangles,
        },
        colour: Colour::of_item(index),
        name: &model.name,
        detail,
    });
    let tiles: Vec<Tile<'_>> = tiles.collect();
    let title = format!("{}: {} objects", options.catalogue, catalogue.len());
    let sheet = contact_sheet(&title, &tiles, tile_px).or_input()?;
    write_whole(out, &sheet.to_png().or_run()?)?;
    Ok(print_line(&format!("Picture sheet: {}", out.display()))?)
}

fn detail(model: &Model) -> String {
    let (size, volume_cm3) = (centimetres(extents_m(model)), model.volume_m3 * 1e6);
    format!("{size}, {volume_cm3:.0} cm³")
}
