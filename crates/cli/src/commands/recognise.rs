//! `ppnpack recognise`: recognises the objects in a point cloud file.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::anyhow;
use clap::Args;
use nalgebra::Point3;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::scene::model::mesh::Bounds;
use ppnpack_perception::extrinsics::Extrinsics;
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_recognition::recognise::{
    Candidate, Recogniser, Recognition, RecognitionSettings, UnknownReason,
};
use ppnpack_recognition::segmentation::{Cluster, Region, SegmentationSettings, segment};
use ppnpack_recognition::unknown_item::unknown_item;
use serde::Serialize;

use crate::failure::{Failure, OrInput, Outcome};
use crate::options::{CatalogueOptions, Sensor, parse_region, parse_sensor, read_cloud};
use crate::output;
use crate::quantity::parse_distance;
use crate::text::template;

/// Margin of a cloud's own region around it, in metres.
const MARGIN_M: f64 = 0.001;

/// Finds the items in a point cloud of a tray or a table, and says which object of the catalogue
/// each one is and how it lies.
///
/// The cloud is a PCD or PLY file. The z axis of the frame that the pose leads to must
/// point up; without a pose, that is the sensor's own. What items stand on is the plane that most
/// points lie on.
#[derive(Debug, Args)]
pub(crate) struct RecogniseArguments {
    /// The cloud
    #[arg(value_name = "CLOUD")]
    cloud: PathBuf,

    /// The unit of the cloud's coordinates: m, cm, mm or in; industrial cameras write millimetres
    #[arg(long, value_name = "UNIT", default_value = "m")]
    cloud_unit: LengthUnit,

    #[command(flatten)]
    catalogue: CatalogueOptions,

    /// The sensor's pose: metres and a unit quaternion, or a file that `ppnpack calibrate` wrote
    #[arg(long, value_name = "X,Y,Z,QX,QY,QZ,QW|FILE", value_parser = parse_sensor, allow_hyphen_values = true)]
    container_from_sensor: Option<Sensor>,

    /// The region of items, by the lowest and the highest corner; keep a tray's walls out [default:
    /// everywhere]
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = parse_region, allow_hyphen_values = true)]
    region: Option<Region>,

    /// The standard deviation of the sensor's noise
    #[arg(long, value_name = "LENGTH", default_value = "1mm", value_parser = parse_distance, allow_hyphen_values = true)]
    noise: f64,

    /// Print what was found as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// The result, for programs and people.
#[derive(Debug, Serialize)]
struct Found {
    items: Vec<Item>,
    /// Groups of points that are too small to be items.
    specks: usize,
    points: usize,
    /// Finding the items among the points.
    segmentation_s: f64,
}

/// An item.
#[derive(Debug, Default, Serialize)]
struct Item {
    /// None where it is unknown.
    object: Option<String>,
    /// The reason why it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    unknown: Option<&'static str>,
    /// Its pose; that of an unknown item is on its support, below the middle of what was seen.
    pose: Option<Extrinsics>,
    size_m: [f64; 3],
    points: usize,
    /// Agreement of it, or of the best object, with what was seen; at most 1.
    fitness: Option<f64>,
    runner_up: Option<String>,
    /// The fitness above the runner-up's.
    margin: Option<f64>,
    took_s: f64,
}

pub(crate) fn run(arguments: &RecogniseArguments) -> Outcome {
    let cloud = read_cloud(&arguments.cloud, arguments.cloud_unit, "--cloud-unit")?;
    let sensor = arguments.container_from_sensor.clone().unwrap_or_default();
    let container_from_sensor = sensor.container_from_sensor;
    let points = cloud.points_m().iter();
    let points = points.map(|point| container_from_sensor * point.cast::<f64>());
    let points = points.filter(|point| point.iter().all(|value| value.is_finite()));
    let points: Vec<Point3<f64>> = points.collect();
    let region = arguments.region.or_else(|| around(&points));
    let none = || Failure::input("the cloud has no point that was measured");
    let region = region.ok_or_else(none)?;
    let settings = SegmentationSettings::of(region);
    settings.validate().or_input()?;
    let recogniser = arguments.recogniser()?;
    let began = Instant::now();
    let eye = Point3::from(container_from_sensor.translation.vector);
    let found = segment(points.iter().copied(), &eye, &settings);
    let segmentation_s = began.elapsed().as_secs_f64();
    if found.world_from_support.is_none() {
        return Err(Failure::Run(anyhow!(
            "nothing level is seen that items could stand on: give the sensor's pose, or the region"
        )));
    }
    let clusters = found.clusters.iter();
    let items = clusters.map(|cluster| Item::of(cluster, &recogniser));
    let found = Found {
        items: items.collect(),
        specks: found.specks,
        points: points.len(),
        segmentation_s,
    };
    let text = template!("recognise.txt");
    Ok(output::print(&found, arguments.json, text)?)
}

impl RecogniseArguments {
    fn recogniser(&self) -> Outcome<Recogniser> {
        let catalogue = self.catalogue.load(&Resolution::reference())?;
        let library = Library::new(&catalogue.models(), LibrarySettings::default()).or_input()?;
        let settings = RecognitionSettings {
            sensor_deviation_m: self.noise,
            ..RecognitionSettings::default()
        };
        settings.validate().or_input()?;
        Ok(Recogniser::new(Arc::new(library), settings))
    }
}

/// Gives the region of all points; `None` without any.
fn around(points: &[Point3<f64>]) -> Option<Region> {
    let Bounds { lowest, highest } = Bounds::of(points)?;
    Some(Region {
        lowest_m: lowest.map(|value| value - MARGIN_M),
        highest_m: highest.map(|value| value + MARGIN_M),
    })
}

impl Item {
    fn of(cluster: &Cluster, recogniser: &Recogniser) -> Self {
        let began = Instant::now();
        let recognition = recogniser.recognise(cluster);
        let took_s = began.elapsed().as_secs_f64();
        let fitness = |best: &Candidate| best.agreement.fitness;
        let item = Self {
            size_m: cluster.extents_m().into(),
            points: cluster.points_m.len(),
            took_s,
            ..Self::default()
        };
        match recognition {
            Recognition::Known(known) => Self {
                pose: Some(Extrinsics::from(&known.best.world_from_item)),
                fitness: Some(fitness(&known.best)),
                runner_up: known.runner_up.map(|other| other.name),
                margin: Some(known.margin),
                object: Some(known.best.name),
                ..item
            },
            Recognition::Unknown(unknown) => {
                let made = unknown_item("unknown", cluster, &Resolution::reference()).ok();
                Self {
                    unknown: Some(reason(unknown.reason)),
                    pose: made.map(|made| Extrinsics::from(&made.world_from_item)),
                    fitness: unknown.candidates.first().map(fitness),
                    ..item
                }
            }
        }
    }
}

fn reason(reason: UnknownReason) -> &'static str {
    match reason {
        UnknownReason::FewPoints => "too few points",
        UnknownReason::NoCandidate => "no object of this size",
        UnknownReason::PoorFit => "no object agrees well enough",
    }
}
