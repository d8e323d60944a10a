//! Where a page is served.

use std::net::{IpAddr, SocketAddr};

/// The port of a page whose address has none.
const PORT: u16 = 7878;

/// The address of a page: ADDRESS or ADDRESS:PORT.
pub fn page_address(words: &str) -> Result<SocketAddr, String> {
    let alone = || words.parse().map(|address: IpAddr| SocketAddr::new(address, PORT));
    words.parse().or_else(|_| alone()).map_err(|_| "allowed are addresses as 0.0.0.0 and 0.0.0.0:7878".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_need_not_be_named() {
        for (words, is) in
            [("0.0.0.0", "0.0.0.0:7878"), ("0.0.0.0:80", "0.0.0.0:80"), ("::1", "[::1]:7878"), ("[::1]:80", "[::1]:80")]
        {
            assert_eq!(page_address(words).map(|address| address.to_string()).as_deref(), Ok(is));
        }
        for words in ["", "7878", "phone", "0.0.0.0:", "0.0.0.0:70000"] {
            assert!(page_address(words).is_err(), "{words}");
        }
    }
}
