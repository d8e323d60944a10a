//! How a node presents itself.

use std::time::Duration;

use ros2_client::QosProfile;
use ros2_client::qos::{Durability, History, Reliability, WhenFull};

/// The largest domain whose ports exist.
pub const DOMAINS: u16 = 232;

/// How the numbers of the control loop are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Qos {
    /// As ROS 2 sends sensors' data: best effort, the last five.
    #[default]
    Sensor,
    /// Every message arrives, in order: reliable, all kept.
    Reliable,
}

/// How a service's request and its answer find each other: every implementation of DDS in ROS 2 has its own way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mapping {
    /// A header before request and answer (DDS-RPC, basic): Connext.
    Basic,
    /// Beside request and answer (DDS-RPC, enhanced): Fast DDS, the default of ROS 2.
    #[default]
    Enhanced,
    /// A header of Eclipse Cyclone DDS' own.
    Cyclone,
}

/// How a node presents itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// As `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// Nothing is sent to other machines.
    pub only_this_machine: bool,
    /// As `/left_arm`; `/`: none.
    pub namespace: String,
    /// The node's name.
    pub name: String,
    /// Of forces, joint states and certainties.
    pub qos: Qos,
    /// Of services.
    pub mapping: Mapping,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            domain: 0,
            only_this_machine: false,
            namespace: "/".to_owned(),
            name: "fre".to_owned(),
            qos: Qos::default(),
            mapping: Mapping::default(),
        }
    }
}

/// How long a message waits for room while a subscriber is late.
const PATIENCE: Duration = Duration::from_secs(1);

const fn reliable(history: History) -> QosProfile {
    QosProfile::publisher_default()
        .reliability(Reliability::Reliable { when_full: WhenFull::Wait(PATIENCE) })
        .durability(Durability::Volatile)
        .history(history)
}

impl Qos {
    /// As ROS 2 has it.
    pub(crate) fn profile(self) -> QosProfile {
        match self {
            Self::Sensor => QosProfile::subscription_default().history(History::KeepLast { depth: 5 }),
            Self::Reliable => reliable(History::KeepAll),
        }
    }

    /// Of pictures, diagnostics and services: ROS 2's own default, which rviz and aggregators ask for.
    pub(crate) fn usual() -> QosProfile {
        reliable(History::KeepLast { depth: 10 })
    }
}
