//! `--web`: the live page.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::stop::Stop;
#[cfg(feature = "web")]
use crate::output::put_out;
use fre_gripper::source::Source;

#[cfg(not(feature = "web"))]
pub fn serve(_: &Arc<dyn Source>, _: SocketAddr, _: bool, _: Option<Duration>, _: &AtomicBool) -> Result<(), Stop> {
    let build = "cargo run --release -p fre-cli --features web --bin fre -- monitor --web …";
    Err(Stop::Input(format!("this program was built without `web`; build it with: {build}")))
}

#[cfg(feature = "web")]
pub fn serve(
    source: &Arc<dyn Source>,
    listen: SocketAddr,
    open: bool,
    length: Option<Duration>,
    stop: &AtomicBool,
) -> Result<(), Stop> {
    use fre_gripper::web;

    let ready = |url: &str| {
        let mut text = format!("{url}\n");
        if !listen.ip().is_loopback() {
            text += "others can reach this address: whoever has the token in it can move the gripper\n";
        }
        if open && !web::open_browser(url) {
            text += "there is no screen here for a browser\n";
        }
        // Whoever does not read the address can still open the page.
        let _ = put_out(&text);
    };
    web::serve(source.clone(), listen, None, length, stop, ready).map_err(|error| Stop::Input(error.to_string()))
}
