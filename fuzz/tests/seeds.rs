//! Every target takes its seeds, whole, cut short and damaged: what the fuzzer starts from, in the normal suite.

use fuzz_targets::TARGETS;

/// Inputs made of one seed: a fixed number, so that long seeds cost no more than short ones.
const DAMAGED: usize = 400;

/// A small generator (xorshift), so that every run damages the same places.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit.max(1) as u64) as usize
    }
}

#[test]
fn targets_have_names_of_their_own_and_seeds() {
    for (index, target) in TARGETS.iter().enumerate() {
        assert!(TARGETS[..index].iter().all(|other| other.name != target.name), "{} stands twice", target.name);
        // Names are file names and words on a command line.
        assert!(target.name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-'), "{}", target.name);
        assert!(!(target.seeds)().is_empty(), "{} has no seeds", target.name);
    }
}

#[test]
fn every_seed_passes() {
    for target in TARGETS {
        (target.run)(&[]);
        (target.seeds)().iter().for_each(|seed| (target.run)(seed));
    }
}

#[test]
fn damaged_seeds_pass() {
    for target in TARGETS {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let seeds = (target.seeds)();
        for seed in &seeds {
            for round in 0..DAMAGED {
                let mut input = seed.clone();
                match round % 4 {
                    0 => input.truncate(random.below(seed.len())),
                    1 => {
                        for _ in 0..=random.below(4) {
                            let place = random.below(input.len());
                            if let Some(byte) = input.get_mut(place) {
                                *byte ^= 1 << random.below(8);
                            }
                        }
                    }
                    2 => {
                        // A piece of another seed in the middle of this one.
                        let other = &seeds[random.below(seeds.len())];
                        let start = random.below(other.len());
                        let piece = &other[start..(start + 1 + random.below(40)).min(other.len())];
                        let place = random.below(input.len());
                        input.splice(place..place, piece.iter().copied());
                    }
                    _ => {
                        let start = random.below(input.len());
                        let end = (start + random.below(20)).min(input.len());
                        input.drain(start..end);
                    }
                }
                (target.run)(&input);
            }
        }
    }
}
