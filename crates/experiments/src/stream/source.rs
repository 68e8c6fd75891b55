//! The streams: of sequences, or of orders.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::orders::{self, Order, OrderedObject};
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::sequence::{Sequence, SequenceFile};
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::leaving::Stop;
use ppnpack_packing::streams::orders::OrderItem;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cases::cases;
use crate::runs::hash;

/// The items of an order that is drawn.
const DRAWN_ITEMS: std::ops::RangeInclusive<usize> = 5..=30;

/// Source of streams.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(super) struct SourceOptions {
    /// A .npy file of sequences, int64 [sequences, length], of object indices; a stream is as many
    /// of them as it takes, in their order
    #[arg(long, value_name = "FILE")]
    sequences: Option<PathBuf>,

    /// A CSV file of orders: order, item, quantity, group, mass (kg), priority, stop, order_items.
    /// They come one after another, the items of each in another order in each stream
    #[arg(long, value_name = "FILE")]
    orders: Option<PathBuf>,

    /// Orders of 5 to 30 objects of the catalogue, others in each stream
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    draw_orders: Option<u32>,
}

#[derive(Default)]
pub(super) struct Arrivals {
    pub(super) number: u32,
    pub(super) objects: Vec<usize>,
    pub(super) orders: Vec<OrderItem>,
    /// At which stops they leave, where they are of orders.
    pub(super) stops: Vec<Stop>,
    pub(super) expected: Vec<(Arc<str>, usize)>,
}

impl SourceOptions {
    pub(super) fn has_orders(&self) -> bool {
        self.sequences.is_none()
    }

    pub(super) fn said(&self, items: u32) -> String {
        match (&self.orders, self.draw_orders) {
            (Some(path), _) => format!("the orders of {}", path.display()),
            (None, Some(count)) => format!("{count} orders of 5 to 30 items, drawn at random"),
            (None, None) => format!("{items} items"),
        }
    }

    /// The streams of these numbers; those of sequences have so many items.
    pub(super) fn streams(
        &self,
        catalogue: &Catalogue,
        numbers: Range<u32>,
        items: u32,
    ) -> Outcome<Vec<Arrivals>> {
        if let Some(path) = &self.sequences {
            let file = SequenceFile::read(path, catalogue)?;
            return of_sequences(&file, path, numbers, items as usize);
        }
        let read = match &self.orders {
            Some(path) => orders::read(path, catalogue).or_input()?,
            None => Vec::new(),
        };
        let stream = |number: u32| {
            let mut random = ChaCha8Rng::seed_from_u64(u64::from(number));
            let orders = match self.draw_orders {
                Some(count) => draw(catalogue, count, &mut random),
                None => read.clone(),
            };
            of_orders(number, orders, &mut random)
        };
        Ok(numbers.map(stream).collect())
    }
}

impl Arrivals {
    pub(super) fn name(&self) -> String {
        // What is known of the items decides, too.
        let known = format!("{:?}", (&self.orders, &self.stops, &self.expected));
        format!("{:05}-{}", self.number, hash(known.as_bytes(), 8))
    }

    /// The items in the order of their arrival, each in all of its poses.
    pub(super) fn candidates(&self, catalogue: &Catalogue) -> Vec<Candidate> {
        let sequence = Sequence {
            from: String::new(),
            objects: self.objects.clone(),
        };
        let mut candidates = sequence.candidates(catalogue);
        for held in &mut candidates {
            held.stop = self.stops.get(held.arrival).copied().unwrap_or_default();
        }
        candidates
    }
}

/// Streams that are each made of as many sequences of the file as it takes.
fn of_sequences(
    file: &SequenceFile,
    path: &Path,
    numbers: Range<u32>,
    items: usize,
) -> Outcome<Vec<Arrivals>> {
    let length = file.get(0)?.objects.len().max(1);
    let sequences = u32::try_from(items.div_ceil(length)).unwrap_or(u32::MAX);
    let available = file.count() / (sequences as usize).max(1);
    if numbers.end as usize > available {
        return Err(Failure::input(format_args!(
            "--first {} --streams {}: {} has enough for {available} streams of {items} items, numbered from 0",
            numbers.start,
            numbers.len(),
            path.display()
        )));
    }
    let stream = |number: u32| {
        let parts = cases(file, number.saturating_mul(sequences), sequences)?;
        let objects = parts.into_iter().flat_map(|part| part.sequence.objects);
        Ok(Arrivals {
            number,
            objects: objects.take(items).collect(),
            ..Arrivals::default()
        })
    };
    numbers.map(stream).collect()
}

fn of_orders(number: u32, orders: Vec<Order>, random: &mut ChaCha8Rng) -> Arrivals {
    let expected = orders.iter();
    let expected = expected.map(|order| {
        let items = order.expected.max(order.items.len());
        (Arc::clone(&order.name), items)
    });
    let expected = expected.collect();
    let mut arriving: Vec<OrderedObject> = Vec::new();
    for mut order in orders {
        order.items.shuffle(random);
        arriving.extend(order.items);
    }
    Arrivals {
        number,
        expected,
        objects: arriving.iter().map(|item| item.object).collect(),
        stops: arriving.iter().map(|item| item.stop).collect(),
        orders: arriving.into_iter().map(|item| item.item).collect(),
    }
}

fn draw(catalogue: &Catalogue, count: u32, random: &mut ChaCha8Rng) -> Vec<Order> {
    let order = |number: u32| {
        let mut order = Order::new(&format!("order-{number}"));
        for _ in 0..random.random_range(DRAWN_ITEMS) {
            order.add(catalogue, random.random_range(0..catalogue.len()));
        }
        order
    };
    (0..count).map(order).collect()
}
