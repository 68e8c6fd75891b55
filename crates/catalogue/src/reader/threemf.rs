//! 3MF: all objects that are to be built, in millimetres.

use std::collections::HashMap;
use std::io::{Cursor, Read};

use nalgebra::{Matrix4, Point3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use zip::ZipArchive;

use super::polygons::Polygons;
use super::{MAX_FILE_BYTES, add};
use crate::mesh::Mesh;

/// Objects that are made of others are at most so deep.
const MAX_DEPTH: usize = 16;

/// Objects are in at most so many places.
const MAX_PLACES: usize = 100_000;

/// Name of an object: its part of the file, and its number there.
type Id = (String, String);

#[derive(Debug, Default)]
struct Object {
    mesh: Mesh,
    parts: Vec<Placed>,
}

/// An object in its place.
#[derive(Debug)]
struct Placed {
    id: Id,
    pose: Matrix4<f64>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let mut objects = HashMap::new();
    let mut built = Vec::new();
    // Counted while unpacking, since what an archive says of a length need not hold.
    let mut room = MAX_FILE_BYTES;
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|error| error.to_string())?;
        let name = file.name().trim_start_matches('/').to_ascii_lowercase();
        if !name.ends_with(".model") {
            continue;
        }
        let mut text = Vec::new();
        let read = file.take(room).read_to_end(&mut text);
        room -= read.map_err(|error| error.to_string())? as u64;
        if room == 0 {
            return Err("it is too large: reduce its triangles".to_owned());
        }
        model(
            &name,
            &String::from_utf8_lossy(&text),
            &mut objects,
            &mut built,
        )?;
    }
    let mut mesh = Mesh::default();
    let upright = built.iter().map(|placed| (placed, Matrix4::identity(), 0));
    let mut open: Vec<(&Placed, Matrix4<f64>, usize)> = upright.collect();
    let mut places = 0;
    while let Some((placed, parent, depth)) = open.pop() {
        let object = objects.get(&placed.id);
        let object = object.ok_or_else(|| format!("it has no object {} to build", placed.id.1))?;
        places += 1;
        if depth > MAX_DEPTH || places + open.len() + object.parts.len() > MAX_PLACES {
            return Err("its objects are made of too many others".to_owned());
        }
        let pose = parent * placed.pose;
        add(&mut mesh, &object.mesh, &pose)?;
        open.extend(object.parts.iter().map(|part| (part, pose, depth + 1)));
    }
    Ok(mesh)
}

/// Reads a part of the file.
fn model(
    name: &str,
    text: &str,
    objects: &mut HashMap<Id, Object>,
    built: &mut Vec<Placed>,
) -> Result<(), String> {
    let mut reader = Reader::from_str(text);
    let mut unit_mm = 1.0;
    let mut current = (String::new(), Object::default(), Polygons::default());
    loop {
        let event = reader.read_event().map_err(|error| error.to_string())?;
        let tag = match &event {
            Event::Start(tag) | Event::Empty(tag) => tag,
            Event::End(tag) if tag.local_name().as_ref() == "object" => {
                let (id, mut object, polygons) = std::mem::take(&mut current);
                object.mesh = polygons.triangulated()?;
                for vertex in &mut object.mesh.vertices {
                    *vertex *= unit_mm;
                }
                objects.insert((name.to_owned(), id), object);
                continue;
            }
            Event::Eof => return Ok(()),
            _ => continue,
        };
        let (id, object, polygons) = &mut current;
        match tag.local_name().as_ref() {
            "model" => {
                unit_mm = match attribute(tag, "unit").as_deref() {
                    None | Some("millimeter") => 1.0,
                    Some("micron") => 0.001,
                    Some("centimeter") => 10.0,
                    Some("inch") => 25.4,
                    Some("foot") => 304.8,
                    Some("meter") => 1000.0,
                    Some(other) => return Err(format!("its unit is '{other}'")),
                };
            }
            "object" => *id = attribute(tag, "id").unwrap_or_default(),
            "vertex" => {
                let [x, y, z] = ["x", "y", "z"].map(|side| attribute(tag, side));
                let number = |text: Option<String>| text.and_then(|text| text.trim().parse().ok());
                let vertex = [x, y, z].map(|side| number(side).unwrap_or(f64::NAN));
                polygons.vertices.push(Point3::from(vertex));
            }
            "triangle" => {
                let corners = ["v1", "v2", "v3"].map(|corner| attribute(tag, corner));
                // One that is missing is found by the check of the mesh.
                let index = |text: Option<String>| text.and_then(|text| text.trim().parse().ok());
                polygons.push(corners.map(|corner| index(corner).unwrap_or(u32::MAX)));
            }
            "component" => object.parts.push(placed(tag, name, unit_mm)?),
            "item" => built.push(placed(tag, name, unit_mm)?),
            _ => {}
        }
    }
}

/// Reads which object a tag names, and where it is, by the twelve numbers of a matrix whose rows
/// are images of the axes.
fn placed(tag: &BytesStart<'_>, name: &str, unit_mm: f64) -> Result<Placed, String> {
    let path = attribute(tag, "path").map(|path| path.trim_start_matches('/').to_ascii_lowercase());
    let id = (
        path.unwrap_or_else(|| name.to_owned()),
        attribute(tag, "objectid").unwrap_or_default(),
    );
    let mut pose = Matrix4::identity();
    if let Some(transform) = attribute(tag, "transform") {
        let numbers = transform.split_ascii_whitespace().map(str::parse);
        let numbers: Vec<f64> = numbers
            .collect::<Result<_, _>>()
            .ok()
            .filter(|numbers: &Vec<f64>| numbers.len() == 12)
            .ok_or_else(|| format!("its transform '{transform}' is not 12 numbers"))?;
        for (at, number) in numbers.into_iter().enumerate() {
            let scale = if at >= 9 { unit_mm } else { 1.0 };
            if let Some(place) = pose.get_mut((at % 3, at / 3)) {
                *place = number * scale;
            }
        }
    }
    Ok(Placed { id, pose })
}

/// Gives an attribute, whatever its namespace.
fn attribute(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let mut attributes = tag.attributes();
    let mut attributes = attributes.with_checks(false).flatten();
    let found = attributes.find(|attribute| attribute.key.local_name().as_ref() == name)?;
    Some(found.value.into_owned())
}
