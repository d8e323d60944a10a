//! `fre ros2`: a gripper, a bus or a recording as a node of ROS 2.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;

use crate::exit::bad_input;
use crate::source::SourceArgs;

/// Arguments of a live source, which no recording has.
const LIVE: [&str; 3] = ["link", "bus", "seconds"];

/// Publish forces as a node of ROS 2, without a ROS installation
///
/// The source is a gripper (--link), servos on this PC's bus (--bus) or a recording, whose messages have the times of the recording.
///
/// Topics, below /fre: finger_N/wrench (the force of the finger on the object; NaN while it is untrustworthy), finger_N/force_state
/// (its standard deviation and status) and markers; beside it /joint_states and /diagnostics. Services: grip, release, stop and relax.
/// Parameters set the force and speed of a grip. docs/ros2.md describes them all.
///
/// Needs a `fre` built with ROS 2: cargo build --release -p fre-cli --features ros2
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A recording instead of a gripper or a bus
    #[arg(value_name = "FILE.mcap", conflicts_with_all = LIVE)]
    file: Option<PathBuf>,
    #[command(flatten)]
    source: SourceArgs,
    /// Stops after this time [default: when the source ends]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// The node's name
    #[arg(long, value_name = "NAME", default_value = "fre")]
    name: String,
    /// Its namespace, as /left_arm
    #[arg(long, value_name = "/NAMESPACE", default_value = "/")]
    namespace: String,
    /// DDS domain, 0 to 232 [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_name = "N")]
    domain: Option<u16>,
    /// Sends nothing to other machines
    ///
    /// So does ROS_LOCALHOST_ONLY=1 or ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST in the environment.
    #[arg(long)]
    localhost: bool,
    /// Quality of service of forces and joint states
    #[arg(long, value_enum, default_value = "sensor")]
    qos: QosWord,
    /// How services are mapped to DDS: as the RMW of the nodes that call
    #[arg(long, value_enum, value_name = "MAPPING", default_value = "enhanced")]
    services: MappingWord,
    /// Begins as soon as the force of every finger has a subscriber
    #[arg(long, requires = "file", conflicts_with_all = LIVE)]
    wait_for_subscribers: bool,
    /// Speed at which a recording is played; 2 is twice as fast
    #[arg(long, value_name = "TIMES", default_value_t = 1.0, requires = "file", conflicts_with_all = LIVE)]
    speed: f64,
    /// Stays this long after a recording's end, for subscribers that are late
    ///
    /// They may still fetch what they have missed; without subscribers it ends at once.
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "file", conflicts_with_all = LIVE)]
    linger: f64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum QosWord {
    /// Best effort, the last five: as ROS 2 sends sensors' data
    Sensor,
    /// Reliable, all kept
    Reliable,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MappingWord {
    /// rmw_connextdds with its basic mapping
    Basic,
    /// rmw_fastrtps_cpp, ROS 2's default
    Enhanced,
    /// rmw_cyclonedds_cpp
    Cyclone,
}

/// Runs the command.
#[cfg(not(feature = "ros2"))]
pub fn run(_: &Args) -> ExitCode {
    bad_input(
        &"this `fre` was built without ROS 2; build it with ROS 2: cargo run --release -p fre-cli --features ros2 --bin fre -- ros2 …",
    )
}

/// Runs the command.
#[cfg(feature = "ros2")]
pub fn run(args: &Args) -> ExitCode {
    match run::node(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}

#[cfg(feature = "ros2")]
mod run {
    use std::path::Path;
    use std::sync::atomic::AtomicBool;
    use std::time::Duration;

    use fre_gripper::record::{Recording, beginning};
    use fre_gripper::source::{Origin, Setup};
    use fre_ros2::{Mapping, Node, Options, Qos, linger, live, replay, wait_for_subscribers};

    use super::{Args, MappingWord, QosWord};
    use crate::output::put_out;
    use crate::replay::times;
    use crate::signals::stop_flag;

    type Failure = Box<dyn std::error::Error>;

    /// Runs the node until the end.
    pub(super) fn node(args: &Args) -> Result<(), Failure> {
        let options = options(args)?;
        let length = args.seconds.map(|seconds| time("--seconds", seconds)).transpose()?;
        let stop = stop_flag()?;
        let node = match &args.file {
            Some(file) => recorded(args, file, &options, &stop)?,
            None => {
                let source = args.source.open(fre_gripper::link::Ends::WithTheGripper)?;
                let setup = source.setup()?;
                let mut node = Node::new(&options, &setup, Some(source.clone()))?;
                announce(&node, &setup, &options)?;
                live(&mut node, &*source, length, &stop)?;
                node
            }
        };
        let [sent, unsent] = node.counts();
        let late = match unsent {
            0 => String::new(),
            unsent => format!(", {unsent} not sent: a subscriber was too late"),
        };
        Ok(put_out(&format!("{sent} messages{late}\n"))?)
    }

    fn recorded(args: &Args, file: &Path, options: &Options, stop: &AtomicBool) -> Result<Node, Failure> {
        let speed = times(args.speed)?;
        let longest = time("--linger", args.linger)?;
        args.source.no_bus("a recording")?;
        let mut recording = Recording::open(file)?;
        let mut setup = beginning(file, &mut recording)?;
        (setup.origin, setup.place) = (Origin::Recording, format!("{} of {}", file.display(), setup.place));
        let mut node = Node::new(options, &setup, None)?;
        announce(&node, &setup, options)?;
        if args.wait_for_subscribers {
            wait_for_subscribers(&node, stop);
        }
        replay(&mut node, &mut recording, speed, stop)?;
        linger(&node, longest, stop);
        Ok(node)
    }

    fn announce(node: &Node, setup: &Setup, options: &Options) -> Result<(), String> {
        let Options { domain, only_this_machine, .. } = options;
        let reach = if *only_this_machine { ", this machine only" } else { "" };
        put_out(&format!("node {} in domain {domain}{reach}: {}\n", node.name(), setup.place))
    }

    fn time(option: &str, seconds: f64) -> Result<Duration, String> {
        Duration::try_from_secs_f64(seconds).map_err(|_| format!("{option} is {seconds}; allowed is 0 and more"))
    }

    fn options(args: &Args) -> Result<Options, String> {
        let set = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        let domain = match (args.domain, set("ROS_DOMAIN_ID")) {
            (Some(domain), _) => domain,
            (None, Some(words)) => {
                words.parse().map_err(|_| format!("ROS_DOMAIN_ID is `{words}`; allowed is 0 to 232"))?
            }
            (None, None) => 0,
        };
        let only_here = set("ROS_LOCALHOST_ONLY").is_some_and(|value| value == "1")
            || set("ROS_AUTOMATIC_DISCOVERY_RANGE").is_some_and(|value| value == "LOCALHOST");
        Ok(Options {
            domain,
            only_this_machine: args.localhost || only_here,
            namespace: args.namespace.clone(),
            name: args.name.clone(),
            qos: match args.qos {
                QosWord::Sensor => Qos::Sensor,
                QosWord::Reliable => Qos::Reliable,
            },
            mapping: match args.services {
                MappingWord::Basic => Mapping::Basic,
                MappingWord::Enhanced => Mapping::Enhanced,
                MappingWord::Cyclone => Mapping::Cyclone,
            },
        })
    }
}
