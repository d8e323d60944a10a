//! The gripper's image for ST's NUCLEO-H743ZI. README.md says where each fact about the board comes from.

#![no_std]
#![no_main]

mod clocks;

use embassy_executor::Spawner;
use embassy_stm32::flash::Flash;
use embassy_stm32::{pac, peripherals::IWDG1};
use fre_boards::NUCLEO_H743ZI;
use gripper::{Board, ResetCause};
use stm32::port::{Receiver, Sender, halves};
use stm32::usart::{Direction, Wired};
use stm32::{Care, Dog, Line, Settings, critical, cycles, fast, near, reset, torn};

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
    type Watchdog = Dog<IWDG1>;
    const NAME: &'static str = NUCLEO_H743ZI.name;
    const FINGERS: usize = NUCLEO_H743ZI.fingers;
    const BUS_LATENCY_US: u32 = stm32::BUS_LATENCY_US;
    const ANSWER_US: u32 = NUCLEO_H743ZI.answer_us;
    const COST_HZ: u32 = NUCLEO_H743ZI.clock_hz;
    // Longer than a sector of 128 KB takes to erase, which holds the link, not the control task.
    const WATCHDOG_MS: u32 = 4_000;
    const FLASH_STALLS: bool = NUCLEO_H743ZI.flash_stalls;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart(last_words: &'static str) -> ! {
        reset::end(&last_words)
    }
}

/// What the caches know of changed flash is forgotten; what error correction says of a read is not left for the next write, which
/// would take it for its own failure.
struct Caches;

impl Care for Caches {
    fn read(address: u32, into: &mut [u8]) -> bool {
        // SAFETY: `Settings` asks for addresses inside the flash.
        let whole = unsafe { torn::read(address, into) };
        let mut sound = true;
        for bank in [0, 1] {
            let bank = pac::FLASH.bank(bank);
            sound &= !bank.sr().read().dbeccerr();
            bank.ccr().write(|w| {
                w.set_clr_sneccerr(true);
                w.set_clr_dbeccerr(true);
            });
        }
        if !sound {
            // The line that was filled with it must not answer the next read.
            stm32::forget_cached(address, into.len() as u32);
        }
        whole && sound
    }

    fn changed(address: u32, bytes: u32) {
        stm32::forget_cached(address, bytes);
    }
}

stm32::interrupts! {
    BUS by BUS_USART on USART2, LINK by LINK_USART on USART3;
    // Three devices that nothing here uses: their vectors wake whoever waits for a line, and run the two tasks.
    waking on SPDIF_RX; bus task on DCMI; control task on CEC
}

gripper::tasks!(Nucleo, sends: Sender<2048, 2048>, hears: Receiver<2048, 2048>);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    near::clear();
    let boot = reset::boot(cause());
    if let Some(mut core) = cortex_m::Peripherals::take() {
        fast::load(&mut core.SCB);
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
    let watchdog = Dog::start(chip.IWDG1, Nucleo::WATCHDOG_MS);
    defmt::info!("gripper on nucleo-h743zi, version {=str}", env!("CARGO_PKG_VERSION"));

    let running = BUS_USART.start_with_driver_enable(chip.USART2, chip.PD5, chip.PD6, chip.PD4, 1_000_000);
    let bus = Bus::new(&BUS, running);
    let link = LINK_USART.start(chip.USART3, chip.PD8, chip.PD9, LINK_BAUD);
    let (outgoing, incoming) = halves(&LINK, link.raise());

    let store = Store::new(Flash::new_blocking(chip.FLASH));
    run(above(), spawner, (bus, watchdog), (outgoing, incoming), (store, boot));
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
