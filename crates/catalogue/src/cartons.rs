//! Tables of cartons: the containers of a shop, by name.

use std::path::Path;

use ppnpack_packing::kernel::grid::ContainerSize;
use serde::Deserialize;

use crate::rows::{self, TableError};
use crate::unit::LengthUnit;

/// Maximum inner length of a carton, in metres: above it the unit is most likely wrong.
const MOST_SIDE_M: f64 = 5.0;

/// Columns that are read.
const COLUMNS: &[&str] = &["name", "x", "y", "z", "unit", "max_kg"];

/// A line of the table; other columns are ignored.
#[derive(Debug, Deserialize)]
struct Row {
    name: String,
    x: f64,
    y: f64,
    z: f64,
    unit: Option<String>,
    max_kg: Option<f64>,
}

/// A size of carton that there is.
#[derive(Debug, Clone, PartialEq)]
pub struct Carton {
    /// Its name.
    pub name: String,
    /// Its inner size.
    pub size: ContainerSize,
    /// The greatest mass that it may hold, in kilograms, where it has a limit.
    pub max_kg: Option<f64>,
}

impl Carton {
    fn of(row: Row) -> Result<Self, String> {
        if row.name.is_empty() {
            return Err("the column 'name' is empty: give each carton a name".to_owned());
        }
        let unit: Result<_, String> = row.unit.map(|unit| unit.parse()).transpose();
        let unit = unit.map_err(|error| format!("the column 'unit': {error}"))?;
        let unit: LengthUnit = unit.unwrap_or_default();
        let metres = |column: &str, length: f64| {
            let length_m = length * unit.metres();
            let is_possible = length_m > 0.0 && length_m <= MOST_SIDE_M;
            is_possible.then_some(length_m).ok_or_else(|| {
                format!(
                    "the column '{column}' has {length} {unit}: it must be above 0 and at most \
                     {MOST_SIDE_M} m; the column 'unit' names the unit"
                )
            })
        };
        if let Some(max_kg) = row.max_kg
            && !(max_kg.is_finite() && max_kg > 0.0)
        {
            return Err(format!(
                "the column 'max_kg' has {max_kg}: it must be above 0, or empty"
            ));
        }
        Ok(Self {
            size: ContainerSize::cuboid(
                metres("x", row.x)?,
                metres("y", row.y)?,
                metres("z", row.z)?,
            ),
            name: row.name,
            max_kg: row.max_kg,
        })
    }
}

/// Reads cartons: CSV with the columns `name`, `x`, `y` and `z` (inner lengths, z up) and, where
/// they are wanted, `unit` (m, cm, mm or in; else metres) and `max_kg`. They come by volume, the
/// smallest first, equal ones as in the table.
pub fn read(path: &Path) -> Result<Vec<Carton>, TableError> {
    let mut cartons: Vec<Carton> = Vec::new();
    let needed = "the columns 'name', 'x', 'y' and 'z' are needed";
    rows::read(path, COLUMNS, needed, |row: Row| {
        let carton = Carton::of(row)?;
        if cartons.iter().any(|other| other.name == carton.name) {
            return Err(format!(
                "the column 'name' has '{}' again: give each carton its own",
                carton.name
            ));
        }
        cartons.push(carton);
        Ok(())
    })?;
    cartons.sort_by(|a, b| a.size.volume_m3().total_cmp(&b.size.volume_m3()));
    Ok(cartons)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cartons(table: &str) -> Result<Vec<Carton>, TableError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cartons.csv");
        std::fs::write(&path, table).unwrap();
        read(&path)
    }

    #[test]
    fn cartons_come_by_volume_in_metres() {
        let read = cartons("name;x;y;z;unit;max_kg\nL;40;30;20,5;cm;\nS;200;150;100;mm;2,5\n");
        let [small, large] = &read.unwrap()[..] else {
            panic!("two cartons");
        };
        assert_eq!((&*small.name, small.max_kg), ("S", Some(2.5)));
        assert!((small.size.volume_m3() - 0.003).abs() < 1e-12);
        assert_eq!((&*large.name, large.max_kg), ("L", None));
        assert!((large.size.z_m - 0.205).abs() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_column() {
        for (table, reason) in [
            ("name,x,y\nS,1,1\n", "'x', 'y' and 'z' are needed"),
            (
                "name,x,y,z\nS,0.1,wide,0.1\n",
                "line 2: the column 'y' has 'wide'",
            ),
            (
                "name,x,y,z\nS,0.1,-1,0.1\n",
                "line 2: the column 'y' has -1 m",
            ),
            (
                "name,x,y,z\nS,30,20,10\n",
                "the column 'unit' names the unit",
            ),
            ("name,x,y,z\nS,NaN,1,1\n", "the column 'x' has NaN m"),
            ("name,x,y,z,unit\nS,1,1,1,ell\n", "the column 'unit': 'ell'"),
            (
                "name,x,y,z,max_kg\nS,1,1,1,0\n",
                "the column 'max_kg' has 0",
            ),
            (
                "name,x,y,z\nS,1,1,1\nS,2,2,2\n",
                "line 3: the column 'name' has 'S' again",
            ),
            ("name,x,y,z\n,1,1,1\n", "line 2: the column 'name' is empty"),
            ("name,x,y,z\n", "has no line below its header"),
        ] {
            let error = cartons(table).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}
