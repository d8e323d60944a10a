//! The node: its publishers and its services.

use std::io;
use std::net::Ipv4Addr;

use fre_gripper::source::{Setup, Told};
use messages::FINGERS;
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::ros2::{CreateError, QosProfile};
use ros2_client::{Context, MessageTypeName, Name, NodeCreateError, NodeName, NodeOptions, Publisher};

use crate::message::{DiagnosticArray, DynamicJointState, JointState, MarkerArray, Named, WrenchStamped};
use crate::options::{DOMAINS, Options, Qos};
use crate::services::{Leader, Running, Services};
use crate::telling::{Message, Telling};

/// Why there is no node.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// Its ports would be beyond the last one.
    #[error("the domain is {0}; allowed is 0 to {DOMAINS}")]
    Domain(u16),
    /// Not a name.
    #[error(
        "`{0}` is not a name that ROS 2 allows: a name has letters, digits and _ after a letter, and a namespace begins with /"
    )]
    Name(String),
    /// DDS refuses.
    #[error("no node of ROS 2 here: {0}")]
    Dds(String),
    /// No thread.
    #[error("the services cannot be answered: {0}")]
    Services(#[source] io::Error),
}

impl From<CreateError> for NodeError {
    fn from(error: CreateError) -> Self {
        Self::Dds(error.to_string())
    }
}

impl From<NodeCreateError> for NodeError {
    fn from(error: NodeCreateError) -> Self {
        Self::Dds(error.to_string())
    }
}

/// A node that publishes what a source reports.
pub struct Node {
    // Dropped in this order: who asks nothing any more, then the publishers, then the node.
    _services: Running,
    fingers: Vec<FingerTopics>,
    joints: Publisher<JointState>,
    markers: Publisher<MarkerArray>,
    diagnostics: Publisher<DiagnosticArray>,
    telling: Telling,
    unsent: u64,
    sent: u64,
    options: Options,
    node: ros2_client::Node,
}

struct FingerTopics {
    wrench: Publisher<WrenchStamped>,
    certainty: Publisher<DynamicJointState>,
    wrench_name: String,
}

impl Node {
    /// Joins the network. `leader` does what the services ask.
    ///
    /// # Errors
    /// An option that is not allowed, or the network.
    pub fn new(options: &Options, setup: &Setup, leader: Leader) -> Result<Self, NodeError> {
        if options.domain > DOMAINS {
            return Err(NodeError::Domain(options.domain));
        }
        let name = NodeName::new(&options.namespace, &options.name)
            .map_err(|_| NodeError::Name(format!("{}/{}", options.namespace.trim_end_matches('/'), options.name)))?;
        let mut participant = DomainParticipantBuilder::new(options.domain);
        if options.only_this_machine {
            participant = participant.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let participant = participant.build().map_err(CreateError::from)?;
        let context = Context::from_domain_participant(participant)?;
        // Its own services of parameters know one mapping only.
        let mut node = context.new_node(name, NodeOptions::new().start_parameter_services(false))?;
        let qos = options.qos.profile();
        let joints = publisher(&mut node, &options.namespace, "joint_states", &qos)?;
        let own = node.fully_qualified_name();
        let markers = publisher(&mut node, &own, "markers", &Qos::usual())?;
        let diagnostics = publisher(&mut node, "/", "diagnostics", &Qos::usual())?;
        let services = Services::new(&mut node, options.mapping, setup, leader)?;
        let mut node = Self {
            _services: services.start().map_err(NodeError::Services)?,
            fingers: Vec::new(),
            joints,
            markers,
            diagnostics,
            telling: Telling::new(setup),
            unsent: 0,
            sent: 0,
            options: options.clone(),
            node,
        };
        node.grow()?;
        Ok(node)
    }

    /// Its name with its namespace.
    pub fn name(&self) -> String {
        self.node.fully_qualified_name()
    }

    /// Messages sent, and those for which there was no room because a subscriber was too late.
    pub fn counts(&self) -> [u64; 2] {
        [self.sent, self.unsent]
    }

    /// How many subscribers the force of every finger has at least.
    pub fn subscribers(&self) -> usize {
        let counts = self.fingers.iter().map(|finger| self.node.subscription_count(&finger.wrench_name));
        counts.min().unwrap_or(0)
    }

    /// Publishes what a source has reported; `ns`: its time, since 1970.
    ///
    /// # Errors
    /// A finger has come whose topics cannot be made.
    pub fn tell(&mut self, ns: u64, told: &Told) -> Result<(), NodeError> {
        for message in self.telling.tell(ns, told) {
            self.send(message);
        }
        if matches!(told, Told::Setup(_)) { self.grow() } else { Ok(()) }
    }

    /// Says which fingers are silent.
    pub fn silence(&mut self, ns: u64) {
        if let Some(message) = self.telling.silence(ns) {
            self.send(message);
        }
    }

    fn send(&mut self, message: Message) {
        let finger = |number: u8| self.fingers.get(usize::from(number));
        let done = match message {
            Message::Wrench(number, message) => finger(number).map(|topics| topics.wrench.publish(message).is_ok()),
            Message::Certainty(number, message) => {
                finger(number).map(|topics| topics.certainty.publish(message).is_ok())
            }
            Message::Joint(message) => Some(self.joints.publish(message).is_ok()),
            Message::Markers(message) => Some(self.markers.publish(message).is_ok()),
            Message::Diagnostics(message) => Some(self.diagnostics.publish(message).is_ok()),
        };
        match done {
            Some(true) => self.sent += 1,
            Some(false) => self.unsent += 1,
            None => {}
        }
    }

    /// Topics for the fingers that have none yet.
    fn grow(&mut self) -> Result<(), NodeError> {
        let qos = self.options.qos.profile();
        for number in self.fingers.len()..self.telling.fingers().min(FINGERS) {
            let below = format!("{}/finger_{number}", self.node.fully_qualified_name());
            let certainty = publisher(&mut self.node, &below, "force_state", &qos)?;
            let wrench = publisher(&mut self.node, &below, "wrench", &qos)?;
            self.fingers.push(FingerTopics { wrench, certainty, wrench_name: format!("{below}/wrench") });
        }
        Ok(())
    }
}

/// A publisher of a type of ROS 2.
fn publisher<M: Named + ros2_client::Message>(
    node: &mut ros2_client::Node,
    namespace: &str,
    topic: &str,
    qos: &QosProfile,
) -> Result<Publisher<M>, NodeError> {
    let name = Name::new(namespace, topic).map_err(|_| NodeError::Name(format!("{namespace}/{topic}")))?;
    let topic = node.create_topic(&name, MessageTypeName::new(M::PACKAGE, M::NAME), qos)?;
    Ok(node.create_publisher(&topic, None)?)
}
