//! Orders of a table: which objects belong together, and what is known of each beside its shape.

use std::path::Path;
use std::sync::Arc;

use ppnpack_packing::scene::leaving::Stop;
use ppnpack_packing::streams::orders::OrderItem;
use serde::Deserialize;

use crate::catalogue::Catalogue;
use crate::rows::{self, TableError};

/// The most items of a table.
const MOST_ITEMS: usize = 100_000;

/// Its columns that are read.
const COLUMNS: &[&str] = &[
    "order",
    "item",
    "object",
    "quantity",
    "count",
    "group",
    "mass",
    "mass_kg",
    "priority",
    "stop",
    "order_items",
];

/// A line of the table. Other columns are ignored, and what is empty is as if it were not there.
#[derive(Debug, Deserialize)]
struct Row {
    #[serde(default = "only_order")]
    order: String,
    #[serde(alias = "object")]
    item: String,
    #[serde(alias = "count")]
    quantity: Option<u32>,
    group: Option<String>,
    #[serde(alias = "mass_kg")]
    mass: Option<f64>,
    priority: Option<f64>,
    stop: Option<u32>,
    order_items: Option<usize>,
}

/// Name of the order in a table that has one only.
fn only_order() -> String {
    "1".to_owned()
}

/// An item of an order.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderedObject {
    /// The object, by its index in the catalogue.
    pub object: usize,
    /// Its order, group and mass. The mass is that of the table, of the catalogue where it has
    /// none.
    pub item: OrderItem,
    /// At which stop it leaves its container.
    pub stop: Stop,
}

/// An order with its items, in the order of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Its name.
    pub name: Arc<str>,
    /// Higher ones come first.
    pub priority: f64,
    /// How many items it has altogether, where it is said to have more than come.
    pub expected: usize,
    /// Its items, at least one.
    pub items: Vec<OrderedObject>,
}

impl Order {
    /// An order without items yet.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            priority: 0.0,
            expected: 0,
            items: Vec::new(),
        }
    }

    /// Adds an object with what the catalogue knows of it; nothing where it has none of that index.
    pub fn add(&mut self, catalogue: &Catalogue, object: usize) {
        let known = catalogue.get(object);
        self.items.extend(known.map(|known| OrderedObject {
            object,
            item: OrderItem {
                mass_kg: Some(known.model.mass.mass_kg),
                ..OrderItem::new(Arc::clone(&self.name))
            },
            stop: Stop::LAST,
        }));
    }
}

/// Reads orders: CSV with the column `item` (name of an object of the catalogue; or `object`) and,
/// where they are wanted, `order` (without it all lines are one), `quantity` (1; or `count`),
/// `group`, `mass` (kg, of one piece), `priority` (0; the highest of its lines is that of an
/// order), `stop` (from 1) and `order_items` (how many items the order has altogether, also those
/// that the table does not have). Lines of an order need not be together. Orders come by falling
/// priority, equal ones as they begin in the table.
pub fn read(path: &Path, catalogue: &Catalogue) -> Result<Vec<Order>, TableError> {
    let mut orders: Vec<Order> = Vec::new();
    let mut room = MOST_ITEMS;
    let needed = "the column 'item' is needed, and 'order' where there are several";
    rows::read(path, COLUMNS, needed, |row: Row| {
        room -= add(&mut orders, catalogue, &row, room)?;
        Ok(())
    })?;
    // Equal ones stay as they are.
    orders.sort_by(|a, b| b.priority.total_cmp(&a.priority));
    Ok(orders)
}

/// Adds a line, of so many items at most, to its order; gives how many it has.
fn add(
    orders: &mut Vec<Order>,
    catalogue: &Catalogue,
    row: &Row,
    room: usize,
) -> Result<usize, String> {
    let quantity = check(row)?;
    if quantity > room {
        return Err(format!("more than {MOST_ITEMS} items: divide the file"));
    }
    let (object, _) = catalogue.find(&row.item).ok_or_else(|| {
        format!(
            "the catalogue has no object '{}'; `ppnpack catalogue list` names them",
            row.item
        )
    })?;
    let known = orders.iter().position(|order| *order.name == *row.order);
    let at = known.unwrap_or_else(|| {
        orders.push(Order::new(&row.order));
        orders.len() - 1
    });
    let Some(order) = orders.get_mut(at) else {
        return Ok(0);
    };
    let priority = row.priority.unwrap_or(0.0);
    order.priority = match order.items.is_empty() {
        true => priority,
        false => order.priority.max(priority),
    };
    let first = order.items.len();
    for _ in 0..quantity {
        order.add(catalogue, object);
    }
    let expected = row.order_items.unwrap_or(0);
    order.expected = order.expected.max(expected);
    let group: Option<Arc<str>> = row.group.as_deref().map(Arc::from);
    for added in order.items.iter_mut().skip(first) {
        added.stop = Stop::new(row.stop);
        added.item.group.clone_from(&group);
        added.item.mass_kg = row.mass.or(added.item.mass_kg);
    }
    Ok(quantity)
}

/// Checks the numbers and names of a line; gives its quantity.
fn check(row: &Row) -> Result<usize, String> {
    if row.order.is_empty() || row.item.is_empty() {
        return Err("an order and an item are needed".to_owned());
    }
    if let Some(mass_kg) = row.mass
        && !(mass_kg.is_finite() && mass_kg > 0.0)
    {
        return Err(format!("a mass of {mass_kg} kg: it must be above 0"));
    }
    if row.priority.is_some_and(f64::is_nan) {
        return Err("the priority must be a number".to_owned());
    }
    if row.stop == Some(0) {
        return Err(
            "a stop of 0: stops count from 1; leave it empty where there is none".to_owned(),
        );
    }
    match row.quantity.unwrap_or(1) {
        0 => Err("a quantity of 0: leave the line out, or give at least 1".to_owned()),
        quantity => Ok(quantity as usize),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use ppnpack_packing::kernel::grid::Resolution;

    use super::*;
    use crate::cache::CacheDir;
    use crate::catalogue::{NamedMesh, Settings, Source};
    use crate::shapes;

    fn orders(table: &str) -> Result<Vec<Order>, TableError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("orders.csv");
        fs::write(&path, table).unwrap();
        let named = |name: &str, edge_m: f64| NamedMesh {
            name: name.to_owned(),
            mesh: shapes::cube(edge_m),
            density_kg_m3: 500.0,
        };
        let source = Source::Meshes([named("cube", 0.05), named("brick", 0.1)].into());
        let settings = Settings {
            cache: CacheDir::Nowhere,
            ..Settings::default()
        };
        let catalogue =
            Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| {}).unwrap();
        read(&path, &catalogue)
    }

    #[test]
    fn lines_of_an_order_are_put_together_and_urgent_orders_come_first() {
        let read = orders(
            "order,item,quantity,group,mass,priority\n\
             a,cube,2,food,0.5,\n\
             b,cube,,,,3\n\
             c,cube,1,,,\n\
             a,brick,1,,,\n",
        );
        let read = read.unwrap();
        let names: Vec<&str> = read.iter().map(|order| &*order.name).collect();
        assert_eq!(names, ["b", "a", "c"]);
        let a = &read[1];
        let objects: Vec<usize> = a.items.iter().map(|item| item.object).collect();
        assert_eq!(objects, [0, 0, 1]);
        assert_eq!(a.items[1].item.group.as_deref(), Some("food"));
        assert_eq!(a.items[1].item.mass_kg, Some(0.5));
        // What the table does not say is the catalogue's.
        assert_eq!(a.items[2].item.group, None);
        assert!(a.items[2].item.mass_kg.is_some_and(|mass_kg| mass_kg > 0.0));
    }

    #[test]
    fn a_table_without_orders_is_one() {
        let read = orders("Object;Count\ncube;2\nbrick;\n").unwrap();
        let [order] = &read[..] else {
            panic!("{read:?}");
        };
        let objects: Vec<usize> = order.items.iter().map(|item| item.object).collect();
        assert_eq!(objects, [0, 0, 1]);
    }

    #[test]
    fn what_leaves_when_is_read() {
        let read = orders("stop,order,item,order_items\n2,a,cube,\n,a,brick,4\n");
        let order = &read.unwrap()[0];
        let [cube, brick] = &order.items[..] else {
            panic!("{order:?}");
        };
        assert_eq!(order.expected, 4);
        assert_eq!((cube.stop, brick.stop), (Stop::new(Some(2)), Stop::LAST));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let wrong = [
            (
                "order,item\na,cube\na,teapot\n",
                "line 3: the catalogue has no object 'teapot'",
            ),
            ("order,item,quantity\na,cube,0\n", "line 2: a quantity of 0"),
            ("order,item,mass\na,cube,-1\n", "a mass of -1 kg"),
            (
                "order,item,priority\na,cube,NaN\n",
                "the priority must be a number",
            ),
            (
                "order,item,stop\na,cube,0\n",
                "line 2: a stop of 0: stops count from 1",
            ),
            ("order,item\n,cube\n", "an order and an item are needed"),
            (
                "order,thing\na,cube\n",
                "the column 'item' is needed, and 'order'",
            ),
            (
                "order,item,quantity\na,cube,two\n",
                "line 2: the column 'quantity' has 'two'",
            ),
            (
                "order,item,quantity\na,cube,200000\n",
                "more than 100000 items",
            ),
            ("order,item\n", "has no line below its header"),
        ];
        for (table, reason) in wrong {
            let error = orders(table).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}
