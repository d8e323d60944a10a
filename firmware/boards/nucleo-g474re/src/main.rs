//! The gripper's image for ST's NUCLEO-G474RE. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod clocks;

use embassy_executor::{InterruptExecutor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::flash::Flash;
use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, pac, peripherals::IWDG};
use gripper::{Board, Boot, Model, ResetCause, Shared};
use static_cell::ConstStaticCell;
use stm32::port::{Receiver, Sender, halves};
use stm32::usart::{Direction, Wired};
use stm32::{Care, Line, Settings, critical, cycles, reset};

static SHARED: Shared = Shared::new();
static MODELS: ConstStaticCell<[Model; Nucleo::FINGERS]> =
    ConstStaticCell::new([const { Model::EMPTY }; Nucleo::FINGERS]);
static CONTROL: InterruptExecutor = InterruptExecutor::new();

/// Room for received and for sent bytes.
type Bus = stm32::Bus<512, 256>;
static BUS: Line<512, 256> = Line::new();
/// The USART drives the transceiver's direction itself.
const BUS_USART: Wired = Wired::new(pac::USART1, Direction::DriverEnable);

/// The ST-LINK's virtual serial port.
static LINK: Line<1536, 1024> = Line::new();
const LINK_USART: Wired = Wired::new(pac::USART2, Direction::None);
/// Rate of the virtual serial port, which the PC has to set as well.
const LINK_BAUD: u32 = 1_000_000;

/// The last pages of bank 2.
type Store = Settings<NoCaches, 0x7_c000, 0x4000, 0x800>;

struct Nucleo;

impl Board for Nucleo {
    type Bus = Bus;
    type Flash = Store;
    type Watchdog = Dog;
    const NAME: &'static str = "nucleo-g474re";
    const FINGERS: usize = 1;
    // A byte's time until the line counts as idle, two wake-ups, and the estimate of another finger before it.
    const BUS_LATENCY_US: u32 = 500;
    const COST_HZ: u32 = clocks::HZ;
    // Much longer than a page of 2 KB takes to erase.
    const WATCHDOG_MS: u32 = 2_000;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart() -> ! {
        reset::restart()
    }
}

/// The flash interface's own caches are the driver's matter.
struct NoCaches;

impl Care for NoCaches {}

/// The chip's independent watchdog.
struct Dog(IndependentWatchdog<'static, IWDG>);

impl gripper::Watchdog for Dog {
    fn feed(&mut self) {
        self.0.pet();
    }
}

bind_interrupts!(struct Interrupts {
    USART1 => OnBus;
    USART2 => OnLink;
    // Two devices that nothing here uses: the vector of the one wakes whoever waits for a line, that of the other runs the
    // control task.
    FMAC => Waking;
    CORDIC => Controlling;
});

struct OnBus;
impl Handler<typelevel::USART1> for OnBus {
    unsafe fn on_interrupt() {
        // Takes no lock: see `stm32::critical`.
        if BUS.service(&BUS_USART, cycles::now()) {
            typelevel::FMAC::pend();
        }
    }
}

struct OnLink;
impl Handler<typelevel::USART2> for OnLink {
    unsafe fn on_interrupt() {
        // Takes no lock either.
        if LINK.service(&LINK_USART, cycles::now()) {
            typelevel::FMAC::pend();
        }
    }
}

struct Waking;
impl Handler<typelevel::FMAC> for Waking {
    unsafe fn on_interrupt() {
        BUS.wake();
        LINK.wake();
    }
}

struct Controlling;
impl Handler<typelevel::CORDIC> for Controlling {
    unsafe fn on_interrupt() {
        // SAFETY: this is its interrupt, which `main` lets through by starting the executor.
        unsafe { CONTROL.on_interrupt() };
    }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let boot = reset::boot(cause());
    if let Some(mut core) = cortex_m::Peripherals::take() {
        critical::prepare(&mut core.SCB, &mut core.NVIC);
        cycles::start(&mut core.DCB, &mut core.DWT);
    }
    let chip = embassy_stm32::init(clocks::config());
    let mut watchdog = IndependentWatchdog::new(chip.IWDG, Nucleo::WATCHDOG_MS * 1000);
    watchdog.unleash();
    defmt::info!("gripper on nucleo-g474re, version {=str}", env!("CARGO_PKG_VERSION"));

    // SAFETY: `Waking` is its handler.
    unsafe { typelevel::FMAC::enable() };
    let running = BUS_USART.start_with_driver_enable(chip.USART1, chip.PA9, chip.PA10, chip.PA12, 1_000_000);
    let bus = Bus::new(&BUS, running);
    let link = LINK_USART.start(chip.USART2, chip.PA2, chip.PA3, LINK_BAUD);
    let (outgoing, incoming) = halves(&LINK, link.raise());

    interrupt::CORDIC.set_priority(critical::CONTROL);
    match control(MODELS.take(), bus, Dog(watchdog)) {
        Ok(task) => CONTROL.start(interrupt::CORDIC).spawn(task),
        Err(_) => defmt::error!("no room for the control task"),
    }
    start(spawner, send(outgoing));
    start(spawner, answer(incoming, Store::new(Flash::new_blocking(chip.FLASH)), boot));
}

fn start<S>(spawner: Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::error!("no room for a task"),
    }
}

/// Why the processor started, by its flags, which are cleared.
fn cause() -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    match () {
        // This chip does not tell power-on from brown-out.
        () if flags.borrstf() => ResetCause::PowerOn,
        () if flags.iwdgrstf() || flags.wwdgrstf() => ResetCause::Watchdog,
        () if flags.sftrstf() => ResetCause::Software,
        () if flags.pinrstf() => ResetCause::Pin,
        () => ResetCause::Unknown,
    }
}

#[embassy_executor::task]
async fn control(models: &'static mut [Model; Nucleo::FINGERS], bus: Bus, watchdog: Dog) -> ! {
    gripper::control::<Nucleo>(&SHARED, models, bus, watchdog).await
}

#[embassy_executor::task]
async fn send(link: Sender<1536, 1024>) -> ! {
    gripper::send(&SHARED, link).await
}

#[embassy_executor::task]
async fn answer(link: Receiver<1536, 1024>, store: Store, boot: Boot) -> ! {
    gripper::answer::<Nucleo, _>(&SHARED, link, store, boot).await
}
