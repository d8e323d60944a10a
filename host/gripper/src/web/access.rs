//! Who may ask: on this PC alone whoever is on it, from elsewhere who knows the token.

use std::net::SocketAddr;

use subtle::ConstantTimeEq as _;

/// The rule for one server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// Needed for everything but the page itself; none on the loopback.
    token: Option<String>,
}

impl Access {
    /// For an address to listen on: a new token if others than this PC can reach it.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn of(address: SocketAddr) -> std::io::Result<Self> {
        if address.ip().is_loopback() {
            return Ok(Self { token: None });
        }
        let mut random = [0; 16];
        getrandom::fill(&mut random)?;
        Ok(Self { token: Some(random.iter().map(|byte| format!("{byte:02x}")).collect()) })
    }

    /// What is behind the page's address, so that the page knows the token: after #, which browsers keep to themselves.
    pub fn fragment(&self) -> String {
        self.token.as_ref().map(|token| format!("#token={token}")).unwrap_or_default()
    }

    /// Whether a request may pass, by its Host and Origin headers and its token.
    pub fn allows(&self, host: Option<&str>, origin: Option<&str>, token: Option<&str>) -> bool {
        // A page of another site says so; this server's own page, and programs, have its own origin or none.
        let own = |origin: &str| origin.split_once("://").is_some_and(|(_, place)| Some(place) == host);
        if !origin.is_none_or(own) {
            return false;
        }
        match &self.token {
            // Another site's name that leads to this PC (DNS rebinding) is not this PC's own.
            None => host.is_some_and(is_own_name),
            // Takes as long wherever the first difference is.
            Some(own) => token.is_some_and(|token| own.as_bytes().ct_eq(token.as_bytes()).into()),
        }
    }
}

fn is_own_name(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let address = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost") || address.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_the_loopback_only_its_own_names_pass() {
        let access = Access::of("127.0.0.1:7878".parse().unwrap()).unwrap();
        assert_eq!(access.fragment(), "");
        for host in ["127.0.0.1:7878", "localhost:7878", "[::1]:80", "LOCALHOST"] {
            assert!(access.allows(Some(host), None, None), "{host}");
            assert!(access.allows(Some(host), Some(&format!("http://{host}")), None), "{host}");
        }
        for host in ["evil.example:7878", "192.168.0.7:7878", "localhost.evil.example", ""] {
            assert!(!access.allows(Some(host), None, None), "{host}");
        }
        assert!(!access.allows(None, None, None));
        for origin in ["http://evil.example", "http://127.0.0.1:80", "null", "http://127.0.0.1:7878.evil.example", ""] {
            assert!(!access.allows(Some("127.0.0.1:7878"), Some(origin), None), "{origin}");
        }
    }

    #[test]
    fn elsewhere_the_token_counts_and_is_new_every_time() {
        let (one, two) =
            (Access::of("0.0.0.0:1".parse().unwrap()).unwrap(), Access::of("[::]:1".parse().unwrap()).unwrap());
        assert_ne!(one, two);
        let token = one.fragment();
        let token = token.strip_prefix("#token=").unwrap();
        assert_eq!(token.len(), 32);
        assert!(one.allows(Some("gripper.example"), None, Some(token)));
        assert!(!two.allows(Some("localhost"), None, Some(token)));
        assert!(
            !one.allows(Some("localhost"), None, None)
                && !one.allows(None, None, Some(""))
                && !one.allows(None, None, Some(&token[1..]))
                && !one.allows(Some("gripper.example"), Some("http://evil.example"), Some(token))
        );
    }
}
