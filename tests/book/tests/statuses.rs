//! The pages list the statuses that there are, with their codes.

use book::page::{Page, all};
use model_core::status::Status;

/// All statuses, by their codes.
const ALL: [Status; 13] = [
    Status::Converged,
    Status::Tracking,
    Status::NoContact,
    Status::Snapped,
    Status::MaxIterations,
    Status::Stagnated,
    Status::Folded,
    Status::ContactCapacity,
    Status::OutOfRange,
    Status::Stale,
    Status::Precision,
    Status::Unsettled,
    Status::Updating,
];

/// The code; a status that is added does not compile until it is listed.
fn code(status: Status) -> usize {
    match status {
        Status::Converged => 0,
        Status::Tracking => 1,
        Status::NoContact => 2,
        Status::Snapped => 3,
        Status::MaxIterations => 4,
        Status::Stagnated => 5,
        Status::Folded => 6,
        Status::ContactCapacity => 7,
        Status::OutOfRange => 8,
        Status::Stale => 9,
        Status::Precision => 10,
        Status::Unsettled => 11,
        Status::Updating => 12,
    }
}

fn page(pages: &[Page], path: &str) -> String {
    pages.iter().find(|page| page.path == path).unwrap_or_else(|| panic!("there is no {path}")).text.clone()
}

#[test]
fn the_pages_list_every_status_with_its_code() {
    let pages = all();
    let rows: Vec<String> = page(&pages, "docs/statuses.md")
        .lines()
        .filter_map(|line| line.strip_prefix("| `"))
        .map(|row| row.split(" | ").take(2).collect::<Vec<_>>().join(" "))
        .collect();
    let wanted: Vec<String> = ALL.iter().map(|status| format!("{}` {}", status.word(), code(*status))).collect();
    assert_eq!(rows, wanted);
    let list: Vec<String> = ALL.iter().map(|status| format!("{} {}", code(*status), status.word())).collect();
    assert!(
        page(&pages, "docs/device.md").contains(&list.join("; ")),
        "docs/device.md has other statuses than {list:?}"
    );
    // The pages say that the first four can be used.
    assert!(ALL.iter().all(|status| status.is_trustworthy() == (code(*status) < 4)));
}
