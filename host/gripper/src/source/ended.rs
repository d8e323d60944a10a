//! How watching a source ended.

use std::time::Duration;

/// How watching a source ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    /// Reports that came.
    pub reports: u64,
    /// Over this time.
    pub after: Duration,
    /// Nothing more comes from the source.
    pub closed: bool,
}
