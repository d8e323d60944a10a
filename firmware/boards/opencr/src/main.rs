//! The gripper's image for ROBOTIS' OpenCR 1.0. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod accelerator;
mod before;
mod clock;
mod clocks;
mod usb_link;
mod watchdog;

use embassy_executor::Spawner;
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::{bind_interrupts, pac, peripherals, usb};
use embedded_storage::nor_flash::NorFlashErrorKind;
use fre_boards::OPENCR;
use gripper::{Board, ResetCause};
use stm32::usart::{self, Direction, Wired};
use stm32::{Care, Line, Settings, critical, cycles, fast, guard, near, reset, stalling};
use usb_link::{Incoming, Outgoing};
use watchdog::Timer;

/// Room for received and for sent bytes.
type BusLine = Line<512, 256>;
type Bus = stm32::Bus<512, 256>;
static BUS: BusLine = Line::new();
/// PC9 enables the board's transmitter.
const BUS_USART: Wired = Wired::new(pac::USART6, Direction::Pin(pac::GPIOC, 9));

/// Bytes of a sector, of the first four.
const SECTOR: u32 = 0x8000;
/// Sectors 2 and 3 of the flash, which the boot loader leaves free.
type Store = Settings<Caches, 0x1_0000, 0x1_0000, SECTOR>;

struct OpenCr;

impl Board for OpenCr {
    type Bus = Bus;
    type Flash = Store;
    type Watchdog = Timer;
    const NAME: &'static str = OPENCR.name;
    const FINGERS: usize = OPENCR.fingers;
    const BUS_LATENCY_US: u32 = stm32::BUS_LATENCY_US;
    const ANSWER_US: u32 = OPENCR.answer_us;
    const COST_HZ: u32 = OPENCR.clock_hz;
    const WATCHDOG_MS: u32 = watchdog::MS;
    const FLASH_STALLS: bool = OPENCR.flash_stalls;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart(last_words: &'static str) -> ! {
        reset::end(&last_words)
    }
}

/// The flash has one bank, in which the program is as well. What the caches know of it is forgotten.
struct Caches;

impl Care for Caches {
    fn erase(_: &mut Flash<'static, Blocking>, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let mut sectors = (from..to).step_by(SECTOR as usize);
        sectors.try_for_each(|sector| clock::kept(|| stalling::erase::<SECTOR>(sector, sector + SECTOR)))
    }

    fn write(_: &mut Flash<'static, Blocking>, place: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        stalling::write(place, bytes)
    }

    fn changed(address: u32, bytes: u32) {
        stm32::forget_cached(address, bytes);
    }
}

stm32::interrupts! {
    BUS by BUS_USART on USART6;
    // No CAN here, nor camera, nor HDMI-CEC: their vectors wake whoever waits for the bus, and run the two tasks.
    waking on CAN2_SCE; bus task on DCMI; control task on CEC
}

bind_interrupts!(struct Interrupts {
    TIM7 => watchdog::Biting;
    OTG_FS => usb::InterruptHandler<peripherals::USB_OTG_FS>;
});

gripper::tasks!(OpenCr, sends: Outgoing, hears: Incoming);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let boot = reset::boot(cause());
    near::clear();
    if let Some(mut core) = cortex_m::Peripherals::take() {
        guard::below_stack(&mut core.MPU);
        fast::load(&mut core.SCB);
        critical::prepare(&mut core.SCB, &mut core.NVIC);
        core.SCB.enable_icache();
        core.SCB.enable_dcache(&mut core.CPUID);
        cycles::start(&mut core.DCB, &mut core.DWT);
    }
    let chip = embassy_stm32::init(clocks::config());
    accelerator::start();
    let watchdog = Timer::start(chip.IWDG);
    defmt::info!("gripper on opencr, version {=str}", env!("CARGO_PKG_VERSION"));

    usart::direction(chip.PC9);
    let running = BUS_USART.start(chip.USART6, chip.PC6, chip.PC7, 1_000_000);
    let bus = Bus::new(&BUS, running);
    // Power for the Dynamixel connectors, from now on.
    core::mem::forget(Output::new(chip.PF15, Level::High, Speed::Low));

    let link = usb_link::start(chip.USB_OTG_FS, Interrupts, chip.PA12, chip.PA11);
    match usb_link::run(link.device) {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::error!("no room for the USB task"),
    }
    let store = Store::new(Flash::new_blocking(chip.FLASH));
    run(above(), spawner, (bus, watchdog), (link.outgoing, link.incoming), (store, boot));
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
