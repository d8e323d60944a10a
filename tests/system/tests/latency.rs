//! How long the force takes: from the last byte of the servo's answer until the report is made, in instructions.

use std::time::Duration;

use messages::{Mount, Settings, Which};
use system_tests::{Machine, OBJECT, Watch, finger};

const PER_TICK: u32 = Machine::INSTRUCTIONS_PER_TICK;
const SECONDS: fn(u64) -> Duration = Duration::from_secs;

/// The estimate takes most of it; what comes before and after is the same whatever the model does.
#[test]
fn the_report_follows_the_answer() {
    let machine = Machine::boot(Machine::servo());
    let link = machine.link();
    let mut watch = Watch::new(&link);
    let open = -std::f32::consts::PI / 180.0;
    link.set_settings(&Settings::of(Mount {
        open_angle: open,
        force_limit: 100.0,
        current_limit: 2000.0,
        ..Mount::DEFAULT
    }))
    .unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    watch.until_report("trustworthy estimate", SECONDS(60), |report| report.estimate.age == 0);
    let goal = 11_f32.to_radians();
    link.close(Which::All, goal, Some(0.35)).unwrap();
    let mut around = Vec::new();
    watch.reports.clear();
    let mut most_cost = 0;
    watch.until_report("closed finger", SECONDS(120), |report| {
        if report.estimate.age == 0 {
            most_cost = most_cost.max(report.cost);
            // Now and then, so that the question itself is not what is measured.
            if report.sequence.is_multiple_of(16)
                && let Ok(counters) = link.counters()
            {
                around.push(counters.latency * PER_TICK);
            }
        }
        (report.estimate.motor_angle - goal).abs() < 0.004
    });
    let counters = link.counters().unwrap();
    let most = counters.latency_most * PER_TICK;
    let mean = around.iter().map(|latency| u64::from(*latency)).sum::<u64>() / around.len() as u64;
    let dearest = most_cost * PER_TICK;
    println!(
        "from the servo's last byte to the report: {mean} instructions, {most} at most; the dearest estimate {dearest}"
    );
    assert!(counters.latency > 0 && counters.latency <= counters.latency_most, "{counters:?}");
    assert!(most >= dearest, "{most} with an estimate of {dearest}");
}
