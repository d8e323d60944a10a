//! A gripper in QEMU as a node of ROS 2: Eclipse Cyclone DDS has it grip, stop, relax and release, and hears its forces.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use dynamixel::xm430;
use fre_gripper::source::Source;
use fre_ros2::{Node, Options, Qos, live, wait_for_subscribers};
use messages::{Mount, Phase, Settings, Why};
use serde_json::{Value, json};
use system_tests::{Machine, OBJECT, Tries, Watch, finger};
use test_bus::Cyclone;

const SECONDS: fn(u64) -> Duration = Duration::from_secs;
const DEGREE: f32 = std::f32::consts::PI / 180.0;

/// The node's whole name.
fn node(options: &Options) -> String {
    format!("{}/{}", options.namespace, options.name)
}

/// Calls services one after the other; all of them must succeed.
fn call(options: &Options, calls: &[Value]) {
    for answer in Cyclone::call(&node(options), options.domain, "enhanced", calls).lines() {
        let done = answer.get("success").unwrap_or(&answer["results"][0]["successful"]);
        assert_eq!(done, &json!(true), "{answer}");
    }
}

#[test]
fn a_gripper_is_led_and_heard_by_another_implementation_of_dds() {
    let machine = Machine::boot(Machine::servo());
    let link = Arc::new(machine.link());
    let mut watch = Watch::new(&link);
    let mount =
        Mount { open_angle: -DEGREE, range: [-0.05, 0.3], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
    // Slow enough that a busy PC makes few ticks stale.
    link.set_settings(&Settings { rate_hz: 100, ..Settings::of(mount) }).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    watch.until_report("trustworthy estimate", SECONDS(30), |report| report.estimate.status.is_trustworthy());

    let process = std::process::id();
    let options = Options {
        domain: 1 + (process % 100) as u16,
        only_this_machine: true,
        namespace: format!("/system{process}"),
        qos: Qos::Reliable,
        ..Options::default()
    };
    let source: Arc<dyn Source> = link.clone();
    let mut node = Node::new(&options, &source.setup().unwrap(), Some(source.clone())).unwrap();
    let subscriber = Cyclone::subscribe(&self::node(&options), options.domain, "reliable", 1_000_000);
    let heard = std::thread::spawn(move || subscriber.lines());
    let stop = Arc::new(AtomicBool::new(false));
    wait_for_subscribers(&node, &stop);
    let telling = std::thread::spawn({
        let stop = stop.clone();
        move || {
            let over = live(&mut node, &*source, None, &stop).unwrap();
            (over, node.counts())
        }
    });

    // A busy PC may keep the servo's answers until a grip ends: it is asked for again.
    let mut tries = Tries::of("a grip by ROS 2");
    let wanted = json!({ "service": "set_parameters", "parameters": { "grip_force_n": 2.0 } });
    call(&options, &[wanted, json!({ "service": "grip" })]);
    let mut reports = 0;
    watch.until("the force asked for", SECONDS(120), |told| {
        let fre_gripper::source::Told::Report(report) = told else { return false };
        reports += 1;
        if matches!(report.phase, Phase::Held(Why::ServoLost) | Phase::Released(Why::Bus)) && reports % 100 == 0 {
            tries.spoilt();
            call(&options, &[json!({ "service": "grip" })]);
        }
        report.phase == Phase::Gripped
    });
    call(&options, &[json!({ "service": "stop" })]);
    watch.until_report("stop", SECONDS(30), |report| report.phase == Phase::Held(Why::Asked));
    // Its torque goes off over the link, and comes back with the next motion.
    call(&options, &[json!({ "service": "relax" })]);
    let torque = || machine.servo.with(|servo| servo.read(xm430::TORQUE_ENABLE));
    watch
        .until_report("a finger without torque", SECONDS(30), |report| report.phase == Phase::Relaxed && torque() == 0);
    call(&options, &[json!({ "service": "release" })]);
    watch.until_report("open finger", SECONDS(60), |report| {
        report.goal == mount.open_angle && report.estimate.motor_angle < 0.0
    });

    assert_eq!(torque(), 1);

    stop.store(true, Ordering::Release);
    let (over, [sent, unsent]) = telling.join().unwrap();
    assert!(!over && sent > 300 && unsent == 0, "{sent} sent, {unsent} not");
    let heard = heard.join().unwrap();
    let forces: Vec<f64> = heard
        .iter()
        .filter(|line| line["topic"] == "wrench 0")
        .filter_map(|line| {
            let force = &line["fields"]["wrench"]["force"];
            Some(force["x"].as_f64()?.hypot(force["y"].as_f64()?))
        })
        .collect();
    let most = forces.iter().copied().fold(0.0, f64::max);
    assert!(forces.len() > 100 && (1.8..4.0).contains(&most), "{} forces, up to {most} N", forces.len());
    // The link and DDS report the same.
    let told: Vec<f64> = watch
        .reports
        .iter()
        .map(|report| f64::from(report.estimate.force[0]).hypot(f64::from(report.estimate.force[1])))
        .collect();
    assert!(forces.iter().all(|force| told.iter().any(|told| (told - force).abs() < 1e-6)));
}
