//! GLB, the binary form of glTF 2: triangles of all nodes of the scene, z up.

use nalgebra::{Matrix4, Point3, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::add;
use super::polygons::{Polygons, fan, strip};
use crate::mesh::Mesh;

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct File {
    scene: usize,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Primitives>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    extensions_required: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Node {
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: [f64; 3],
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Primitives {
    primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    mode: Option<u32>,
}

#[derive(Debug, Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    #[serde(default)]
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let rest = bytes
        .strip_prefix(b"glTF")
        .ok_or("it does not begin with 'glTF'")?;
    if rest.starts_with(&[1, 0, 0, 0]) {
        return Err("it is of version 1 of the format: export it in version 2".to_owned());
    }
    let (json, rest) = chunk(rest.get(8..).unwrap_or_default(), b"JSON")
        .ok_or("its part of JSON is missing or cut")?;
    let (data, _) = chunk(rest, b"BIN\0").ok_or("its part of numbers is missing or cut")?;
    let file: File = serde_json::from_slice(json).map_err(|error| error.to_string())?;
    let changed = ["draco", "meshopt", "quantization"];
    let extension = file.extensions_required.iter();
    let mut extension = extension.filter(|name| changed.iter().any(|kind| name.contains(kind)));
    if let Some(name) = extension.next() {
        return Err(format!(
            "it is compressed by {name}: export it without compression"
        ));
    }
    // Heights are along y in the format.
    let upright = Matrix4::new(
        1.0, 0.0, 0.0, 0.0, //
        0.0, 0.0, -1.0, 0.0, //
        0.0, 1.0, 0.0, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    );
    let roots: Vec<usize> = match file.scenes.get(file.scene) {
        Some(scene) => scene.nodes.clone(),
        None => {
            let mut is_root = vec![true; file.nodes.len()];
            for child in file.nodes.iter().flat_map(|node| &node.children) {
                is_root
                    .get_mut(*child)
                    .into_iter()
                    .for_each(|is_root| *is_root = false);
            }
            let nodes = (0..).zip(is_root);
            nodes
                .filter_map(|(node, is_root)| is_root.then_some(node))
                .collect()
        }
    };
    let mut open: Vec<(usize, Matrix4<f64>)> = roots.iter().map(|root| (*root, upright)).collect();
    let mut mesh = Mesh::default();
    let mut visited = 0;
    while let Some((index, parent)) = open.pop() {
        let node = file
            .nodes
            .get(index)
            .ok_or("it names a node that is not there")?;
        visited += 1;
        if visited + open.len() > file.nodes.len() {
            return Err("a node of it is in two places".to_owned());
        }
        let pose = parent * node.pose();
        if let Some(index) = node.mesh {
            let part = file
                .meshes
                .get(index)
                .ok_or("it names a mesh that is not there")?;
            for primitive in &part.primitives {
                add(&mut mesh, &file.triangles(primitive, data)?, &pose)?;
            }
        }
        open.extend(node.children.iter().map(|child| (*child, pose)));
    }
    Ok(mesh)
}

/// Gives the content of a chunk of a kind, and what follows it.
fn chunk<'a>(bytes: &'a [u8], kind: &[u8; 4]) -> Option<(&'a [u8], &'a [u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.strip_prefix(kind)?
        .split_at_checked(u32::from_le_bytes(*length) as usize)
}

impl Node {
    fn pose(&self) -> Matrix4<f64> {
        if let Some(columns) = self.matrix {
            return Matrix4::from_column_slice(&columns);
        }
        let [x, y, z, w] = self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Matrix4::new_translation(&Vector3::from(self.translation))
            * rotation.to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::from(self.scale.unwrap_or([1.0; 3])))
    }
}

impl File {
    /// Gives the triangles of a primitive; none of points and lines.
    fn triangles(&self, primitive: &Primitive, data: &[u8]) -> Result<Mesh, String> {
        let position = primitive.attributes.position;
        let numbers = position.map(|position| self.numbers(position, 3, data));
        let numbers = numbers.transpose()?.unwrap_or_default();
        let (points, _) = numbers.as_chunks::<3>();
        let corners: Vec<u32> = match primitive.indices {
            None => (0..points.len() as u32).collect(),
            Some(indices) => {
                let numbers = self.numbers(indices, 1, data)?;
                numbers.iter().map(|number| *number as u32).collect()
            }
        };
        let mut polygons = Polygons::default();
        polygons.vertices = points.iter().map(|point| Point3::from(*point)).collect();
        match primitive.mode.unwrap_or(4) {
            4 => {
                let (triangles, _) = corners.as_chunks::<3>();
                triangles
                    .iter()
                    .for_each(|triangle| polygons.push(*triangle));
            }
            5 => strip(&corners).for_each(|triangle| polygons.push(triangle)),
            6 => fan(&corners).for_each(|triangle| polygons.push(triangle)),
            _ => {}
        }
        polygons.triangulated()
    }

    /// Gives the numbers of an accessor, so many of each element.
    fn numbers(&self, index: usize, each: usize, data: &[u8]) -> Result<Vec<f64>, String> {
        let accessor = self.accessors.get(index);
        let accessor = accessor.ok_or("it names an accessor that is not there")?;
        let view = accessor
            .buffer_view
            .and_then(|view| self.buffer_views.get(view));
        let view = view.filter(|view| view.buffer == 0 && accessor.sparse.is_none());
        let view = view.ok_or("its numbers are sparse or in another file: export it whole")?;
        let cut = || "it ends within its numbers".to_owned();
        let view_data = data
            .get(view.byte_offset..)
            .and_then(|rest| rest.get(..view.byte_length));
        let size = match accessor.component_type {
            5121 => 1,
            5123 => 2,
            5125 | 5126 => 4,
            other => return Err(format!("its numbers are of the unknown type {other}")),
        };
        let stride = view.byte_stride.unwrap_or(size * each).max(1);
        let mut rest = view_data
            .and_then(|data| data.get(accessor.byte_offset..))
            .ok_or_else(cut)?;
        let mut numbers = Vec::new();
        for _ in 0..accessor.count {
            let element = rest.get(..size * each).ok_or_else(cut)?;
            numbers.extend(element.chunks(size).map(|bytes| match *bytes {
                [a, b, c, d] if accessor.component_type == 5126 => {
                    f32::from_le_bytes([a, b, c, d]).into()
                }
                [a, b, c, d] => u32::from_le_bytes([a, b, c, d]).into(),
                [a, b] => u16::from_le_bytes([a, b]).into(),
                [a] => a.into(),
                _ => f64::NAN,
            }));
            rest = rest.get(stride..).unwrap_or_default();
        }
        Ok(numbers)
    }
}
