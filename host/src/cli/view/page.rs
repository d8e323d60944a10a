//! `--web`: the live page.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::Stop;
use crate::source::Source;

#[cfg(not(feature = "web"))]
pub fn serve(_: &Arc<dyn Source>, _: SocketAddr, _: bool, _: Option<Duration>, _: &AtomicBool) -> Result<(), Stop> {
    let build = "cargo run --release -p host --features web --bin fre -- monitor --web …";
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
    use crate::web;

    let ready = |url: &str| {
        println!("{url}");
        if !listen.ip().is_loopback() {
            println!("others can reach this address: whoever has the token in it can move the gripper");
        }
        if open && !web::open_browser(url) {
            println!("there is no screen here for a browser");
        }
    };
    web::serve(source.clone(), listen, None, length, stop, ready).map_err(|error| Stop::Input(error.to_string()))
}
