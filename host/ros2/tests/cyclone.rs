//! The node heard and asked by Eclipse Cyclone DDS, on this machine only.

mod told;

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use fre_gripper::record::{Pace, Speed};
use fre_gripper::source::{Listeners, Order, OrderError, SIGN_OF_LIFE, Setup, Source, Statistics, Told, now_ns};
use fre_ros2::message::Named;
use fre_ros2::{Mapping, Message, Node, Options, Qos, Telling, linger, live, wait_for_subscribers};
use messages::{Counters, Mount, Refusal, Settings, Which};
use model_core::drive::Drive;
use model_core::estimator::Estimate;
use model_core::status::Status;
use ros2_client::dds::rustdds::RepresentationIdentifier;
use ros2_client::dds::rustdds::serialization::to_writer_with_rep_id;
use serde::Serialize;
use serde_json::{Value, json};
use test_bus::Cyclone;
use told::{model, report, setup};

/// A name and a domain that no other test has: a process is known by its number, a test by its own.
fn options(test: u16) -> Options {
    let process = std::process::id();
    Options {
        domain: 1 + ((10 * process + u32::from(test)) % 100) as u16,
        only_this_machine: true,
        namespace: format!("/process{process}/test{test}"),
        ..Options::default()
    }
}

/// The node's whole name.
fn whole_name(options: &Options) -> String {
    format!("{}/{}", options.namespace, options.name)
}

/// So many ticks at 500 Hz, closing to 11° and opening again once a second; every seventh report is stale, and 25 shapes a second.
fn closing(ticks: u64) -> Vec<Told> {
    let mut model = model(Drive::Rotating);
    let mut told = Vec::new();
    let mut last = Estimate::blank(Status::OutOfRange);
    for tick in 0..ticks {
        let phase = (tick % 500) as f64 / 250.0;
        let angle = (11.0 * (1.0 - (phase - 1.0).abs())).to_radians();
        let is_lost = tick % 7 == 6;
        last =
            if is_lost { Estimate { status: Status::Stale, age: last.age + 1, ..last } } else { model.update(angle) };
        let report = report(tick, last);
        told.push(Told::Report(report));
        if tick % 20 == 0 {
            told.push(Told::Shape(Box::new(model.shape(&report))));
        }
    }
    told
}

/// Ticks at 500 Hz as a source reports them, with their times.
fn told(ticks: u64) -> Vec<(u64, Told)> {
    let began = now_ns();
    let mut ns = began;
    let with_time = |told: Told| {
        if let Told::Report(report) = &told {
            ns = began + 1000 * report.time_us;
        }
        (ns, told)
    };
    closing(ticks).into_iter().map(with_time).collect()
}

/// A set-up whose diagnostics differ from those of other nodes in the domain.
fn named(options: &Options) -> Setup {
    Setup { place: options.namespace.clone(), ..setup(Drive::Rotating) }
}

/// Publishes this for Cyclone at its own speed; what it has heard, topic by topic, the counts last.
fn heard(told: &[(u64, Told)], options: &Options, qos: &str) -> Vec<Value> {
    let stop = AtomicBool::new(false);
    let mut node = Node::new(options, &named(options), None).unwrap();
    let reports = told.iter().filter(|(_, told)| matches!(told, Told::Report(_))).count();
    let subscriber = Cyclone::subscribe(&whole_name(options), options.domain, qos, reports);
    let printed = std::thread::spawn(move || subscriber.lines());
    wait_for_subscribers(&node, &stop);
    let mut pace = Pace::new(Speed::Times(1.0));
    for (ns, told) in told {
        pace.wait(*ns, &stop);
        node.tell(*ns, told).unwrap();
    }
    // Who has lost something waits until the node has gone.
    linger(&node, Duration::from_secs(if qos == "reliable" { 60 } else { 1 }), &stop);
    let [sent, unsent] = node.counts();
    drop(node);
    println!("{qos}: {sent} messages sent, {unsent} not");
    assert!(qos != "reliable" || unsent == 0, "{unsent} not sent");
    printed.join().unwrap()
}

/// A message as CDR has it, in hexadecimal digits.
fn cdr(message: &impl Serialize) -> String {
    let mut bytes = vec![0, 1, 0, 0];
    to_writer_with_rep_id(&mut bytes, message, RepresentationIdentifier::CDR_LE).unwrap();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What the node should say: topic and bytes.
fn expected(told: &[(u64, Told)], options: &Options) -> Vec<(String, String)> {
    let mut telling = Telling::new(&named(options));
    let bytes = |message| match message {
        Message::Wrench(finger, message) => (format!("wrench {finger}"), cdr(&message)),
        Message::Certainty(finger, message) => (format!("force_state {finger}"), cdr(&message)),
        Message::Joint(message) => ("joint_states".to_owned(), cdr(&message)),
        Message::Markers(message) => ("markers".to_owned(), cdr(&message)),
        Message::Diagnostics(message) => ("diagnostics".to_owned(), cdr(&message)),
    };
    told.iter().flat_map(|(ns, told)| telling.tell(*ns, told)).map(bytes).collect()
}

/// The bytes that were heard of a topic from this node.
fn of<'a>(heard: &'a [Value], topic: &str, options: &Options) -> Vec<&'a str> {
    let is_ours = |line: &Value| line["hardware"].is_null() || line["hardware"] == options.namespace;
    let mine = heard.iter().filter(|line| line["topic"] == topic && is_ours(line));
    mine.map(|line| line["cdr"].as_str().unwrap()).collect()
}

/// How long the topics are heard, s; `cargo xtask bench ros2` takes a minute.
fn seconds(usual: u64) -> u64 {
    let set = std::env::var("FRE_ROS2_SECONDS").ok();
    set.map_or(usual, |words| words.parse().expect("FRE_ROS2_SECONDS is a whole number of seconds"))
}

/// 500 Hz for some seconds, reliable, all kept: every message of every topic, none twice, in order, each field as it was reported. Cyclone reads
/// what was sent, and what it writes of that must be the same bytes.
#[test]
fn reliable_topics_lose_nothing_and_every_field_is_exact() {
    let seconds = seconds(10);
    let (told, options) = (told(500 * seconds), Options { qos: Qos::Reliable, ..options(1) });
    let heard = heard(&told, &options, "reliable");
    let expected = expected(&told, &options);
    println!("{}", heard.last().unwrap());
    for topic in ["wrench 0", "force_state 0", "joint_states", "markers", "diagnostics"] {
        let wanted: Vec<&str> = expected.iter().filter(|(of, _)| of == topic).map(|(_, cdr)| cdr.as_str()).collect();
        let found = of(&heard, topic, &options);
        assert_eq!(found.len(), wanted.len(), "{topic}");
        let wrong = found.iter().zip(&wanted).position(|(found, wanted)| found != wanted);
        assert_eq!(wrong.map(|at| (at, found[at], wanted[at])), None, "{topic}");
    }
    // By name, so that two fields that were exchanged on both sides would be seen.
    let contact = heard
        .iter()
        .filter(|line| line["topic"] == "wrench 0" && line["fields"]["wrench"]["force"]["x"].as_f64() > Some(1.0));
    let first = contact.clone().next().unwrap();
    assert_eq!(first["fields"]["header"]["frame_id"], "finger_0_base");
    assert_eq!(first["fields"]["wrench"]["force"]["z"], 0.0);
    assert!(contact.count() as u64 > 100 * seconds);
    let is_nan = |line: &&Value| line["topic"] == "wrench 0" && line["fields"]["wrench"]["torque"]["x"] == "nan";
    assert!(heard.iter().filter(is_nan).count() as u64 >= 500 * seconds / 7, "stale forces are NaN");
}

/// What is lost is measured, not judged: it depends on how busy the machine is. What comes is whole and in order.
#[test]
fn best_effort_topics_stay_in_order() {
    let sent = 500 * seconds(3);
    let (told, options) = (told(sent), options(2));
    let heard = heard(&told, &options, "best-effort");
    let expected = expected(&told, &options);
    println!("of {sent}: {}", heard.last().unwrap());
    let mut wanted = expected.iter().filter(|(of, _)| of == "wrench 0");
    let found = of(&heard, "wrench 0", &options);
    assert!(!found.is_empty());
    for found in found {
        assert!(wanted.any(|(_, wanted)| wanted == found), "a force that was not reported, or not in this order");
    }
}

/// A gripper that takes note of what it is asked for.
struct Asked {
    settings: Mutex<Settings>,
    orders: Mutex<Vec<Order>>,
    listeners: Listeners,
    signs: AtomicU32,
}

impl Asked {
    fn new() -> Arc<Self> {
        Arc::new(Self {
            settings: Mutex::new(Settings::of(Mount::DEFAULT)),
            orders: Mutex::default(),
            listeners: Listeners::default(),
            signs: AtomicU32::new(0),
        })
    }
}

impl Source for Asked {
    fn setup(&self) -> Result<Setup, OrderError> {
        Ok(Setup { settings: *self.settings.lock().unwrap(), ..setup(Drive::Rotating) })
    }
    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.listeners.add(waiting)
    }
    fn statistics(&self) -> Statistics {
        Statistics::default()
    }
    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Ok(None)
    }
    fn order(&self, order: &Order) -> Result<(), OrderError> {
        match order {
            Order::Settings(settings) => {
                settings.validate(4)?;
                *self.settings.lock().unwrap() = *settings;
            }
            Order::Grip(to) if to.force > 50.0 => return Err(Refusal::NoServo.into()),
            _ => {}
        }
        let mut orders = self.orders.lock().unwrap();
        // One who has not heard the answer asks again.
        if orders.last() != Some(order) {
            orders.push(order.clone());
        }
        Ok(())
    }
    fn is_closed(&self) -> bool {
        false
    }
    fn sign(&self) {
        self.signs.fetch_add(1, Ordering::Relaxed);
    }
}

/// A gripper that stops the motions of hosts that are gone hears of a node also while nobody calls a service.
#[test]
fn a_node_gives_signs_of_life() {
    let (options, gripper) = (options(7), Asked::new());
    let mut node = Node::new(&options, &gripper.setup().unwrap(), Some(gripper.clone())).unwrap();
    let (length, stop) = (10 * SIGN_OF_LIFE, AtomicBool::new(false));
    assert!(!live(&mut node, &*gripper, Some(length), &stop).unwrap());
    let signs = gripper.signs.load(Ordering::Relaxed);
    // A busy PC may leave some out.
    assert!((3..=11).contains(&signs), "{signs} signs in {length:?}");
}

fn asked(number: u16, mapping: Mapping, word: &str) {
    let options = Options { mapping, ..options(number) };
    let gripper = Asked::new();
    let _node = Node::new(&options, &gripper.setup().unwrap(), Some(gripper.clone())).unwrap();
    let force = |force: f64| json!({ "service": "set_parameters", "parameters": { "grip_force_n": force } });
    let names = ["grip_force_n", "finger.0.force_limit_n", "rate_hz", "on_fault", "nothing"];
    let calls = [
        json!({ "service": "stop" }),
        force(2.5),
        json!({ "service": "grip" }),
        json!({ "service": "set_parameters", "parameters": { "finger": 0, "grip_speed_deg_per_s": 9.0, "grip_limit_deg": 12 } }),
        json!({ "service": "grip" }),
        json!({ "service": "release" }),
        json!({ "service": "relax" }),
        force(60.0),
        json!({ "service": "grip" }),
        force(-1.0),
        json!({ "service": "set_parameters", "parameters": { "finger.0.force_limit_n": 7.5, "rate_hz": 250 } }),
        json!({ "service": "set_parameters_atomically", "parameters": { "rate_hz": 100, "finger.0.force_limit_n": -3.0 } }),
        json!({ "service": "set_parameters", "parameters": { "source": "elsewhere" } }),
        json!({ "service": "get_parameters", "names": names }),
        json!({ "service": "get_parameter_types", "names": names }),
        json!({ "service": "describe_parameters", "names": ["wrench", "nothing"] }),
        json!({ "service": "list_parameters", "prefixes": [], "depth": 1 }),
        json!({ "service": "list_parameters", "prefixes": ["finger.0"], "depth": 0 }),
    ];
    let answers = Cyclone::call(&whole_name(&options), options.domain, word, &calls).lines();
    assert_eq!(answers.len(), calls.len());
    let [
        stop,
        _,
        grip,
        set,
        again,
        release,
        relax,
        _,
        refused,
        negative,
        limits,
        atomic,
        fixed,
        values,
        types,
        described,
        top,
        below,
    ] = &answers[..]
    else {
        panic!("an answer each")
    };
    assert_eq!((&stop["success"], &stop["message"]), (&json!(true), &json!("stopped")));
    assert_eq!((&relax["success"], &relax["message"]), (&json!(true), &json!("without torque")));
    assert_eq!([&grip["success"], &again["success"], &release["success"]], [true; 3]);
    assert_eq!((&refused["success"], &refused["message"]), (&json!(false), &json!("no servo answers on the bus")));
    assert!(set["results"].as_array().unwrap().iter().all(|result| result["successful"] == true));
    assert_eq!(negative["results"][0]["reason"], "grip_force_n is -1; allowed is 0.01 to 1000");
    assert!(limits["results"].as_array().unwrap().iter().all(|result| result["successful"] == true), "{limits}");
    assert_eq!(atomic["result"]["successful"], false);
    assert_eq!(atomic["result"]["reason"], "force limit in N is -3; allowed is 0.01 to 1000");
    assert_eq!(fixed["results"][0]["reason"], "source cannot be set");
    let values = &values["values"];
    assert_eq!((&values[0]["double_value"], &values[1]["double_value"]), (&json!(60.0), &json!(7.5)));
    // All or nothing: the rate of the refused change is not there.
    assert_eq!((&values[2]["integer_value"], &values[3]["string_value"]), (&json!(250), &json!("hold")));
    assert_eq!(types["types"], json!([3, 3, 2, 4, 0]));
    let [wrench, nothing] = [0, 1].map(|at| &described["descriptors"][at]);
    assert_eq!((&wrench["read_only"], &wrench["type"], &nothing["type"]), (&json!(true), &json!(4), &json!(0)));
    assert!(wrench["description"].as_str().unwrap().contains("wrench"));
    let names = |answer: &Value| -> Vec<String> { serde_json::from_value(answer["result"]["names"].clone()).unwrap() };
    assert!(names(top).contains(&"grip_force_n".to_owned()) && !names(top).iter().any(|name| name.contains('.')));
    assert!(names(below).iter().all(|name| name.starts_with("finger.0.")) && names(below).len() == 14, "{below}");
    assert_eq!(below["result"]["prefixes"], json!(["finger.0"]));

    let orders = gripper.orders.lock().unwrap();
    let grips: Vec<_> =
        orders.iter().filter_map(|order| if let Order::Grip(to) = order { Some(*to) } else { None }).collect();
    assert_eq!(orders[0], Order::Hold(Which::All));
    assert_eq!(
        [(grips[0].force, grips[0].fingers), (grips[1].force, grips[1].fingers)],
        [(2.5, Which::All), (2.5, Which::One(0))]
    );
    assert_eq!([grips[0].speed, grips[0].limit], [None; 2]);
    assert_eq!(
        [grips[1].speed, grips[1].limit].map(|angle| angle.map(f32::to_degrees).map(f32::round)),
        [Some(9.0), Some(12.0)]
    );
    assert!(orders.contains(&Order::Open(Which::One(0))) && orders.contains(&Order::Relax(Which::One(0))));
    assert_eq!(grips.len(), 2);
}

/// As `rmw_connextdds` maps services.
#[test]
fn services_and_parameters_answer_with_the_basic_mapping() {
    asked(3, Mapping::Basic, "basic");
}

/// As `rmw_fastrtps_cpp` does. (Cyclone sees what is answered, not the identity beside it.)
#[test]
fn services_and_parameters_answer_with_the_enhanced_mapping() {
    asked(4, Mapping::Enhanced, "enhanced");
}

/// As `rmw_cyclonedds_cpp` does.
#[test]
fn services_and_parameters_answer_with_the_mapping_of_cyclone() {
    asked(5, Mapping::Cyclone, "cyclone");
}

#[test]
fn bad_names_and_domains_are_refused() {
    let setup = setup(Drive::Rotating);
    let refused = |options: Options| Node::new(&options, &setup, None).err().expect("refused").to_string();
    assert_eq!(refused(Options { domain: 233, ..options(6) }), "the domain is 233; allowed is 0 to 232");
    let name = refused(Options { name: "left arm".to_owned(), ..options(6) });
    assert!(name.starts_with("`/process") && name.contains("left arm` is not a name that ROS 2 allows"), "{name}");
    assert!(
        refused(Options { namespace: "arm".to_owned(), ..options(6) }).contains("`arm/fre` is not a name"),
        "a slash is missing"
    );
    assert_eq!(
        [fre_ros2::message::WrenchStamped::PACKAGE, fre_ros2::message::WrenchStamped::NAME],
        ["geometry_msgs", "WrenchStamped"]
    );
}
