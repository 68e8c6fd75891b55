//! `ppnpack perceive`: point cloud files of one scene to a heightmap.

mod example;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_clouds::Cloud;
use ppnpack_files::StagedFolder;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution};
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;
use ppnpack_picture::HeightField;
use serde::Serialize;

use crate::drawing;
use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::options::container::parse_container;
use crate::options::{Sensor, file, parse_sensor, read_cloud};
use crate::output::{self, print_line};
use crate::quantity::parse_length;
use crate::text::template;

/// Maximum difference of the container's size between sensors, in metres.
const SIZE_TOLERANCE_M: f64 = 0.005;

/// Maps point clouds of one scene, prints a summary and draws the heightmap.
///
/// A cloud is a PCD or PLY file in its sensor's frame. Without a pose, that is the
/// container's frame: origin at an inner bottom corner, z up. `ppnpack calibrate` finds the pose.
/// Several clouds, of several sensors, make one map.
#[derive(Debug, Args)]
pub(crate) struct PerceiveArguments {
    /// The clouds
    #[arg(value_name = "CLOUD", required_unless_present = "example")]
    clouds: Vec<PathBuf>,

    /// The unit of the clouds' coordinates: m, cm, mm or in; industrial cameras write millimetres
    #[arg(long, value_name = "UNIT", default_value = "m")]
    unit: LengthUnit,

    /// Write clouds of a simulated camera to try this on into a folder, and say how
    #[arg(long, value_name = "DIR", conflicts_with = "clouds")]
    example: Option<PathBuf>,

    /// The pose of each cloud's sensor, in the order of the clouds: metres and a unit quaternion,
    /// or a file that `ppnpack calibrate` wrote
    #[arg(long, value_name = "X,Y,Z,QX,QY,QZ,QW|FILE", value_parser = parse_sensor, allow_hyphen_values = true)]
    container_from_sensor: Vec<Sensor>,

    /// The container's inner size, or a TOML file with its size, draft and corner_radius (default:
    /// that of the calibration, else 32x32x30cm)
    #[arg(long, value_name = "XxYxZ|FILE", allow_hyphen_values = true, value_parser = parse_container)]
    container: Option<ContainerSize>,

    /// The edge of a grid cell
    #[arg(long, value_name = "LENGTH", default_value = "1cm", value_parser = parse_length, allow_hyphen_values = true)]
    cell: f64,

    /// One unit of height
    #[arg(long, value_name = "LENGTH", default_value = "2mm", value_parser = parse_length, allow_hyphen_values = true)]
    height_unit: f64,

    /// Settings by which points become heights: a TOML file with the keys of the section `mapper`
    /// in the perception service's configuration [default: as suits a sensor without noise]
    #[arg(long, value_name = "FILE", value_parser = file::settings::<MapperSettings>)]
    mapper: Option<MapperSettings>,

    /// The folder of the results
    #[arg(long, value_name = "DIR", default_value = "out/perceive")]
    out: PathBuf,

    /// Print the summary as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// The result, for programs and people.
#[derive(Debug, Serialize)]
struct Summary {
    clouds: Vec<CloudSummary>,
    container: ContainerSize,
    cell_m: f64,
    height_unit_m: f64,
    mapper: MapperSettings,
    /// Points with three finite coordinates.
    points_measured: u64,
    points_inside: u64,
    /// Points that stood by themselves and were left out.
    points_alone: u64,
    cells: usize,
    unknown_cells: usize,
    samples: usize,
    unseen_samples: usize,
    /// Reasons for a planner to place nothing on this.
    doubts: Vec<String>,
    /// Greatest height of the known cells; none where none is known.
    greatest_height_m: Option<f64>,
    /// Without reading the files.
    took_s: f64,
}

/// A cloud of the scene.
#[derive(Debug, Serialize)]
struct CloudSummary {
    path: PathBuf,
    points: usize,
    width: usize,
    height: usize,
}

pub(crate) fn run(arguments: &PerceiveArguments) -> Outcome {
    if let Some(folder) = &arguments.example {
        return example::write(folder);
    }
    let sensors = arguments.sensors()?;
    let grid = arguments.grid(&sensors)?;
    let settings = arguments.mapper.clone().unwrap_or_default();
    let mut mapper = Mapper::new(&grid, settings.clone()).or_input()?;
    let paths = arguments.clouds.iter();
    let clouds = paths.map(|path| read_cloud(path, arguments.unit, "--unit"));
    let clouds: Vec<Cloud> = clouds.collect::<Result<_, _>>()?;
    let began = Instant::now();
    mapper.clear();
    for (cloud, sensor) in clouds.iter().zip(&sensors) {
        let points_m = cloud.points_m().iter().copied();
        mapper.add(points_m, &sensor.container_from_sensor);
    }
    let mapped = mapper.finish().or_run()?;
    let took_s = began.elapsed().as_secs_f64();
    let clouds = arguments.clouds.iter().zip(&clouds);
    let summary = Summary {
        clouds: clouds.map(CloudSummary::new).collect(),
        took_s,
        ..Summary::new(&grid, settings, &mapped)
    };
    write(&grid, &mapped, &summary, &arguments.out)?;
    output::print(&summary, arguments.json, template!("perceive.txt"))?;
    if !arguments.json {
        let picture = arguments.out.join("heightmap.png");
        print_line(&format!("Picture: {}", picture.display()))?;
    }
    Ok(())
}

impl PerceiveArguments {
    /// Gives the sensor of each cloud.
    fn sensors(&self) -> Outcome<Vec<Sensor>> {
        let (clouds, given) = (self.clouds.len(), self.container_from_sensor.len());
        if given == 0 {
            return Ok(vec![Sensor::default(); clouds]);
        }
        if given != clouds {
            return Err(Failure::input(format_args!(
                "--container-from-sensor is given {given} times for {clouds} clouds: give it once for each, in their order"
            )));
        }
        Ok(self.container_from_sensor.clone())
    }

    fn grid(&self, sensors: &[Sensor]) -> Outcome<Grid> {
        let yaws = Resolution::reference().yaws().clone();
        let resolution = Resolution::new(self.cell, self.height_unit, yaws).or_input()?;
        Grid::new(self.container(sensors)?, resolution).or_input()
    }

    fn container(&self, sensors: &[Sensor]) -> Outcome<ContainerSize> {
        if let Some(given) = self.container {
            return Ok(given);
        }
        let mut calibrated = sensors.iter().filter_map(|sensor| sensor.container);
        let Some(first) = calibrated.next() else {
            return Ok(ContainerSize::REFERENCE);
        };
        let sides = |size: ContainerSize| [size.x_m, size.y_m, size.z_m];
        let differs = |other: ContainerSize| {
            let mut pairs = sides(first).into_iter().zip(sides(other));
            pairs.any(|(one, two)| (one - two).abs() > SIZE_TOLERANCE_M)
        };
        if calibrated.any(differs) {
            return Err(Failure::input(
                "the calibrations are of containers of different sizes: give --container",
            ));
        }
        Ok(first)
    }
}

impl CloudSummary {
    fn new((path, cloud): (&PathBuf, &Cloud)) -> Self {
        Self {
            path: path.clone(),
            points: cloud.points_m().len(),
            width: cloud.width(),
            height: cloud.height(),
        }
    }
}

impl Summary {
    fn new(grid: &Grid, mapper: MapperSettings, mapped: &Mapped) -> Self {
        let unit_m = grid.resolution().height_unit_m();
        let surface = mapped.scene.surface();
        let heights = mapped.scene.heightmap().heights().iter();
        // What is unknown is one unit above the rim; content may be higher still.
        let known = heights.filter(|height| **height != grid.rim() + 1);
        Self {
            clouds: Vec::new(),
            container: grid.container(),
            cell_m: grid.resolution().cell_m(),
            height_unit_m: unit_m,
            mapper,
            points_measured: mapped.tally.measured,
            points_inside: mapped.tally.inside,
            points_alone: mapped.tally.alone,
            cells: grid.nx() * grid.ny(),
            unknown_cells: mapped.unknown_cells,
            samples: surface.map_or(0, |surface| surface.heights_m().len()),
            unseen_samples: mapped.unseen_samples,
            doubts: mapped.doubts.iter().map(ToString::to_string).collect(),
            greatest_height_m: known.max().map(|height| f64::from(*height) * unit_m),
            took_s: 0.0,
        }
    }
}

/// Writes the pictures and the summary, or nothing.
fn write(grid: &Grid, mapped: &Mapped, summary: &Summary, folder: &Path) -> Outcome {
    let mut files = StagedFolder::new(folder)?;
    let heightmap = mapped.scene.heightmap();
    let heightmap = drawing::perceived("Heightmap (grey: unknown)", grid, heightmap)?;
    files.add("heightmap.png", &heightmap)?;
    files.add("surface.png", &surface(grid, mapped)?)?;
    let summary = serde_json::to_vec_pretty(summary).or_run()?;
    files.add("summary.json", &summary)?;
    Ok(files.publish()?)
}

/// Draws the surface that the heightmap was made of, as a PNG. What is hidden is grey.
fn surface(grid: &Grid, mapped: &Mapped) -> anyhow::Result<Vec<u8>> {
    let surface = mapped.scene.surface().context("the scene has no surface")?;
    // What is unknown without any line of sight is above the rim by less than a unit.
    let rim_m = grid.container().z_m;
    let unit_m = grid.resolution().height_unit_m();
    let samples = surface.heights_m().iter().zip(surface.support_m());
    let heights_m = samples.map(|(height_m, held_m)| {
        let is_bound = held_m < height_m;
        let height_m = f64::from(*height_m);
        let is_unknown = height_m > rim_m && height_m < rim_m + unit_m;
        if is_bound || is_unknown {
            f64::NAN
        } else {
            height_m
        }
    });
    let heights_m: Vec<f64> = heights_m.collect();
    let field = HeightField {
        nx: surface.nx(),
        ny: surface.ny(),
        cell_m: surface.pitch_m(),
        heights_m: &heights_m,
        scale_top_m: Some(rim_m),
    };
    let image = ppnpack_picture::heightmap("Surface (grey: hidden)", &field);
    Ok(image.context("the heightmap cannot be drawn")?.to_png()?)
}
