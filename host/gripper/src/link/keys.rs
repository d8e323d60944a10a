//! A gripper's settings as keys and values for people and scripts: degrees instead of radians.

use fre::drive::{self, degrees as shown};
use messages::{Direction, FINGERS, Mount, Reaction, Role, Settings, Side, Silence, Support};

/// Why a key or a value makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// No `=`.
    #[error("`{0}` is not KEY=VALUE")]
    NoValue(String),
    /// Nobody knows the key.
    #[error("`{0}` is not a key; the keys are {keys}", keys = all().join(", "))]
    Unknown(String),
    /// The value cannot be that.
    #[error("{key}: `{value}` is not {allowed}")]
    Value {
        /// The key.
        key: String,
        /// The value.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// More fingers than there may be.
    #[error("{key}: fingers are 0 to {most}", most = FINGERS - 1)]
    Finger {
        /// The key.
        key: String,
    },
    /// A finger without those before it.
    #[error("{key}: there are {count} fingers, the next one is finger.{count}")]
    Gap {
        /// The key.
        key: String,
        /// How many there are.
        count: usize,
    },
}

/// One value of a finger's mount.
struct Key {
    name: &'static str,
    get: fn(&Mount) -> String,
    /// Sets it, or says what is allowed.
    set: fn(&mut Mount, &str) -> Result<(), &'static str>,
}

/// A kind of number that settings have.
trait Number: Sized {
    /// What is allowed.
    const ALLOWED: &'static str;
    /// Reads it.
    fn read(words: &str) -> Option<Self>;
}

impl Number for f32 {
    const ALLOWED: &'static str = "a number";
    fn read(words: &str) -> Option<Self> {
        words.parse().ok()
    }
}

/// A whole number that its type can have.
pub(crate) fn whole<T: TryFrom<u32>>(number: f64) -> Option<T> {
    let fits = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
    T::try_from(fits.then_some(number as u32)?).ok()
}

/// Whole numbers, which may be written as `200.0` as well.
macro_rules! whole_numbers {
    ($($type:ty: $allowed:literal),*) => {$(
        impl Number for $type {
            const ALLOWED: &'static str = $allowed;
            fn read(words: &str) -> Option<Self> {
                whole(words.parse().ok()?)
            }
        }
    )*};
}

whole_numbers!(u8: "a whole number from 0 to 255", u16: "a whole number from 0 to 65535", u32: "a whole number from 0 to 4294967295");

fn number<T: Number>(words: &str, place: &mut T) -> Result<(), &'static str> {
    *place = T::read(words).ok_or(T::ALLOWED)?;
    Ok(())
}

fn degrees(words: &str, place: &mut f32) -> Result<(), &'static str> {
    number(words, place)?;
    *place = place.to_radians();
    Ok(())
}

const KEYS: [Key; 14] = [
    Key { name: "servo_id", get: |m| m.servo_id.to_string(), set: |m, v| number(v, &mut m.servo_id) },
    Key {
        name: "zero_counts",
        get: |m| m.zero.to_string(),
        set: |m, v| {
            // Of no calibration any more.
            m.calibration = 0;
            number(v, &mut m.zero)
        },
    },
    Key {
        name: "reversed",
        get: |m| (m.direction == Direction::Reversed).to_string(),
        set: |m, v| {
            let reversed: bool = v.parse().map_err(|_| "true or false")?;
            m.direction = if reversed { Direction::Reversed } else { Direction::Same };
            Ok(())
        },
    },
    Key { name: "gear_ratio", get: |m| m.gear_ratio.to_string(), set: |m, v| number(v, &mut m.gear_ratio) },
    Key { name: "backlash_deg", get: |m| shown(m.backlash), set: |m, v| degrees(v, &mut m.backlash) },
    Key {
        name: "side",
        get: |m| if m.side == Side::Left { "left" } else { "right" }.to_owned(),
        set: |m, v| {
            m.side = match v {
                "left" => Side::Left,
                "right" => Side::Right,
                _ => return Err("left or right"),
            };
            Ok(())
        },
    },
    Key { name: "least_deg", get: |m| shown(m.range[0]), set: |m, v| degrees(v, &mut m.range[0]) },
    Key { name: "most_deg", get: |m| shown(m.range[1]), set: |m, v| degrees(v, &mut m.range[1]) },
    Key { name: "open_deg", get: |m| shown(m.open_angle), set: |m, v| degrees(v, &mut m.open_angle) },
    Key { name: "speed_deg_per_s", get: |m| shown(m.speed), set: |m, v| degrees(v, &mut m.speed) },
    Key { name: "force_limit_n", get: |m| m.force_limit.to_string(), set: |m, v| number(v, &mut m.force_limit) },
    Key { name: "current_limit_ma", get: |m| m.current_limit.to_string(), set: |m, v| number(v, &mut m.current_limit) },
    Key {
        name: "current_fence",
        get: |m| m.current_fence.to_string(),
        set: |m, v| {
            m.current_fence = v.parse().map_err(|_| "true or false")?;
            Ok(())
        },
    },
    Key {
        name: "drive",
        get: |m| drive::words(&m.drive),
        set: |m, v| {
            m.drive = drive::read(v).ok_or(drive::ALLOWED)?;
            Ok(())
        },
    },
];

/// Every key.
fn all() -> Vec<String> {
    let own = [
        "rate_hz",
        "shape_every",
        "on_fault",
        "untrusted_ms",
        "on_silence",
        "silence_ms",
        "heat_margin_k",
        "supply_margin_v",
        "on_strain",
        "object",
        "load_n",
        "moment_nmm",
    ];
    let bus = ["role", "device_id", "return_delay_us", "baud"];
    let own = own.into_iter().chain(bus).map(str::to_owned);
    own.chain(KEYS.iter().map(|key| format!("finger.N.{}", key.name))).collect()
}

/// Keys and values of settings, in the order in which [`set`] takes them.
pub fn pairs(settings: &Settings) -> Vec<(String, String)> {
    let reaction = |reaction| if reaction == Reaction::Hold { "hold" } else { "release" };
    let silence = match settings.on_silence {
        Silence::GoOn => "go-on",
        Silence::Hold => "hold",
        Silence::Release => "release",
    };
    let mut pairs = vec![
        ("rate_hz".to_owned(), settings.rate_hz.to_string()),
        ("shape_every".to_owned(), settings.shape_every.to_string()),
        ("on_fault".to_owned(), reaction(settings.on_fault).to_owned()),
        ("untrusted_ms".to_owned(), settings.untrusted_ms.to_string()),
        ("on_silence".to_owned(), silence.to_owned()),
        ("silence_ms".to_owned(), settings.silence_ms.to_string()),
        ("heat_margin_k".to_owned(), settings.heat_margin.to_string()),
        ("supply_margin_v".to_owned(), settings.supply_margin.to_string()),
        ("on_strain".to_owned(), reaction(settings.on_strain).to_owned()),
    ];
    match settings.support {
        Support::Fixed => pairs.push(("object".to_owned(), "fixed".to_owned())),
        Support::Free { load: [x, y], moment } => {
            pairs.push(("object".to_owned(), "free".to_owned()));
            pairs.push(("load_n".to_owned(), format!("{x},{y}")));
            pairs.push(("moment_nmm".to_owned(), moment.to_string()));
        }
    }
    let role = match settings.role {
        Role::Idle => "idle",
        Role::Master => "master",
        Role::Tap => "tap",
        Role::Device { .. } => "device",
    };
    pairs.push(("role".to_owned(), role.to_owned()));
    if let Role::Device { id, return_delay } = settings.role {
        pairs.push(("device_id".to_owned(), id.to_string()));
        pairs.push(("return_delay_us".to_owned(), (2 * u32::from(return_delay)).to_string()));
    }
    pairs.push(("baud".to_owned(), settings.baud.map_or("found".to_owned(), |baud| baud.to_string())));
    for (finger, mount) in settings.fingers.iter().flatten().enumerate() {
        pairs.extend(KEYS.iter().map(|key| (format!("finger.{finger}.{}", key.name), (key.get)(mount))));
    }
    pairs
}

/// Changes settings by `KEY=VALUE`. A key of the finger behind the last one adds a finger, whose servo's address is its
/// number plus one.
///
/// # Errors
/// The key or the value that makes no sense. (What is out of range the gripper refuses.)
pub fn set(settings: &mut Settings, words: &str) -> Result<(), KeyError> {
    let (key, value) = words.split_once('=').ok_or_else(|| KeyError::NoValue(words.to_owned()))?;
    let (key, value) = (key.trim(), value.trim());
    let wrong = |allowed| KeyError::Value { key: key.to_owned(), value: value.to_owned(), allowed };
    match key {
        "rate_hz" => return number(value, &mut settings.rate_hz).map_err(wrong),
        "shape_every" => return number(value, &mut settings.shape_every).map_err(wrong),
        "untrusted_ms" => return number(value, &mut settings.untrusted_ms).map_err(wrong),
        "silence_ms" => return number(value, &mut settings.silence_ms).map_err(wrong),
        "on_silence" => {
            settings.on_silence = match value {
                "go-on" => Silence::GoOn,
                "hold" => Silence::Hold,
                "release" => Silence::Release,
                _ => return Err(wrong("go-on, hold or release")),
            };
            return Ok(());
        }
        "heat_margin_k" => return number(value, &mut settings.heat_margin).map_err(wrong),
        "supply_margin_v" => return number(value, &mut settings.supply_margin).map_err(wrong),
        "on_fault" | "on_strain" => {
            let reaction = match value {
                "hold" => Reaction::Hold,
                "release" => Reaction::Release,
                _ => return Err(wrong("hold or release")),
            };
            *(if key == "on_fault" { &mut settings.on_fault } else { &mut settings.on_strain }) = reaction;
            return Ok(());
        }
        "object" => {
            settings.support = match (value, settings.support) {
                ("fixed", _) => Support::Fixed,
                ("free", known @ Support::Free { .. }) => known,
                ("free", _) => Support::Free { load: [0.0; 2], moment: 0.0 },
                _ => return Err(wrong("fixed or free")),
            };
            return Ok(());
        }
        "load_n" | "moment_nmm" => {
            let Support::Free { load, moment } = &mut settings.support else {
                return Err(wrong("for an object that is fixed: set object=free first"));
            };
            if key == "moment_nmm" {
                return number(value, moment).map_err(wrong);
            }
            let (x, y) = value.split_once(',').ok_or_else(|| wrong("X,Y in N"))?;
            let [old_x, old_y] = load;
            return number(x.trim(), old_x).and_then(|()| number(y.trim(), old_y)).map_err(|_| wrong("X,Y in N"));
        }
        "role" => {
            settings.role = match (value, settings.role) {
                ("idle", _) => Role::Idle,
                ("master", _) => Role::Master,
                ("tap", _) => Role::Tap,
                ("device", known @ Role::Device { .. }) => known,
                ("device", _) => Role::DEVICE,
                _ => return Err(wrong("idle, master, tap or device")),
            };
            return Ok(());
        }
        "device_id" | "return_delay_us" => {
            let Role::Device { id, return_delay } = &mut settings.role else {
                return Err(wrong("for this role: set role=device first"));
            };
            if key == "device_id" {
                return number(value, id).map_err(wrong);
            }
            let mut us = 0_u16;
            number(value, &mut us).map_err(wrong)?;
            *return_delay = u8::try_from(us.div_ceil(2)).map_err(|_| wrong("0 to 508"))?;
            return Ok(());
        }
        "baud" => {
            settings.baud = match value {
                "found" => None,
                _ => Some(value.parse().map_err(|_| wrong("a number, or `found`"))?),
            };
            return Ok(());
        }
        _ => {}
    }
    let unknown = || KeyError::Unknown(key.to_owned());
    let (finger, name) = key.strip_prefix("finger.").and_then(|rest| rest.split_once('.')).ok_or_else(unknown)?;
    let known = KEYS.iter().find(|known| known.name == name).ok_or_else(unknown)?;
    let finger: usize = finger.parse().map_err(|_| unknown())?;
    if finger >= FINGERS {
        return Err(KeyError::Finger { key: key.to_owned() });
    }
    let count = settings.count();
    if finger > count {
        return Err(KeyError::Gap { key: key.to_owned(), count });
    }
    let new = Mount { servo_id: finger as u8 + 1, ..Mount::DEFAULT };
    (known.set)(settings.fingers[finger].get_or_insert(new), value).map_err(wrong)
}

#[cfg(test)]
mod tests {
    use model_core::drive::Drive;

    use super::*;

    #[test]
    fn what_is_got_can_be_set() {
        let mount = Mount { zero: 12.5, side: Side::Right, direction: Direction::Reversed, ..Mount::DEFAULT };
        let role = Role::Device { id: 77, return_delay: 25 };
        let support = Support::Free { load: [0.25, -1.5], moment: 3.0 };
        let own = Settings { role, support, baud: Some(57_600), ..Settings::of(mount) };
        let mut settings = Settings { on_fault: Reaction::Release, rate_hz: 77, ..own };
        let drive = Drive::linear([0.8, -0.6], 10.5);
        settings.fingers[1] = Some(Mount { servo_id: 9, force_limit: 3.5, drive, ..Mount::DEFAULT });
        let mut back = Settings::DEFAULT;
        for (key, value) in pairs(&settings) {
            set(&mut back, &format!("{key} = {value}")).unwrap();
        }
        let ranges = pairs(&settings).into_iter().filter(|(key, _)| key.ends_with("_deg"));
        assert!(ranges.clone().any(|(_, value)| value == "-60"), "{:?}", ranges.collect::<Vec<_>>());
        let mount = back.fingers[0].unwrap();
        assert_eq!((mount.zero, mount.side, mount.direction), (12.5, Side::Right, Direction::Reversed));
        // Degrees and back: the last digit may differ.
        assert!((mount.range[1] - Mount::DEFAULT.range[1]).abs() < 1e-6 && back.rate_hz == 77);
        assert_eq!((back.count(), back.on_fault), (2, Reaction::Release));
        assert_eq!((back.role, back.baud, back.support), (role, Some(57_600), support));
        set(&mut back, "object=free").unwrap();
        assert_eq!(back.support, support, "the load is still known");
        set(&mut back, "object=fixed").unwrap();
        assert_eq!(back.support, Support::Fixed);
        set(&mut back, "baud=found").unwrap();
        set(&mut back, "role=tap").unwrap();
        assert_eq!((back.role, back.baud), (Role::Tap, None));
        let second = back.fingers[1].unwrap();
        assert_eq!((second.force_limit, second.drive, mount.drive), (3.5, drive, Drive::Rotating));
    }

    #[test]
    fn nonsense_is_explained() {
        let error = |words: &str| set(&mut Settings::DEFAULT.clone(), words).unwrap_err().to_string();
        assert_eq!(error("rate_hz"), "`rate_hz` is not KEY=VALUE");
        snapbox::assert_data_eq!(
            error("finger.0.colour=red"),
            snapbox::str![
                "`finger.0.colour` is not a key; the keys are rate_hz, shape_every, on_fault, untrusted_ms, on_silence, silence_ms, heat_margin_k, supply_margin_v, on_strain, object, load_n, moment_nmm, role, device_id, return_delay_us, baud, finger.N.servo_id, finger.N.zero_counts, finger.N.reversed, finger.N.gear_ratio, finger.N.backlash_deg, finger.N.side, finger.N.least_deg, finger.N.most_deg, finger.N.open_deg, finger.N.speed_deg_per_s, finger.N.force_limit_n, finger.N.current_limit_ma, finger.N.current_fence, finger.N.drive"
            ]
        );
        assert_eq!(error("finger.7.side=left"), "finger.7.side: fingers are 0 to 3");
        assert_eq!(error("finger.0.side=up"), "finger.0.side: `up` is not left or right");
        assert_eq!(error("role=slave"), "role: `slave` is not idle, master, tap or device");
        assert_eq!(error("device_id=7"), "device_id: `7` is not for this role: set role=device first");
        assert_eq!(error("load_n=0,-1"), "load_n: `0,-1` is not for an object that is fixed: set object=free first");
        let mut free = Settings { support: Support::Free { load: [1.0, 2.0], moment: 0.0 }, ..Settings::DEFAULT };
        let why = set(&mut free, "load_n=3").unwrap_err().to_string();
        assert_eq!(why, "load_n: `3` is not X,Y in N");
        for value in ["fast", "1000000", "-1", "200.5", "nan"] {
            let expected = format!("rate_hz: `{value}` is not a whole number from 0 to 65535");
            assert_eq!(error(&format!("rate_hz={value}")), expected);
        }
        assert_eq!(error("finger.0.gear_ratio=fast"), "finger.0.gear_ratio: `fast` is not a number");
        assert_eq!(error("finger.2.side=left"), "finger.2.side: there are 1 fingers, the next one is finger.1");
    }
}
