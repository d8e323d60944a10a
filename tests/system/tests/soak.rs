//! Faults of every kind on a gripper with four fingers; `cargo xtask bench soak` draws ten thousand.

use system_tests::campaign;

/// About four of each kind; others by `FRE_SOAK_EVENTS=10000 cargo test -p system-tests --test soak`.
const EVENTS: u32 = 80;

#[test]
fn faults_of_every_kind_are_got_over() {
    let events = std::env::var("FRE_SOAK_EVENTS").ok().and_then(|events| events.parse().ok()).unwrap_or(EVENTS);
    let campaign = campaign(1, events);
    eprintln!("{campaign}");
    assert!(campaign.faults().is_empty(), "{:?}", campaign.faults());
    assert!(campaign.events == events && campaign.grips > events / 4, "{campaign}");
    assert!(campaign.judge.touching > campaign.judge.sound / 4, "{campaign}");
}
