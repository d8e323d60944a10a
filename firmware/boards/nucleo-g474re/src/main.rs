//! The gripper's image for ST's NUCLEO-G474RE. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod clocks;

use cortex_m_rt::exception;
use embassy_executor::Spawner;
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::{pac, peripherals::IWDG};
use embedded_storage::nor_flash::NorFlashErrorKind;
use fre_boards::NUCLEO_G474RE;
use gripper::{Board, ResetCause};
use stm32::port::{Receiver, Sender, halves};
use stm32::usart::{Direction, Wired};
use stm32::{Care, Dog, Line, Settings, critical, cycles, fast, reset, stalling, torn};

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

/// Bytes of a page.
const PAGE: u32 = 0x800;
/// The last pages of bank 2.
type Store = Settings<Correcting, 0x7_c000, 0x4000, PAGE>;

struct Nucleo;

impl Board for Nucleo {
    type Bus = Bus;
    type Flash = Store;
    type Watchdog = Dog<IWDG>;
    const NAME: &'static str = NUCLEO_G474RE.name;
    const FINGERS: usize = NUCLEO_G474RE.fingers;
    const BUS_LATENCY_US: u32 = stm32::BUS_LATENCY_US;
    const ANSWER_US: u32 = NUCLEO_G474RE.answer_us;
    const COST_HZ: u32 = NUCLEO_G474RE.clock_hz;
    // Much longer than a page of 2 KB takes to erase.
    const WATCHDOG_MS: u32 = 2_000;
    const FLASH_STALLS: bool = NUCLEO_G474RE.flash_stalls;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart(last_words: &'static str) -> ! {
        reset::end(&last_words)
    }
}

/// The program goes on in the bank of the settings. A word that its error correction gives up raises a non-maskable interrupt.
struct Correcting;

impl Care for Correcting {
    fn erase(_: &mut Flash<'static, Blocking>, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        stalling::erase::<PAGE>(from, to)
    }

    fn write(_: &mut Flash<'static, Blocking>, place: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        stalling::write(place, bytes)
    }

    fn read(address: u32, into: &mut [u8]) -> bool {
        // SAFETY: `Settings` asks for addresses inside the flash.
        unsafe { torn::read(address, into) }
    }
}

// SAFETY: touches the flash's flags and atomics only, or ends the program.
#[exception]
unsafe fn NonMaskableInt() {
    let flags = pac::FLASH.eccr().read();
    let gives_up = flags.eccd() || flags.eccd2();
    // Ones clear them.
    pac::FLASH.eccr().write_value(flags);
    if !(gives_up && torn::is_expected()) {
        reset::end(&format_args!("non-maskable interrupt; flash at {:#x} gives up: {gives_up}", flags.addr_ecc()));
    }
}

stm32::interrupts! {
    BUS by BUS_USART on USART1, LINK by LINK_USART on USART2;
    // Three devices that nothing here uses: their vectors wake whoever waits for a line, and run the two tasks.
    waking on FMAC; bus task on SAI1; control task on CORDIC
}

gripper::tasks!(Nucleo, sends: Sender<1536, 1024>, hears: Receiver<1536, 1024>);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let boot = reset::boot(cause());
    if let Some(mut core) = cortex_m::Peripherals::take() {
        fast::load(&mut core.SCB);
        critical::prepare(&mut core.SCB, &mut core.NVIC);
        cycles::start(&mut core.DCB, &mut core.DWT);
    }
    let chip = embassy_stm32::init(clocks::config());
    let watchdog = Dog::start(chip.IWDG, Nucleo::WATCHDOG_MS);
    defmt::info!("gripper on nucleo-g474re, version {=str}", env!("CARGO_PKG_VERSION"));

    let running = BUS_USART.start_with_driver_enable(chip.USART1, chip.PA9, chip.PA10, chip.PA12, 1_000_000);
    let bus = Bus::new(&BUS, running);
    let link = LINK_USART.start(chip.USART2, chip.PA2, chip.PA3, LINK_BAUD);
    let (outgoing, incoming) = halves(&LINK, link.raise());

    let store = Store::new(Flash::new_blocking(chip.FLASH));
    run(above(), spawner, (bus, watchdog), (outgoing, incoming), (store, boot));
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
