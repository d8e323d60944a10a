//! The gripper's image for ST's NUCLEO-F429ZI. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod clocks;

use embassy_executor::Spawner;
use embassy_stm32::flash::Flash;
use embassy_stm32::{pac, peripherals::IWDG};
use fre_boards::NUCLEO_F429ZI;
use gripper::{Board, ResetCause};
use stm32::port::{Receiver, Sender, halves};
use stm32::usart::{self, Direction, Wired};
use stm32::{Care, Dog, Line, Settings, critical, cycles, fast, reset};

/// Room for received and for sent bytes.
type Bus = stm32::Bus<512, 256>;
static BUS: Line<512, 256> = Line::new();
/// PF15 turns the transceiver's direction: this chip's USARTs have no output for it.
const BUS_USART: Wired = Wired::new(pac::USART6, Direction::Pin(pac::GPIOF, 15));

/// The ST-LINK's virtual serial port.
static LINK: Line<2048, 2048> = Line::new();
const LINK_USART: Wired = Wired::new(pac::USART3, Direction::None);
/// Rate of the virtual serial port, which the PC has to set as well.
const LINK_BAUD: u32 = 1_000_000;

/// The first two sectors of bank 2.
type Store = Settings<NoCaches, 0x10_0000, 0x8000, 0x4000>;

struct Nucleo;

impl Board for Nucleo {
    type Bus = Bus;
    type Flash = Store;
    type Watchdog = Dog<IWDG>;
    const NAME: &'static str = NUCLEO_F429ZI.name;
    const FINGERS: usize = NUCLEO_F429ZI.fingers;
    const BUS_LATENCY_US: u32 = stm32::BUS_LATENCY_US;
    const ANSWER_US: u32 = NUCLEO_F429ZI.answer_us;
    const COST_HZ: u32 = NUCLEO_F429ZI.clock_hz;
    // Much longer than a sector of 16 KB takes to erase.
    const WATCHDOG_MS: u32 = 3_000;
    const FLASH_STALLS: bool = NUCLEO_F429ZI.flash_stalls;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart(last_words: &'static str) -> ! {
        reset::end(&last_words)
    }
}

/// The flash interface's own caches are the driver's matter.
struct NoCaches;

impl Care for NoCaches {}

stm32::interrupts! {
    BUS by BUS_USART on USART6, LINK by LINK_USART on USART3;
    // Three devices that nothing here uses: their vectors wake whoever waits for a line, and run the two tasks.
    waking on CAN2_SCE; bus task on SAI1; control task on DCMI
}

gripper::tasks!(Nucleo, sends: Sender<2048, 2048>, hears: Receiver<2048, 2048>);

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
    defmt::info!("gripper on nucleo-f429zi, version {=str}", env!("CARGO_PKG_VERSION"));

    usart::direction(chip.PF15);
    let running = BUS_USART.start(chip.USART6, chip.PG14, chip.PG9, 1_000_000);
    let bus = Bus::new(&BUS, running);
    let link = LINK_USART.start(chip.USART3, chip.PD8, chip.PD9, LINK_BAUD);
    let (outgoing, incoming) = halves(&LINK, link.raise());

    let store = Store::new(Flash::new_blocking(chip.FLASH));
    run(above(), spawner, (bus, watchdog), (outgoing, incoming), (store, boot));
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
