//! Writing to a port, without the panic of embedded-io's own `write_all` for a port that takes nothing.

use embedded_io_async::Write;

/// Writes all bytes; false if the port fails, or takes nothing.
pub(crate) async fn write_all(port: &mut impl Write, bytes: &[u8]) -> bool {
    let mut rest = bytes;
    while !rest.is_empty() {
        match port.write(rest).await {
            Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
            Ok(0) | Err(_) => return false,
        }
    }
    true
}
