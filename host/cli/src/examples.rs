//! Examples at the end of each command's help. A test has the program read every one of them.

use clap::Command;
use clap::builder::StyledStr;

/// The examples of a command, by its words after `fre`: what it does, and the line.
const EXAMPLES: &[(&str, &[(&str, &str)])] = &[
    (
        "",
        &[
            ("A case to start from, and its forces", "fre new finger.toml && fre solve finger.toml"),
            ("The same as a picture", "fre solve finger.toml --plot finger.svg"),
        ],
    ),
    (
        "calibrate",
        &[
            ("Modulus, zero angle and object from a closing motion", "fre calibrate measured.csv -c finger.toml"),
            (
                "Only the modulus, into a new finger",
                "fre calibrate measured.csv -c finger.toml --fit youngs-modulus -w fitted.toml",
            ),
            (
                "A motion to measure along, and what it would determine",
                "fre calibrate --plan motion.csv -c finger.toml --fit youngs-modulus,zero",
            ),
        ],
    ),
    (
        "compare",
        &[
            ("Against finite elements, drawn", "fre compare finger.toml --fea --plot shapes.svg"),
            ("Against a load cell's file", "fre compare finger.toml --measured measured.csv"),
        ],
    ),
    (
        "completions",
        &[(
            "For bash, from the next shell on",
            "fre completions bash > ~/.local/share/bash-completion/completions/fre",
        )],
    ),
    (
        "finger",
        &[
            ("A solid for a printer", "fre finger export finger.toml --output finger.stl"),
            ("A case from a drawing", "fre finger import drawing.dxf --output finger.toml"),
        ],
    ),
    (
        "finger export",
        &[
            ("A solid for a printer", "fre finger export finger.toml --output finger.stl"),
            ("A drawing on standard output", "fre finger export preset:fea-80 --format svg"),
            ("A gripper for rviz and simulators", "fre finger export finger.toml --output gripper.urdf"),
        ],
    ),
    ("finger import", &[("A case from a mesh", "fre finger import finger.stl --output finger.toml")]),
    ("man", &[("Where man looks for them", "fre man --out ~/.local/share/man/man1")]),
    ("new", &[("A case to edit", "fre new finger.toml"), ("Straight into the solver", "fre new | fre solve -")]),
    (
        "optimise",
        &[
            (
                "The stiffest walls below 10 % strain, into a folder",
                "fre optimise finger.toml --goal 'stiffness at 8' --subject-to 'strain up to 8 <= 10%' --vary finger.front.thickness_mm=1:3 --vary finger.back.thickness_mm=1:3 --out stiff",
            ),
            (
                "A force that stays the same from 4 to 10°",
                "fre optimise finger.toml --goal 'constant-force over 4:10' --vary finger.back.base_mm.0=-35:-20 --vary finger.front.thickness_mm=1:3 --out even",
            ),
        ],
    ),
    (
        "outline",
        &[(
            "Four printed dots of 3 mm around the finger, at 12°",
            "fre outline photo.jpg --case finger.toml --angle-deg 12 --dot-mm 3 --marks 412,1530=-14,-5 1480,1522=40,-5 1466,318=40,85 430,330=-14,85",
        )],
    ),
    (
        "schema",
        &[("For an editor, and the page of all keys", "fre schema > case.schema.json && fre schema --page docs")],
    ),
    (
        "solve",
        &[
            ("A table of forces, and a picture of the last angle", "fre solve finger.toml --plot finger.svg"),
            ("For a program", "fre solve finger.toml --format json"),
            (
                "At the paper's resolution and with its physics",
                "fre solve finger.toml --scheme paper --elements paper --physics paper",
            ),
        ],
    ),
    (
        "sweep",
        &[(
            "Three radii by two thicknesses, 0 to 12°, in a file that a stopped sweep goes on with",
            "fre sweep finger.toml --angles 0:12:1 --vary object.radius_mm=20,30,40 --vary finger.front.thickness_mm=1.5,2 -o rows.csv",
        )],
    ),
    ("sweep merge", &[("Two machines' shards", "fre sweep merge one.csv two.csv --out rows.csv")]),
    ("table1", &[("With report and pictures", "fre table1 --out table1")]),
    (
        "demo",
        &[(
            "The firmware in QEMU for 20 s",
            "fre demo --firmware target/boards/thumbv7em-none-eabihf/release/gripper-mps2",
        )],
    ),
    (
        "flash",
        &[
            ("ROBOTIS' OpenCR", "fre flash opencr"),
            ("The same without a probe", "fre flash opencr --port /dev/ttyACM0"),
        ],
    ),
    (
        "gripper",
        &[
            ("What answers there", "fre gripper info --link /dev/ttyACM0"),
            ("The link once for all", "export FRE_LINK=/dev/ttyACM0 && fre gripper grip --force-n 3"),
        ],
    ),
    ("gripper info", &[("On a serial port", "fre gripper info --link /dev/ttyACM0")]),
    ("gripper get", &[("Into a file", "fre gripper get --link /dev/ttyACM0 > settings.txt")]),
    ("gripper set", &[("A finger and a rate", "fre gripper set rate_hz=500 --case finger.toml --link /dev/ttyACM0")]),
    (
        "gripper grip",
        &[
            ("Wait up to 5 s for 3 N", "fre gripper grip --force-n 3 --wait 5 --link /dev/ttyACM0"),
            (
                "Bear twice the weight of 300 g that pulls towards the palm",
                "fre gripper grip --hold-mass-kg 0.3 --gravity-deg -90 --wait 10 --link /dev/ttyACM0",
            ),
        ],
    ),
    (
        "gripper identify",
        &[(
            "The radius of the object there",
            "fre gripper identify radius --range-mm 20:50 --to-deg 15 --link /dev/ttyACM0",
        )],
    ),
    (
        "gripper run",
        &[(
            "A motion that `fre calibrate --plan` has written",
            "fre gripper run motion.csv --csv measured.csv --link /dev/ttyACM0",
        )],
    ),
    ("gripper release", &[("All fingers", "fre gripper release --link /dev/ttyACM0")]),
    ("gripper hold", &[("Finger 0 only", "fre gripper hold --finger 0 --link /dev/ttyACM0")]),
    ("gripper relax", &[("Finger 0 only", "fre gripper relax --finger 0 --link /dev/ttyACM0")]),
    ("gripper commission", &[("Servo 1 moves finger 0", "fre gripper commission --servo 1 --link /dev/ttyACM0")]),
    ("gripper scan", &[("Every servo at every rate", "fre gripper scan --link /dev/ttyACM0")]),
    ("log", &[("A board on a probe", "fre log opencr"), ("The image in QEMU", "fre log --qemu --seconds 5")]),
    (
        "monitor",
        &[
            ("Which serial ports there are", "fre monitor"),
            ("A gripper, in the terminal and in a file", "fre monitor --link /dev/ttyACM0 --log forces.csv"),
            ("Servos on a USB adapter, estimated here", "fre monitor --bus /dev/ttyUSB0 --case finger.toml"),
        ],
    ),
    (
        "replay",
        &[
            ("At its own speed", "fre replay forces.mcap"),
            ("With another modulus, compared", "fre replay forces.mcap --again --youngs-modulus-pa 5.2e7"),
            (
                "Forces for positions that another program recorded",
                "fre replay positions.csv --again --case finger.toml --csv forces.csv",
            ),
        ],
    ),
    (
        "ros2",
        &[
            ("A gripper", "fre ros2 --link /dev/ttyACM0"),
            (
                "Servos on a USB adapter, for this machine only",
                "fre ros2 --bus /dev/ttyUSB0 --case finger.toml --localhost",
            ),
            (
                "A recording, every message to every subscriber",
                "fre ros2 forces.mcap --qos reliable --wait-for-subscribers",
            ),
        ],
    ),
    ("servo", &[("On a pseudo-terminal, with a finger and its object", "fre servo finger.toml --pty")]),
    (
        "sim",
        &[
            ("A gripper to try everything on", "fre sim finger.toml"),
            ("As new, to commission it", "fre sim finger.toml --fresh"),
        ],
    ),
];

/// The command with its examples, and those below it with theirs.
pub fn added(command: Command) -> Command {
    below(command, "")
}

fn below(command: Command, words: &str) -> Command {
    let names: Vec<String> = command.get_subcommands().map(|below| below.get_name().to_owned()).collect();
    let command = match EXAMPLES.iter().find(|(of, _)| *of == words) {
        Some((_, examples)) => {
            let text = styled(examples, &command);
            command.after_help(text)
        }
        None => command,
    };
    names.into_iter().fold(command, |command, name| {
        let words = format!("{words} {name}").trim_start().to_owned();
        command.mut_subcommand(name, |found| below(found, &words))
    })
}

fn styled(examples: &[(&str, &str)], command: &Command) -> StyledStr {
    use std::fmt::Write as _;
    let (header, literal) = (command.get_styles().get_header(), command.get_styles().get_literal());
    let mut text = StyledStr::new();
    // Writing to a text cannot fail.
    let _ = write!(text, "{header}Examples:{header:#}");
    for (what, line) in examples {
        let _ = write!(text, "\n  {what}:\n    {literal}{line}{literal:#}");
    }
    text
}

#[cfg(test)]
mod tests {
    use clap::Command;

    use super::EXAMPLES;

    /// Every command with its words after `fre`.
    fn all(command: &Command, words: &str, found: &mut Vec<(String, Command)>) {
        found.push((words.to_owned(), command.clone()));
        for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
            all(below, format!("{words} {}", below.get_name()).trim_start(), found);
        }
    }

    fn commands() -> Vec<(String, Command)> {
        let mut command = crate::command();
        command.build();
        let mut found = Vec::new();
        all(&command, "", &mut found);
        found
    }

    #[test]
    fn every_example_is_understood() {
        for (of, examples) in EXAMPLES {
            for line in examples.iter().flat_map(|(_, line)| line.split("&&")).flat_map(|line| line.split('|')) {
                // What is between quotation marks is one word.
                let line = line.split('>').next().unwrap_or_default();
                let words: Vec<&str> = (line.split('\'').enumerate())
                    .flat_map(|(index, part)| match index % 2 {
                        0 => part.split_whitespace().collect(),
                        _ => vec![part],
                    })
                    .collect();
                if words.first() != Some(&"fre") || (cfg!(not(feature = "gripper")) && !of.is_empty()) {
                    continue;
                }
                if let Err(error) = crate::command().try_get_matches_from(&words) {
                    panic!("{line}: {error}");
                }
            }
        }
    }

    #[test]
    fn every_command_says_what_it_is_and_has_an_example() {
        let commands = commands();
        let mut faults = Vec::new();
        for (words, command) in &commands {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            if about.is_empty() {
                faults.push(format!("fre {words} does not say what it is"));
            }
            if about.chars().count() > 90 {
                faults.push(format!("fre {words}: \"{about}\" does not fit a line"));
            }
            if cfg!(feature = "gripper") && !EXAMPLES.iter().any(|(of, _)| of == words) {
                faults.push(format!("fre {words} has no example"));
            }
        }
        if cfg!(feature = "gripper") {
            let gone = EXAMPLES.iter().filter(|(of, _)| !commands.iter().any(|(words, _)| words == of));
            faults.extend(gone.map(|(of, _)| format!("there is no command fre {of}")));
        }
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }

    #[test]
    fn every_option_has_one_line_in_the_short_help() {
        let mut faults = Vec::new();
        for (words, command) in commands() {
            for argument in command.get_arguments().filter(|argument| !argument.is_hide_set()) {
                let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
                let name = argument.get_id();
                if !(1..=76).contains(&help.chars().count()) {
                    faults.push(format!("fre {words}: {name}: \"{help}\" is no line of 1 to 76 characters"));
                }
            }
        }
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }
}
