//! `visualization_msgs`: what `RViz` draws.

use super::builtin_interfaces::Duration;
use super::geometry_msgs::{Point, Pose, Vector3};
use super::messages;
use super::sensor_msgs::CompressedImage;
use super::std_msgs::{ColorRgba, Header};
use crate::cdr::Bytes;

messages! {
    /// A place in a texture.
    UvCoordinate = "visualization_msgs/msg/UVCoordinate" {
        /// Across.
        u: f32,
        /// Down.
        v: f32,
    }

    /// A mesh as a file.
    MeshFile = "visualization_msgs/msg/MeshFile" {
        /// Its name.
        filename: String,
        /// The file.
        data: Bytes,
    }

    /// Something that is drawn.
    Marker = "visualization_msgs/msg/Marker" {
        /// When it was so, and in which frame.
        header: Header,
        /// The namespace of its number.
        ns: String,
        /// Tells it from others of its namespace.
        id: i32,
        /// What it is.
        r#type: i32,
        /// Whether it is drawn or taken away.
        action: i32,
        /// Where it is.
        pose: Pose,
        /// How large it is, in metres; what that means depends on what it is.
        scale: Vector3,
        /// Its colour.
        color: ColorRgba,
        /// How long it stays; zero for ever.
        lifetime: Duration,
        /// Whether it goes where its frame goes.
        frame_locked: bool,
        /// The points of lists.
        points: Vec<Point>,
        /// Their colours.
        colors: Vec<ColorRgba>,
        /// Where its texture is.
        texture_resource: String,
        /// Its texture.
        texture: CompressedImage,
        /// Where its points are in the texture.
        uv_coordinates: Vec<UvCoordinate>,
        /// The text of a text.
        text: String,
        /// Where its mesh is.
        mesh_resource: String,
        /// Its mesh.
        mesh_file: MeshFile,
        /// Whether the mesh's own colours are used.
        mesh_use_embedded_materials: bool,
    }

    /// Several things that are drawn.
    MarkerArray = "visualization_msgs/msg/MarkerArray" {
        /// Each of them.
        markers: Vec<Marker>,
    }
}

impl Marker {
    /// A box; its scale is its size.
    pub const CUBE: i32 = 1;
    /// Points that are joined one after the other; x of its scale is the width.
    pub const LINE_STRIP: i32 = 4;
    /// Points that are joined in pairs; x of its scale is the width.
    pub const LINE_LIST: i32 = 5;
    /// A text that faces the viewer; z of its scale is the height of a capital.
    pub const TEXT_VIEW_FACING: i32 = 9;
    /// Points that are the corners of triangles, in threes.
    pub const TRIANGLE_LIST: i32 = 11;
    /// It is drawn.
    pub const ADD: i32 = 0;
    /// All are taken away.
    pub const DELETEALL: i32 = 3;
}
