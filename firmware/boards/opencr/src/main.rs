//! The gripper's image for ROBOTIS' OpenCR 1.0. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod before;
mod clocks;
mod usb_link;
mod watchdog;

use embassy_executor::{InterruptExecutor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::{bind_interrupts, pac, peripherals, usb};
use gripper::{Board, Boot, Model, ResetCause, Shared};
use static_cell::ConstStaticCell;
use stm32::usart::{self, Direction, Wired};
use stm32::{Care, Line, Settings, critical, cycles, reset};
use usb_link::{Incoming, Outgoing};
use watchdog::Timer;

static SHARED: Shared = Shared::new();
static MODELS: ConstStaticCell<[Model; OpenCr::FINGERS]> =
    ConstStaticCell::new([const { Model::EMPTY }; OpenCr::FINGERS]);
static CONTROL: InterruptExecutor = InterruptExecutor::new();

/// Room for received and for sent bytes.
type BusLine = Line<512, 256>;
type Bus = stm32::Bus<512, 256>;
static BUS: BusLine = Line::new();
/// PC9 enables the board's transmitter.
const BUS_USART: Wired = Wired::new(pac::USART6, Direction::Pin(pac::GPIOC, 9));

/// Sectors 2 and 3 of the flash, which the boot loader leaves free.
type Store = Settings<Caches, 0x1_0000, 0x1_0000, 0x8000>;

struct OpenCr;

impl Board for OpenCr {
    type Bus = Bus;
    type Flash = Store;
    type Watchdog = Timer;
    const NAME: &'static str = "opencr";
    // At 216 MHz more than two are hardly served in time.
    const FINGERS: usize = 2;
    // A byte's time until the line counts as idle, two wake-ups, and the estimate of another finger before it.
    const BUS_LATENCY_US: u32 = 500;
    const COST_HZ: u32 = clocks::HZ;
    const WATCHDOG_MS: u32 = watchdog::MS;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart() -> ! {
        reset::restart()
    }
}

/// The flash is erased by words, and what the caches know of it is forgotten.
struct Caches;

impl Care for Caches {
    fn before_erasing() {
        // The width stays as it is set while the driver erases; by bytes it takes twice as long.
        if pac::FLASH.cr().read().lock() {
            pac::FLASH.keyr().write_value(0x4567_0123);
            pac::FLASH.keyr().write_value(0xcdef_89ab);
        }
        pac::FLASH.cr().modify(|w| w.set_psize(pac::flash::vals::Psize::PSIZE32));
    }

    fn changed(address: u32, bytes: u32) {
        let first = address as usize & !31;
        let end = (address + bytes) as usize;
        // SAFETY: the settings' sectors hold no variables: nothing dirty is thrown away.
        unsafe { cortex_m::Peripherals::steal().SCB.invalidate_dcache_by_address(first, end - first) };
    }
}

bind_interrupts!(struct Interrupts {
    USART6 => Bus6;
    // No CAN here: its vector wakes whoever waits for the bus.
    CAN2_SCE => Waking;
    // Nor HDMI-CEC: its vector runs the control task.
    CEC => Controlling;
    TIM7 => watchdog::Biting;
    OTG_FS => usb::InterruptHandler<peripherals::USB_OTG_FS>;
});

struct Bus6;
impl Handler<typelevel::USART6> for Bus6 {
    unsafe fn on_interrupt() {
        // Takes no lock: see `stm32::critical`.
        if BUS.service(&BUS_USART, cycles::now()) {
            typelevel::CAN2_SCE::pend();
        }
    }
}

struct Waking;
impl Handler<typelevel::CAN2_SCE> for Waking {
    unsafe fn on_interrupt() {
        BUS.wake();
    }
}

struct Controlling;
impl Handler<typelevel::CEC> for Controlling {
    unsafe fn on_interrupt() {
        // SAFETY: this is its interrupt, which `start` below lets through.
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
    let chip = embassy_stm32::init(clocks::config());
    let watchdog = Timer::start(chip.IWDG);
    defmt::info!("gripper on opencr, version {=str}", env!("CARGO_PKG_VERSION"));

    usart::direction(chip.PC9);
    let running = BUS_USART.start(chip.USART6, chip.PC6, chip.PC7, 1_000_000);
    let bus = Bus::new(&BUS, running);
    // SAFETY: `Waking` is its handler.
    unsafe { typelevel::CAN2_SCE::enable() };
    // Power for the Dynamixel connectors, from now on.
    core::mem::forget(Output::new(chip.PF15, Level::High, Speed::Low));

    let link = usb_link::start(chip.USB_OTG_FS, Interrupts, chip.PA12, chip.PA11);
    interrupt::CEC.set_priority(critical::CONTROL);
    match control(MODELS.take(), bus, watchdog) {
        Ok(task) => CONTROL.start(interrupt::CEC).spawn(task),
        Err(_) => defmt::error!("no room for the control task"),
    }
    start(spawner, usb_link::run(link.device));
    start(spawner, send(link.outgoing));
    start(spawner, answer(link.incoming, Store::new(Flash::new_blocking(chip.FLASH)), boot));
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
        () if flags.porrstf() => ResetCause::PowerOn,
        () if flags.borrstf() => ResetCause::Brownout,
        () if flags.wdgrstf() || flags.wwdgrstf() => ResetCause::Watchdog,
        () if flags.sftrstf() => ResetCause::Software,
        () if flags.padrstf() => ResetCause::Pin,
        () => ResetCause::Unknown,
    }
}

#[embassy_executor::task]
async fn control(models: &'static mut [Model; OpenCr::FINGERS], bus: Bus, watchdog: Timer) -> ! {
    gripper::control::<OpenCr>(&SHARED, models, bus, watchdog).await
}

#[embassy_executor::task]
async fn send(link: Outgoing) -> ! {
    gripper::send(&SHARED, link).await
}

#[embassy_executor::task]
async fn answer(link: Incoming, store: Store, boot: Boot) -> ! {
    gripper::answer::<OpenCr, _>(&SHARED, link, store, boot).await
}
