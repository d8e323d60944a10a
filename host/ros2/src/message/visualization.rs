//! `visualization_msgs`, with the fields of Humble and newer.

use serde::{Deserialize, Serialize};

use super::{ColorRgba, Duration, Header, Point, Pose, Vector3};

/// Kinds of markers that are used here, in the numbers of `Marker`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Shape {
    /// Points joined in their order.
    LineStrip = 4,
    /// Points joined in pairs.
    LineList = 5,
}

/// What is to be done with a marker, in the numbers of `Marker`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Action {
    /// Show it, instead of the one with the same name and number.
    Add = 0,
    /// Hide it.
    Delete = 2,
}

/// `visualization_msgs/msg/UVCoordinate`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct UvCoordinate {
    pub u: f32,
    pub v: f32,
}

/// `visualization_msgs/msg/MeshFile`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct MeshFile {
    pub filename: String,
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/Marker`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When, and in which frame.
    pub header: Header,
    /// Name of the group.
    pub ns: String,
    /// Number in the group.
    pub id: i32,
    /// A [`Shape`].
    pub r#type: i32,
    /// An [`Action`].
    pub action: i32,
    /// Of the marker in its frame.
    pub pose: Pose,
    /// A line's x is its thickness, m.
    pub scale: Vector3,
    /// Of the whole.
    pub color: ColorRgba,
    /// After this it disappears; 0: never.
    pub lifetime: Duration,
    /// It moves with its frame.
    pub frame_locked: bool,
    /// m.
    pub points: Vec<Point>,
    /// Per point, or none.
    pub colors: Vec<ColorRgba>,
    /// Not used here, as all that follow.
    pub texture_resource: String,
    /// An image.
    pub texture: CompressedImage,
    /// Where points are in the texture.
    pub uv_coordinates: Vec<UvCoordinate>,
    /// Letters.
    pub text: String,
    /// Where a mesh is.
    pub mesh_resource: String,
    /// A mesh.
    pub mesh_file: MeshFile,
    /// Whether its own colours are used.
    pub mesh_use_embedded_materials: bool,
}

/// `visualization_msgs/msg/MarkerArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct MarkerArray {
    pub markers: Vec<Marker>,
}
