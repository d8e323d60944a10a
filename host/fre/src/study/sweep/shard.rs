//! A part of a sweep's points, for one of several machines.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The most parts.
const MOST: usize = 100_000;

/// Every n-th point, beginning with the i-th: neighbours cost alike, so the parts do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// Which one it is, from 1.
    pub fn number(self) -> usize {
        self.number
    }

    /// How many there are.
    pub fn of(self) -> usize {
        self.of
    }

    /// True if a point belongs to it.
    pub fn has(self, point: usize) -> bool {
        point % self.of == self.number - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed = || format!("allowed is I/N, I from 1 to N and N up to {MOST}");
        let (number, of) = text.split_once('/').ok_or_else(allowed)?;
        let number = number.parse().map_err(|_| allowed())?;
        let of = of.parse().map_err(|_| allowed())?;
        if of > MOST || !(1..=of).contains(&number) {
            return Err(allowed());
        }
        Ok(Self { number, of })
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn every_point_belongs_to_one_shard() {
        let shards: Vec<Shard> = (1..=4).map(|i| format!("{i}/4").parse().unwrap()).collect();
        for point in 0..21 {
            assert_eq!(shards.iter().filter(|shard| shard.has(point)).count(), 1);
        }
        assert_eq!(shards[1].to_string(), "2/4");
        for text in ["", "1", "0/4", "5/4", "1/0", "-1/4", "1/4/2", "1/100001", "a/b"] {
            assert!(text.parse::<Shard>().unwrap_err().contains("I/N"), "{text}");
        }
    }
}
