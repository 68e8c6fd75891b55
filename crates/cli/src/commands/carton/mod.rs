//! `ppnpack carton`: finds the smallest carton that takes an order whole.

mod answer;
mod attempt;
mod search;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::anyhow;
use clap::Args;
use ppnpack_catalogue::cartons::{self, Carton};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::orders::{self, Order};
use ppnpack_packing::kernel::grid::GridSettings;
use ppnpack_packing::planning::method::Method;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_physics::packing_cell::Sampling;
use ppnpack_physics::settings::CellSettings;

use self::answer::Answer;
use self::search::{Found, Open, Search};
use crate::failure::{Failure, OrInput, Outcome};
use crate::options::{CatalogueOptions, Simulated};
use crate::output::{self, print_line};
use crate::quantity::parse_length;
use crate::report::{self, MethodWithArm, PAGE_FILE, Packing, Settings};
use crate::sequence::Sequence;
use crate::text::template;

/// The plan of the chosen carton, beside the report.
const PLAN_FILE: &str = "plan.json";

const EXAMPLES: &str = "\
Examples:
  ppnpack carton --order order.csv --cartons cartons.csv
  ppnpack carton --order orders.csv:1003 --cartons cartons.csv --out out/carton --json

order.csv:             cartons.csv:
  item,quantity          name,x,y,z,unit,max_kg
  mug,2                  S,20,15,10,cm,2
  bowl,1                 M,30,20,15,cm,";

/// Finds the smallest of some cartons, by volume, in which all items of an order can be packed one
/// after another, each where it stays, and says how; of each smaller one it says why it does not
/// do.
///
/// All items are known, so that each step may choose among all. Placements are tried in the
/// simulated cell, and a plan that was found is done again there, a millimetre beside its places.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, mut_arg("poses", |poses| poses.default_value("4")))]
pub(crate) struct CartonArguments {
    /// The order: a CSV file with `item` and `quantity` (or `object` and `count`); where it has the
    /// column `order` and several orders, with the name of one behind it
    #[arg(long, value_name = "FILE[:NAME]")]
    order: PathBuf,

    /// The cartons there are: a CSV file with `name`, the inner lengths `x`, `y`, `z`, and where
    /// wanted `unit` (m, cm, mm, in; else metres) and `max_kg`, the most that one may hold
    #[arg(long, value_name = "FILE")]
    cartons: PathBuf,

    #[command(flatten)]
    catalogue: CatalogueOptions,

    #[command(flatten)]
    search: SearchOptions,

    #[command(flatten)]
    results: ResultOptions,
}

/// The effort of the search.
#[derive(Debug, Args)]
#[command(next_help_heading = "Search")]
struct SearchOptions {
    /// How many sequences of the items are tried in a carton at most, before the next larger one
    /// is chosen
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    sequences: u32,

    /// The edge of a grid cell
    #[arg(long, value_name = "LENGTH", default_value = "5mm", value_parser = parse_length, allow_hyphen_values = true)]
    cell: f64,

    /// How many yaws, evenly over half a turn
    #[arg(long, value_name = "COUNT", default_value_t = 8)]
    yaws: usize,

    /// The seed of everything that is random: the same finds the same
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
}

/// Destination of the answer.
#[derive(Debug, Args)]
#[command(next_help_heading = "Results")]
struct ResultOptions {
    /// The folder for plan.json, pictures and report of the chosen carton [default: none]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print the answer with the plan as JSON instead of tables
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &CartonArguments) -> Outcome {
    let began = Instant::now();
    let cartons = cartons::read(&arguments.cartons).or_input()?;
    let grid = GridSettings {
        cell_m: arguments.search.cell,
        yaws: arguments.search.yaws,
        ..GridSettings::default()
    };
    let open: Vec<Open<'_>> = cartons
        .iter()
        .map(|carton| arguments.open(carton, grid))
        .collect::<Outcome<_>>()?;
    let catalogue = arguments.catalogue.load(&grid.resolution().or_input()?)?;
    let order = arguments.order(&catalogue)?;
    let poses = arguments.catalogue.poses;
    let method = Method {
        seed: arguments.search.seed,
        buffer: order.items.len(),
        ..Method::default().for_poses(poses as usize)
    };
    let items = candidates(&catalogue, &order);
    let search = Search {
        catalogue: &catalogue,
        method: &method,
        items: &items,
        sequences: arguments.search.sequences,
    };
    let found = search.smallest(&open)?;
    let answer = Answer::of(&order.name, &search, &open, &found, began.elapsed());
    let chosen = found
        .into_iter()
        .zip(&open)
        .find_map(|(found, open)| match found {
            Found::Does(_, tried) => Some((tried, open)),
            _ => None,
        });
    if let (Some(folder), Some((tried, open))) = (&arguments.results.out, chosen) {
        let settings = arguments.settings(&catalogue, &order, open, method);
        let packing = Packing::of(settings, tried.episode, &tried.cell, began.elapsed());
        let plan = serde_json::to_vec_pretty(&answer).map_err(anyhow::Error::from)?;
        let further = Some((PLAN_FILE, &*plan));
        report::write(&packing, &packing.summary(), folder, further)?;
    }
    output::print(&answer, arguments.results.json, template!("carton.txt"))?;
    if let Some(failure) = answer.failure() {
        return Err(Failure::Run(anyhow!(failure)));
    }
    if let Some(folder) = arguments
        .results
        .out
        .as_ref()
        .filter(|_| !arguments.results.json)
    {
        print_line(&format!("Report: {}", folder.join(PAGE_FILE).display()))?;
    }
    Ok(())
}

impl CartonArguments {
    /// Puts a carton on its grid.
    fn open<'a>(&self, carton: &'a Carton, grid: GridSettings) -> Outcome<Open<'a>> {
        let wrong = |error: &dyn std::fmt::Display| {
            let path = self.cartons.display();
            Failure::input(format_args!("{path}, carton '{}': {error}", carton.name))
        };
        let grid = GridSettings {
            container: carton.size,
            ..grid
        };
        let grid = grid.build().map_err(|error| wrong(&error))?;
        let cell = CellSettings {
            container: carton.size,
            seed: self.search.seed,
            ..CellSettings::robot()
        };
        cell.validate().map_err(|error| wrong(&error))?;
        let simulated = Simulated {
            scan: Sampling::Greatest,
            camera: None,
            preloaded: None,
            cell,
        };
        Ok(Open {
            carton,
            grid,
            simulated,
        })
    }

    /// Reads the order, which has to be one, and whole.
    fn order(&self, catalogue: &Catalogue) -> Outcome<Order> {
        let (path, name) = self.named();
        let read = orders::read(path, catalogue).or_input()?;
        let names: Vec<String> = read.iter().map(|order| order.name.to_string()).collect();
        let is_asked = |order: &Order| name.is_none_or(|name| *order.name == *name);
        let mut asked = read.into_iter().filter(is_asked);
        let (Some(order), None) = (asked.next(), asked.next()) else {
            return Err(Failure::input(format_args!(
                "--order {}: name one of its orders behind a colon: {}",
                self.order.display(),
                names.join(", ")
            )));
        };
        if order.expected > order.items.len() {
            return Err(Failure::input(format_args!(
                "--order {}: order {} is said to have {} items, but has {}: all have to be known",
                self.order.display(),
                order.name,
                order.expected,
                order.items.len()
            )));
        }
        Ok(order)
    }

    /// Parts the file of the order from the name of one, where it has one.
    fn named(&self) -> (&Path, Option<&str>) {
        let parts = self.order.to_str().and_then(|text| text.rsplit_once(':'));
        match parts {
            Some((path, name)) if !self.order.exists() => (Path::new(path), Some(name)),
            _ => (&self.order, None),
        }
    }

    /// Gives everything that the packing depends on.
    fn settings(
        &self,
        catalogue: &Catalogue,
        order: &Order,
        open: &Open<'_>,
        method: Method,
    ) -> Settings {
        Settings {
            catalogue: self.catalogue.catalogue.clone(),
            catalogue_hash: catalogue.content_hash(),
            objects: catalogue.len(),
            poses: self.catalogue.poses,
            sequence: Sequence {
                from: format!("order {} in carton {}", order.name, open.carton.name),
                objects: order.items.iter().map(|item| item.object).collect(),
            },
            set_aside: 0,
            grid: open.grid.clone(),
            method: MethodWithArm { method, arm: None },
            simulated: open.simulated.clone(),
        }
    }
}

/// Gives the items of an order in the order of the table, each in all of its poses.
fn candidates(catalogue: &Catalogue, order: &Order) -> Vec<Candidate> {
    let items = order
        .items
        .iter()
        .enumerate()
        .filter_map(|(arrival, item)| {
            let mut poses = catalogue.get(item.object)?.candidates(arrival);
            for held in &mut poses {
                held.mass_kg = item.item.mass_kg;
                held.stop = item.stop;
            }
            Some(poses)
        });
    items.flatten().collect()
}
