//! The serial ports of this machine.

use serialport::SerialPortType;

/// Their names, each with what is plugged in there if that says so. What the system does not list is not found.
pub fn ports() -> Vec<String> {
    let found = serialport::available_ports().unwrap_or_default();
    let words = found.into_iter().map(|port| match port.port_type {
        SerialPortType::UsbPort(usb) => match usb.product {
            Some(product) => format!("{} ({product})", port.port_name),
            None => port.port_name,
        },
        _ => port.port_name,
    });
    let mut words: Vec<String> = words.collect();
    words.sort();
    words
}
