//! The server: the page, its events, its commands.

use std::convert::Infallible;
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::broadcast::{Sender, channel};

use super::access::Access;
use super::command::{Answer, Command};
use super::lead::Lead;
use super::live::Live;
use super::page::page;
use super::setup::Setup;
use crate::source::{self, OrderError, Source, Told, alive};

/// Frames that a slow page may fall behind before it misses some: a second.
const BEHIND: usize = 30;
/// How often the target's counters are asked for.
const COUNTERS: Duration = Duration::from_secs(1);
/// The longest command, bytes.
const LONGEST: usize = 16 * 1024;
/// How often is looked whether to stop.
const GLANCE: Duration = Duration::from_millis(50);

/// What a browser may load: this page alone.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; \
    img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Why there is no live page.
#[derive(Debug, thiserror::Error)]
pub enum WebError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's words.
        source: std::io::Error,
    },
    /// The system gives no threads or random numbers.
    #[error("the live page cannot be served: {0}")]
    System(#[from] std::io::Error),
    /// The source does not answer.
    #[error(transparent)]
    Source(Box<OrderError>),
}

impl From<OrderError> for WebError {
    fn from(error: OrderError) -> Self {
        Self::Source(Box::new(error))
    }
}

/// What pages share.
struct Shared {
    source: Arc<dyn Source>,
    access: Access,
    lead: Option<Arc<Lead>>,
    events: Sender<Arc<Message>>,
    setup: Mutex<Arc<Message>>,
}

/// An event with its name.
struct Message {
    name: &'static str,
    data: String,
}

impl Message {
    fn of(name: &'static str, data: &impl serde::Serialize) -> Arc<Self> {
        // Plain numbers and words always have a JSON form; a number that is none becomes null.
        Arc::new(Self { name, data: serde_json::to_string(data).unwrap_or_default() })
    }

    fn event(&self) -> Event {
        Event::default().event(self.name).data(&self.data)
    }
}

impl Shared {
    /// Sends the pages what the source has.
    fn set_up(&self, told: &source::Setup) {
        let message = Message::of("setup", &Setup::of(told, self.lead.is_some()));
        *self.setup.lock().unwrap_or_else(PoisonError::into_inner) = message.clone();
        // Without a page nobody listens.
        let _ = self.events.send(message);
    }
}

/// Serves the live page until the time is over, `stop` is set or the source has ended; `ready` gets the page's address.
///
/// # Errors
/// The address is taken, or the source does not answer at the beginning.
pub fn serve(
    source: Arc<dyn Source>,
    address: SocketAddr,
    lead: Option<Arc<Lead>>,
    length: Option<Duration>,
    stop: &AtomicBool,
    ready: impl FnOnce(&str),
) -> Result<(), WebError> {
    let listener = TcpListener::bind(address).map_err(|source| WebError::Listen { address, source })?;
    listener.set_nonblocking(true)?;
    let own = listener.local_addr()?;
    let access = Access::of(own)?;
    let told = source.hear(source::WAITING);
    let setup = source.setup()?;
    let (events, _) = channel(BEHIND);
    let live = Mutex::new(Live::new(&setup));
    let first = Mutex::new(Message::of("setup", &()));
    let shared = Arc::new(Shared { source, access, lead, events, setup: first });
    shared.set_up(&setup);
    ready(&format!("http://{}/{}", reached(own), shared.access.fragment()));

    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let over = AtomicBool::new(false);
    let start = Instant::now();
    let source = shared.source.clone();
    std::thread::scope(|scope| {
        let (pumped, counting) = (shared.clone(), shared.clone());
        let (live, ended) = (&live, &over);
        scope.spawn(move || pump(&pumped, &told, live, ended));
        scope.spawn(move || count(&counting, live, ended));
        let served = alive(&*source, || {
            runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(listener)?;
                let app = router(shared);
                tokio::select! {
                    served = async { axum::serve(listener, app).await } => served,
                    () = until(|| {
                        let late = length.is_some_and(|length| start.elapsed() >= length);
                        late || stop.load(Ordering::Relaxed) || ended.load(Ordering::Relaxed)
                    }) => Ok(()),
                }
            })
        });
        over.store(true, Ordering::Relaxed);
        served
    })?;
    // Pages that are still connected do not hold the program.
    runtime.shutdown_background();
    Ok(())
}

/// By which address this server is reached: one that listens on every address of this PC, by that of its way out.
fn reached(own: SocketAddr) -> String {
    if !own.ip().is_unspecified() {
        return own.to_string();
    }
    // A documentation's address that nobody has: nothing is sent, the system only chooses its way there.
    let way = if own.is_ipv6() { ("[::]:0", "[2001:db8::1]:9") } else { ("0.0.0.0:0", "192.0.2.1:9") };
    let found = UdpSocket::bind(way.0).and_then(|socket| socket.connect(way.1).and_then(|()| socket.local_addr()));
    match found {
        Ok(found) if !found.ip().is_unspecified() => SocketAddr::new(found.ip(), own.port()).to_string(),
        // Without a network.
        _ => format!("localhost:{}", own.port()),
    }
}

async fn until(done: impl Fn() -> bool) {
    while !done() {
        tokio::time::sleep(GLANCE).await;
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/events", get(events))
        .route("/command", post(command))
        .layer(middleware::from_fn_with_state(shared.clone(), guard))
        .route("/", get(|| async { Html(page()) }))
        .layer(middleware::map_response(secured))
        .with_state(shared)
}

/// Only who may gets further.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let allowed = {
        let text = |name| request.headers().get(name).and_then(|value: &header::HeaderValue| value.to_str().ok());
        let query = request.uri().query().unwrap_or_default().split('&').find_map(|pair| pair.strip_prefix("token="));
        shared.access.allows(text("host"), text("origin"), text("x-token").or(query))
    };
    if !allowed {
        let words = "not allowed: open the page with the address that `fre` printed, token included";
        return (StatusCode::FORBIDDEN, axum::Json(Answer::refused(words))).into_response();
    }
    next.run(request).await
}

async fn secured(mut response: Response) -> Response {
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, header::HeaderValue::from_static(value));
    }
    response
}

async fn events(State(shared): State<Arc<Shared>>) -> impl IntoResponse {
    let listener = shared.events.subscribe();
    let first = shared.setup.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let stream = futures_util::stream::unfold((Some(first), listener), |(first, mut listener)| async move {
        if let Some(first) = first {
            return Some((Ok::<_, Infallible>(first.event()), (None, listener)));
        }
        loop {
            match listener.recv().await {
                Ok(message) => return Some((Ok(message.event()), (None, listener))),
                // A page that does not keep up misses frames; it is shown the present.
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => return None,
            }
        }
    });
    Sse::new(stream).keep_alive(KeepAlive::default())
}

async fn command(State(shared): State<Arc<Shared>>, headers: HeaderMap, body: Bytes) -> Response {
    // A form of another site cannot send this type without asking first, and is never answered.
    let is_json =
        headers.get(header::CONTENT_TYPE).is_some_and(|kind| kind.as_bytes().starts_with(b"application/json"));
    if !is_json {
        return (StatusCode::UNSUPPORTED_MEDIA_TYPE, axum::Json(Answer::refused("a command is JSON"))).into_response();
    }
    if body.len() > LONGEST {
        let words = format!("a command has {LONGEST} bytes at most");
        return (StatusCode::PAYLOAD_TOO_LARGE, axum::Json(Answer::refused(words))).into_response();
    }
    let command: Command = match serde_json::from_slice(&body) {
        Ok(command) => command,
        Err(error) => {
            let words = error.to_string();
            let words = words.split(" at line").next().unwrap_or_default();
            return (StatusCode::BAD_REQUEST, axum::Json(Answer::refused(words))).into_response();
        }
    };
    // On a thread of its own: a stop never waits behind another command.
    let asked = tokio::task::spawn_blocking(move || command.ask(&*shared.source, shared.lead.as_deref()));
    let answer = asked.await.unwrap_or_else(Answer::refused);
    let status = if answer.ok { StatusCode::OK } else { StatusCode::CONFLICT };
    (status, axum::Json(answer)).into_response()
}

/// Hears the source and makes frames.
fn pump(shared: &Shared, told: &Receiver<Told>, live: &Mutex<Live>, over: &AtomicBool) {
    let paused = || shared.lead.as_ref().is_some_and(|lead| lead.is_pausing());
    let live = || live.lock().unwrap_or_else(PoisonError::into_inner);
    while !over.load(Ordering::Relaxed) {
        let due = live().due_in();
        match told.recv_timeout(due) {
            Ok(told) => {
                if let Told::Setup(setup) = &told {
                    shared.set_up(setup);
                }
                if let Told::Event(notice) = &told {
                    let words = notice.event.to_string();
                    let data = serde_json::json!({ "time_s": notice.time_us as f64 * 1e-6, "words": words, "bad": is_bad(&notice.event) });
                    let _ = shared.events.send(Message::of("notice", &data));
                }
                live().take(told);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                let frame = live().frame(&shared.source.statistics(), true, false);
                let _ = shared.events.send(Message::of("frame", &frame));
                // The page gets to know before the server is gone.
                std::thread::sleep(10 * GLANCE);
                over.store(true, Ordering::Relaxed);
                return;
            }
        }
        let mut live = live();
        if live.due_in() == Duration::ZERO {
            let frame = live.frame(&shared.source.statistics(), false, paused());
            drop(live);
            let _ = shared.events.send(Message::of("frame", &frame));
        }
    }
}

fn is_bad(event: &messages::Event) -> bool {
    use messages::{Event, Why};
    match event {
        Event::ServoLost { .. } | Event::GoalRefused { .. } | Event::OtherMaster { .. } => true,
        Event::ServoAlert { hardware_error, .. } => *hardware_error != 0,
        Event::Derated { derating, .. } => *derating > messages::Derating::Warned,
        Event::RateReached { hz, chosen_hz } => *hz < 0.95 * chosen_hz,
        Event::PhaseChanged { phase, .. } => phase.why().is_some_and(|why| why != Why::Asked),
        _ => false,
    }
}

/// Asks for the source's counters now and then.
fn count(shared: &Shared, live: &Mutex<Live>, over: &AtomicBool) {
    let mut asked: Option<Instant> = None;
    while !over.load(Ordering::Relaxed) {
        if asked.is_none_or(|asked| asked.elapsed() >= COUNTERS) {
            asked = Some(Instant::now());
            if let Ok(Some(counters)) = shared.source.counters() {
                live.lock().unwrap_or_else(PoisonError::into_inner).count(counters);
            }
        }
        std::thread::sleep(GLANCE);
    }
}

/// Opens a browser where there is a screen; false if there is none.
pub fn open_browser(url: &str) -> bool {
    let screen = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    let mut opener = std::process::Command::new("xdg-open");
    let quiet = std::process::Stdio::null;
    screen && opener.arg(url).stdin(quiet()).stdout(quiet()).stderr(quiet()).spawn().is_ok()
}
