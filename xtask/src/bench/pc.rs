//! The part that runs on this PC: the example `bench` of the reference tests.

use super::peer;
use crate::command::{line as shown, output};
use crate::paths;
use anyhow::{Context, Result, bail};
use std::collections::HashMap;
use std::env;
use std::process::Command;
use std::str::FromStr;

/// Times of one model.
pub struct Time {
    pub model: String,
    pub physics: String,
    pub precision: String,
    /// One count, µs.
    pub warm_us: f64,
    /// From no contact to the last angle, µs.
    pub cold_us: f64,
}

/// A discretisation: model, samples per element, physics.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Model {
    pub name: String,
    pub samples: u8,
    pub physics: String,
}

/// Forces at one tick of the sweep, world frame, N.
pub struct Force {
    pub position: i32,
    pub double: [f64; 2],
    /// The single-precision force's bits.
    pub single: [u32; 2],
}

pub struct Pc {
    pub times: Vec<Time>,
    /// By model, tick by tick.
    pub forces: HashMap<Model, Vec<Force>>,
    /// The problem that a peer solves too.
    pub peer: peer::Run,
}

/// An example of the reference tests, built and run; what it prints is for a person to read.
pub fn show(example: &str) -> Result<()> {
    let mut command = cargo_run(example);
    let status = command.status().with_context(|| format!("cannot start `{}`", shown(&command)))?;
    if !status.success() {
        bail!("`{}` failed: {status}", shown(&command));
    }
    Ok(())
}

fn cargo_run(example: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(paths::root());
    command.args(["run", "--quiet", "--release", "--package", "reference-tests", "--example", example]);
    command
}

/// Builds and runs the example.
pub fn measure() -> Result<Pc> {
    parse(&output(&mut cargo_run("bench"))?)
}

fn parse(text: &str) -> Result<Pc> {
    let mut pc = Pc { times: Vec::new(), forces: HashMap::new(), peer: peer::Run::default() };
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words.as_slice() {
            ["time", model, physics, precision, warm, cold] => pc.times.push(Time {
                model: (*model).to_owned(),
                physics: (*physics).to_owned(),
                precision: (*precision).to_owned(),
                warm_us: number(warm)?,
                cold_us: number(cold)?,
            }),
            ["force", model, samples, physics, position, x, y, bits_x, bits_y] => {
                let model =
                    Model { name: (*model).to_owned(), samples: number(samples)?, physics: (*physics).to_owned() };
                pc.forces.entry(model).or_default().push(Force {
                    position: number(position)?,
                    double: [number(x)?, number(y)?],
                    single: [number(bits_x)?, number(bits_y)?],
                });
            }
            ["peer", words @ ..] => pc.peer.take(words)?,
            _ => bail!("the PC's bench printed `{line}`"),
        }
    }
    Ok(pc)
}

pub fn number<T: FromStr>(word: &str) -> Result<T> {
    word.parse().ok().with_context(|| format!("`{word}` is not the number it should be"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read() {
        let pc =
            parse("time fine paper f32 12.5 340\nforce simpson-17-1 4 paper -3 1.5e0 -2e-1 1069547520 0\n").unwrap();
        assert_eq!((pc.times[0].warm_us, pc.times[0].cold_us), (12.5, 340.0));
        let model = Model { name: "simpson-17-1".into(), samples: 4, physics: "paper".into() };
        let force = &pc.forces[&model][0];
        assert_eq!((force.position, force.double, force.single), (-3, [1.5, -0.2], [1_069_547_520, 0]));
    }

    #[test]
    fn a_line_that_is_none_is_an_error() {
        assert!(parse("time fine paper f32 12.5").is_err());
        assert!(parse("time fine paper f32 fast 3").is_err());
    }
}
