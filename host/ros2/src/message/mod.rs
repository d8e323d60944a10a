//! Messages of ROS 2 (Humble and newer) as `serde` writes them: field by field in the order of their definitions.
//!
//! A type's DDS name is that of ROS 2, `geometry_msgs::msg::dds_::WrenchStamped_`; hashes of types are not sent.

mod control;
mod diagnostic;
mod geometry;
mod sensor;
mod standard;
mod trigger;
mod visualization;

pub use control::{DynamicJointState, InterfaceValue};
pub use diagnostic::{DiagnosticArray, DiagnosticStatus, KeyValue, Level};
pub use geometry::{Point, Pose, Quaternion, Vector3, Wrench, WrenchStamped};
pub use sensor::JointState;
pub use standard::{ColorRgba, Duration, Header, Time};
pub use trigger::{TriggerRequest, TriggerResponse};
pub use visualization::{Action, CompressedImage, Marker, MarkerArray, MeshFile, Shape, UvCoordinate};

/// A type of ROS 2: its package and its name there.
pub trait Named {
    /// As `geometry_msgs`.
    const PACKAGE: &'static str;
    /// As `WrenchStamped`.
    const NAME: &'static str;
}

macro_rules! named {
    ($($type:ident of $package:literal),* $(,)?) => {
        $(
            impl Named for $type {
                const PACKAGE: &'static str = $package;
                const NAME: &'static str = stringify!($type);
            }
            #[cfg(feature = "dds")]
            impl ros2_client::Message for $type {}
        )*
    };
}

named! {
    DiagnosticArray of "diagnostic_msgs",
    DynamicJointState of "control_msgs",
    JointState of "sensor_msgs",
    MarkerArray of "visualization_msgs",
    WrenchStamped of "geometry_msgs",
}
