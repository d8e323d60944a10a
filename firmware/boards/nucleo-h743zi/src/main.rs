//! The gripper's image for ST's NUCLEO-H743ZI. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod clocks;

use embassy_executor::{InterruptExecutor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::flash::Flash;
use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, pac, peripherals::IWDG1};
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
const BUS_USART: Wired = Wired::new(pac::USART2, Direction::DriverEnable);

/// The first revision that runs at 480 MHz (the NUCLEO-H743ZI2's; the older NUCLEO-H743ZI has revision Y).
const REVISION_V: u16 = 0x2003;

/// The ST-LINK's virtual serial port.
static LINK: Line<2048, 2048> = Line::new();
const LINK_USART: Wired = Wired::new(pac::USART3, Direction::None);
/// Rate of the virtual serial port, which the PC has to set as well.
const LINK_BAUD: u32 = 1_000_000;

/// The last two sectors of bank 2.
type Store = Settings<Caches, 0x1c_0000, 0x4_0000, 0x2_0000>;

struct Nucleo;

impl Board for Nucleo {
    type Bus = Bus;
    type Flash = Store;
    type Watchdog = Dog;
    const NAME: &'static str = "nucleo-h743zi";
    const FINGERS: usize = gripper::FINGERS;
    // A byte's time until the line counts as idle, two wake-ups, and the estimate of another finger before it.
    const BUS_LATENCY_US: u32 = 500;
    const COST_HZ: u32 = clocks::HZ;
    // Longer than a sector of 128 KB takes to erase, which holds the link, not the control task.
    const WATCHDOG_MS: u32 = 4_000;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart() -> ! {
        reset::restart()
    }
}

/// What the caches know of changed flash is forgotten.
struct Caches;

impl Care for Caches {
    fn changed(address: u32, bytes: u32) {
        let first = address as usize & !31;
        let end = (address + bytes) as usize;
        // SAFETY: the settings' sectors hold no variables: nothing dirty is thrown away.
        unsafe { cortex_m::Peripherals::steal().SCB.invalidate_dcache_by_address(first, end - first) };
    }
}

/// The chip's independent watchdog.
struct Dog(IndependentWatchdog<'static, IWDG1>);

impl gripper::Watchdog for Dog {
    fn feed(&mut self) {
        self.0.pet();
    }
}

bind_interrupts!(struct Interrupts {
    USART2 => OnBus;
    USART3 => OnLink;
    // Two devices that nothing here uses: the vector of the one wakes whoever waits for a line, that of the other runs the
    // control task.
    SPDIF_RX => Waking;
    CEC => Controlling;
});

struct OnBus;
impl Handler<typelevel::USART2> for OnBus {
    unsafe fn on_interrupt() {
        // Takes no lock: see `stm32::critical`.
        if BUS.service(&BUS_USART, cycles::now()) {
            typelevel::SPDIF_RX::pend();
        }
    }
}

struct OnLink;
impl Handler<typelevel::USART3> for OnLink {
    unsafe fn on_interrupt() {
        // Takes no lock either.
        if LINK.service(&LINK_USART, cycles::now()) {
            typelevel::SPDIF_RX::pend();
        }
    }
}

struct Waking;
impl Handler<typelevel::SPDIF_RX> for Waking {
    unsafe fn on_interrupt() {
        BUS.wake();
        LINK.wake();
    }
}

struct Controlling;
impl Handler<typelevel::CEC> for Controlling {
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
        core.SCB.enable_icache();
        core.SCB.enable_dcache(&mut core.CPUID);
        cycles::start(&mut core.DCB, &mut core.DWT);
    }
    if pac::DBGMCU.idc().read().rev_id() < REVISION_V {
        defmt::error!("this chip is older than revision V: 480 MHz are too much for it");
        loop {
            cortex_m::asm::wfi();
        }
    }
    let chip = embassy_stm32::init(clocks::config());
    let mut watchdog = IndependentWatchdog::new(chip.IWDG1, Nucleo::WATCHDOG_MS * 1000);
    watchdog.unleash();
    defmt::info!("gripper on nucleo-h743zi, version {=str}", env!("CARGO_PKG_VERSION"));

    // SAFETY: `Waking` is its handler.
    unsafe { typelevel::SPDIF_RX::enable() };
    let running = BUS_USART.start_with_driver_enable(chip.USART2, chip.PD5, chip.PD6, chip.PD4, 1_000_000);
    let bus = Bus::new(&BUS, running);
    let link = LINK_USART.start(chip.USART3, chip.PD8, chip.PD9, LINK_BAUD);
    let (outgoing, incoming) = halves(&LINK, link.raise());

    interrupt::CEC.set_priority(critical::CONTROL);
    match control(MODELS.take(), bus, Dog(watchdog)) {
        Ok(task) => CONTROL.start(interrupt::CEC).spawn(task),
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
    let flags = pac::RCC.rsr().read();
    pac::RCC.rsr().modify(|w| w.set_rmvf(true));
    match () {
        () if flags.porrstf() => ResetCause::PowerOn,
        () if flags.borrstf() => ResetCause::Brownout,
        () if flags.iwdg1rstf() || flags.wwdg1rstf() => ResetCause::Watchdog,
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
async fn send(link: Sender<2048, 2048>) -> ! {
    gripper::send(&SHARED, link).await
}

#[embassy_executor::task]
async fn answer(link: Receiver<2048, 2048>, store: Store, boot: Boot) -> ! {
    gripper::answer::<Nucleo, _>(&SHARED, link, store, boot).await
}
