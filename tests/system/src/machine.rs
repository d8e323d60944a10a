//! Boots the firmware in QEMU with a simulated servo on its bus.

use std::error::Error;
use std::fs::File;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use fre::case::preset;
use fre_gripper::link::{Address, Link};
use fre_gripper::servo::{Clock, Config, Gains, Handle, Hub, Load, Running, Servo};
use fre_qemu::{Pace, Running as Board, Sockets};
use messages::Finger;
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;

use crate::cycles::Cycles;
use crate::shared_bus::{SharedBus, carry};

/// An instruction takes 4 ns: what fits into a tick does not depend on how busy the PC is, and costs are counts of
/// instructions. (Waiting, as for the servo, takes the PC's time.)
const COUNTING: Pace = Pace::Counted { shift: Machine::SHIFT };
/// Where the firmware's stack lies in QEMU: its end and its start.
const STACK: [u32; 2] = [0x2000_0000, 0x2008_0000];
/// How long QEMU may take to open its sockets.
const BOOT: Duration = Duration::from_secs(20);
/// How long an answer may take on a busy PC.
const ANSWER: Duration = Duration::from_secs(30);
/// Machines share the processors with their tests: one at a time.
static TURN: Mutex<()> = Mutex::new(());

/// Ø80 at Mid height, world frame, mm.
pub const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

/// The preset `ladder-80` as the microcontroller models it.
pub fn finger() -> Finger {
    let finger = preset("ladder-80").expect("a preset").expect("a sound one");
    Finger::elastic(finger.design, Discretisation::estimator(Physics::Extended))
}

/// What the finger asks of the servo: the same physics at full resolution, on [`OBJECT`].
fn load() -> Arc<Load> {
    static LOAD: OnceLock<Arc<Load>> = OnceLock::new();
    LOAD.get_or_init(|| load_of(OBJECT, 14.0)).clone()
}

/// The same on another object, up to an angle in degrees.
pub fn load_of(object: ObjectDesign, highest_deg: f64) -> Arc<Load> {
    load_on(&Drive::Rotating, object, highest_deg)
}

/// The same of a finger that the motor moves so.
pub fn load_on(drive: &Drive, object: ObjectDesign, highest_deg: f64) -> Arc<Load> {
    Arc::new(Load::of(&finger().design, object, drive, &Load::REFERENCE, highest_deg).expect("a load"))
}

/// The firmware's ELF.
///
/// # Panics
/// `FRE_FIRMWARE_ELF` does not name one.
pub fn firmware() -> PathBuf {
    let Some(elf) = std::env::var_os("FRE_FIRMWARE_ELF").map(PathBuf::from) else {
        panic!("FRE_FIRMWARE_ELF does not name the firmware's ELF: run these tests by `cargo xtask test`");
    };
    elf
}

/// A gripper that runs until this is dropped.
pub struct Machine {
    board: Board,
    /// The first servo: the truth, and faults on purpose.
    pub servo: Handle,
    /// All of them.
    pub servos: Vec<Handle>,
    _bus: Running,
    sockets: Sockets,
    _turn: MutexGuard<'static, ()>,
}

impl Machine {
    /// A servo with the greatest gains, which goes where it is led, at 1 Mbaud, whose time passes by the reads of its position, 2 ms each; it starts at −1°.
    pub fn servo() -> Config {
        Config {
            baud_rate: 1_000_000,
            clock: Clock::Requests { period_us: 2_000 },
            start_deg: Some(-1.0),
            gains: Gains::GREATEST,
            load: load(),
            ..Config::default()
        }
    }

    /// An instruction takes 2^2 ns, where nothing else is said.
    pub const SHIFT: u8 = 2;
    /// Instructions in a tick of the cost clock then.
    pub const INSTRUCTIONS_PER_TICK: u32 = Self::instructions_per_tick(Self::SHIFT);

    /// Instructions in a tick of the cost clock, 40 ns, where one takes 2^`shift` ns.
    pub const fn instructions_per_tick(shift: u8) -> u32 {
        40 >> shift
    }

    /// Boots with such a servo.
    pub fn boot(servo: Config) -> Self {
        Self::boot_all(vec![servo])
    }

    /// Boots with several servos.
    pub fn boot_all(servos: Vec<Config>) -> Self {
        Self::boot_on(Hub::new(), servos, (COUNTING, None), |hub, socket| hub.connect_unix(socket).map_err(Into::into))
    }

    /// Boots with a servo; an instruction takes 2^`shift` ns.
    pub fn boot_paced(servo: Config, shift: u8) -> Self {
        let pace = Pace::Counted { shift };
        Self::boot_on(Hub::new(), vec![servo], (pace, None), |hub, socket| hub.connect_unix(socket).map_err(Into::into))
    }

    /// Boots with a servo, and measures the cycles of the real chips; an instruction takes 2^`shift` ns.
    pub fn boot_measured(servo: Config, cycles: &Cycles, shift: u8) -> Self {
        let pace = Pace::Counted { shift };
        Self::boot_on(Hub::new(), vec![servo], (pace, Some(cycles)), |hub, socket| {
            hub.connect_unix(socket).map_err(Into::into)
        })
    }

    /// Boots on a bus that another master leads.
    pub fn boot_shared(servo: Config) -> (Self, SharedBus) {
        let mut hub = Hub::new();
        let port = hub.pty().expect("a pseudo-terminal");
        let said = Arc::<AtomicU64>::default();
        let bus = SharedBus { port, said: said.clone() };
        let machine = Self::boot_on(hub, vec![servo], (COUNTING, None), |hub, socket| {
            Ok(carry(UnixStream::connect(socket)?, hub.stream()?, said.clone())?)
        });
        (machine, bus)
    }

    fn boot_on(
        mut hub: Hub,
        servos: Vec<Config>,
        (pace, cycles): (Pace, Option<&Cycles>),
        connect: impl Fn(&mut Hub, &Path) -> Result<(), Box<dyn Error>>,
    ) -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let sockets = Sockets::new().expect("a folder for the sockets");
        let log = File::create(sockets.folder().join("log")).expect("a file for the log");
        let image = cycles.map_or_else(firmware, |cycles| cycles.image().to_owned());
        let machine =
            fre_qemu::Machine::new(&image).pace(pace).listening(&sockets).monitored(&sockets.folder().join("monitor"));
        let machine = cycles.map_or(machine.clone(), |cycles| cycles.on(machine));
        let mut board = machine.boot(log).unwrap_or_else(|error| panic!("{error}"));
        let connected = board.until("connection to the bus", BOOT, || connect(&mut hub, &sockets.bus()));
        connected.unwrap_or_else(|error| panic!("{error}"));
        let servos: Vec<Handle> =
            servos.into_iter().map(|servo| hub.servo(Servo::new(servo).expect("a servo"))).collect();
        let servo = servos.first().expect("a servo").clone();
        let bus = hub.spawn().expect("a bus");
        Self { board, servo, servos, _bus: bus, sockets, _turn: turn }
    }

    /// Bytes of the stack that were ever written. (It lies at the bottom of the RAM, which is all zeros at first.)
    pub fn stack_depth(&self) -> u32 {
        let stack = self.board.memory(STACK[0], STACK[1] - STACK[0]).expect("the board's memory");
        let untouched = stack.iter().take_while(|&&byte| byte == 0).count();
        (stack.len() - untouched) as u32
    }

    /// Stops QEMU where it is: it answers nothing, and its sockets stay open.
    pub fn freeze(&self) {
        self.signal("-STOP");
    }

    /// Lets it go on.
    pub fn thaw(&self) {
        self.signal("-CONT");
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([name, &self.board.id().to_string()]).status().expect("kill");
        assert!(sent.success(), "{sent}");
    }

    /// Where the link's socket is.
    pub fn address(&self) -> Address {
        Address::Unix(self.sockets.link())
    }

    /// A connection to the gripper. The board has one socket: drop it before the next.
    pub fn link(&self) -> Link {
        let mut link = Link::open_within(&self.address(), BOOT).expect("a link");
        link.set_patience(ANSWER);
        link
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // `cargo xtask` decodes it.
            let kept = std::env::temp_dir().join("gripper-mps2.log");
            if std::fs::copy(self.sockets.folder().join("log"), &kept).is_ok() {
                eprintln!("the firmware's log (defmt frames) is in {}", kept.display());
            }
            eprintln!("QEMU said: {}", self.board.words());
        }
    }
}
