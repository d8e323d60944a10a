//! Cycles of the real chips for the ticks of a closing finger: every instruction understood, every tick found, the bounds in their order.

use std::time::Duration;

use messages::{Mount, Settings, Which};
use model_core::status::Status;
use system_tests::{Cycles, Machine, OBJECT, Watch, finger};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const PATIENCE: Duration = Duration::from_secs(120);
/// Estimates in contact that are waited for; the motor moves in about 19 of them.
const ESTIMATES: usize = 25;

#[test]
fn ticks_have_bounds_in_cycles_on_every_chip() {
    let cycles = Cycles::new();
    let machine = Machine::boot_measured(Machine::servo(), &cycles, Machine::SHIFT);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    let mount = Mount { open_angle: -DEGREE, range: [-0.05, 0.3], ..Mount::DEFAULT };
    // Slow, so that no tick is cut short for want of time.
    link.set_settings(&Settings { rate_hz: 20, shape_every: 0, ..Settings::of(mount) }).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    watch.until_report("trustworthy estimate", PATIENCE, |report| report.estimate.age == 0);
    link.close(Which::All, 11.0 * DEGREE, Some(0.2)).unwrap();
    let (mut costs, mut angle, mut touching) = (Vec::new(), f32::NAN, 0);
    watch.until_report("estimates in contact", PATIENCE, |report| {
        // Where the motor stands next to nothing is computed, and misses of the caches decide.
        let moves = std::mem::replace(&mut angle, report.estimate.motor_angle) != report.estimate.motor_angle;
        if report.estimate.status != Status::Stale && report.estimate.force != [0.0; 2] {
            touching += 1;
            if moves {
                costs.push(f64::from(report.cost) * f64::from(Machine::INSTRUCTIONS_PER_TICK));
            }
        }
        touching >= ESTIMATES
    });
    assert!(costs.len() >= ESTIMATES / 2, "the motor moved in {} of {ESTIMATES} ticks only", costs.len());
    drop(watch);
    drop(link);
    drop(machine);

    let report = cycles.report().expect("the plugin's report");
    assert!(report.unknown.is_empty(), "not understood: {:?}", report.unknown);
    let windows = report.measured_as(&costs, f64::from(Machine::INSTRUCTIONS_PER_TICK));
    let found: Vec<_> = windows.into_iter().flatten().collect();
    assert!(found.len() * 10 >= costs.len() * 9, "{} of {} ticks were found", found.len(), costs.len());
    assert!(!report.chips.is_empty());
    for (index, chip) in report.chips.iter().enumerate() {
        let name = format!("{}, {}", chip.board, chip.layout);
        let between = found[0].between;
        for costs in [&chip.functions, &chip.addresses] {
            let shares: f64 = costs.iter().filter(|cost| cost.between == between).map(|cost| cost.share).sum();
            assert!(0.0 < shares && shares <= 1.0 + 1e-3, "{name}: {costs:?}");
        }
        // The costliest function of an estimate belongs to the solver, not to something that waits.
        let is_solver = |name: &str| name.starts_with("model_core::newton");
        let costliest = chip.functions.iter().find(|cost| cost.between == between).map(|cost| cost.name.as_str());
        assert!(costliest.is_some_and(is_solver), "{name}: {costliest:?}");
        let mut sums = [0.0_f64; 4];
        for window in &found {
            let [lower, upper] = window.cycles[index];
            // No processor here does more than two instructions a cycle.
            assert!(lower <= upper && lower * 2 >= window.instructions, "{name}: {window:?}");
            for (sum, value) in sums.iter_mut().zip([window.instructions, lower, upper, window.by_name[index]]) {
                *sum += value as f64;
            }
        }
        let [lower, upper, by_name] = [1, 2, 3].map(|index: usize| sums[index] / sums[0]);
        eprintln!("{name}: {lower:.2} to {upper:.2} cycles per instruction, {by_name:.4} of them known by name");
        assert!(by_name > 0.98, "{name}: {by_name} of the instructions are known by name");
        // 1.6 to 1.9; data that are looked for outside of every memory would make it 6.
        assert!(upper < 2.5, "{name}: {upper} cycles per instruction say nothing");
    }
}
