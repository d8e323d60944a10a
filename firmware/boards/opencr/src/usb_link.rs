//! The link to the host: a serial port over USB (CDC ACM).

use embassy_stm32::usb::{self, Driver};
use embassy_stm32::{
    Peri,
    interrupt::typelevel::{Binding, OTG_FS},
    peripherals,
};
use embassy_usb::class::cdc_acm::{BufferedReceiver, CdcAcmClass, Sender, State};
use embassy_usb::{Builder, UsbDevice};
use embedded_io_async::{ErrorType, Read};
use static_cell::{ConstStaticCell, StaticCell};

use crate::watchdog;

type Otg = Driver<'static, peripherals::USB_OTG_FS>;
/// What goes to the host.
pub type Outgoing = Sender<'static, Otg>;
/// What comes from the host. Bytes at [`CALL`] are for the boot loader.
pub struct Incoming(BufferedReceiver<'static, Otg>);

/// Bytes of a packet at full speed.
const PACKET: usize = 64;
/// The port's rate by which a host calls the boot loader, as it does with ROBOTIS' own programs.
const CALL: u32 = 1200;

impl ErrorType for Incoming {
    type Error = <BufferedReceiver<'static, Otg> as ErrorType>::Error;
}

impl Read for Incoming {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, Self::Error> {
        let count = self.0.read(into).await?;
        if self.0.line_coding().data_rate() == CALL {
            watchdog::to_boot_loader();
        }
        Ok(count)
    }
}

/// The parts of the link.
pub struct Link {
    /// Has to run for the others to work.
    pub device: UsbDevice<'static, Otg>,
    /// To the host.
    pub outgoing: Outgoing,
    /// From the host.
    pub incoming: Incoming,
}

/// Connects to the bus.
pub fn start(
    peripheral: Peri<'static, peripherals::USB_OTG_FS>,
    interrupts: impl Binding<OTG_FS, usb::InterruptHandler<peripherals::USB_OTG_FS>> + 'static,
    dp: Peri<'static, peripherals::PA12>,
    dm: Peri<'static, peripherals::PA11>,
) -> Link {
    static ENDPOINTS: ConstStaticCell<[u8; 256]> = ConstStaticCell::new([0; 256]);
    static CONFIGURATION: ConstStaticCell<[u8; 128]> = ConstStaticCell::new([0; 128]);
    static BOS: ConstStaticCell<[u8; 32]> = ConstStaticCell::new([0; 32]);
    static CONTROL: ConstStaticCell<[u8; PACKET]> = ConstStaticCell::new([0; PACKET]);
    static RECEIVED: ConstStaticCell<[u8; PACKET]> = ConstStaticCell::new([0; PACKET]);
    static STATE: StaticCell<State> = StaticCell::new();

    let mut port = usb::Config::default();
    // The board does not connect USB's supply to the pin that would sense it (PA9 is Arduino's pin 13).
    port.vbus_detection = false;
    let driver = Driver::new_fs(peripheral, interrupts, dp, dm, ENDPOINTS.take(), port);

    // pid.codes keeps this pair for tests and private use.
    let mut config = embassy_usb::Config::new(0x1209, 0x0001);
    config.manufacturer = Some("fre");
    config.product = Some("FRE gripper");
    config.serial_number = Some(embassy_stm32::uid::uid_hex());
    config.max_packet_size_0 = PACKET as u8;
    let mut builder = Builder::new(driver, config, CONFIGURATION.take(), BOS.take(), &mut [], CONTROL.take());
    let (outgoing, incoming) = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET as u16).split();
    Link { device: builder.build(), outgoing, incoming: Incoming(incoming.into_buffered(RECEIVED.take())) }
}

/// Serves the bus for ever.
#[embassy_executor::task]
pub async fn run(mut device: UsbDevice<'static, Otg>) -> ! {
    device.run().await
}
