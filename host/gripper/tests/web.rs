//! Who may lead the gripper through the live page's server, and what it answers to nonsense.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use fre::case::preset;
use fre_gripper::source::Statistics;
use fre_gripper::source::{Listeners, Modelled, Order, OrderError, Origin, Setup, Source, Told};
use fre_gripper::web;
use messages::{Counters, Finger, Object, Phase, Report, Settings, Which};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::estimator::Estimate;
use model_core::object::ObjectDesign;
use model_core::status::Status;
use snapbox::IntoData as _;

/// A gripper that only notes what it is asked for.
#[derive(Default)]
struct Note {
    listeners: Listeners,
    orders: Mutex<Vec<Order>>,
}

impl Source for Note {
    fn setup(&self) -> Result<Setup, OrderError> {
        let design = preset("ladder-80").unwrap().unwrap().design;
        let finger = Finger::elastic(design, Discretisation::estimator(Physics::Paper));
        let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
        Ok(Setup {
            origin: Origin::Gripper,
            place: "here".to_owned(),
            board: "paper".to_owned(),
            firmware: "0".to_owned(),
            protocol: messages::PROTOCOL_VERSION,
            cost_hz: 1_000_000,
            settings: Settings::DEFAULT,
            models: vec![Modelled { finger: Some(finger), object: Some(object), friction: 0.0, uncertainty: None }],
        })
    }

    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.listeners.add(waiting)
    }

    fn statistics(&self) -> Statistics {
        Statistics { missing_reports: 7, ..Statistics::default() }
    }

    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Ok(None)
    }

    fn order(&self, order: &Order) -> Result<(), OrderError> {
        self.orders.lock().unwrap().push(order.clone());
        Ok(())
    }

    fn is_closed(&self) -> bool {
        false
    }
}

/// A server on an address; what is asked of it goes to its port on this PC.
struct Served {
    note: Arc<Note>,
    url: String,
    port: u16,
    stop: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Served {
    fn on(address: &str) -> Self {
        let (note, stop) = (Arc::new(Note::default()), Arc::new(AtomicBool::new(false)));
        let (tell, told) = channel();
        let address: SocketAddr = address.parse().unwrap();
        let (source, stopped) = (note.clone(), stop.clone());
        let thread = std::thread::spawn(move || {
            web::serve(source, address, None, None, &stopped, |url| tell.send(url.to_owned()).unwrap()).unwrap();
        });
        let url = told.recv_timeout(Duration::from_secs(30)).expect("an address");
        let port = url.split("://").nth(1).and_then(|rest| rest.split(['/', '#']).next()).unwrap();
        let port = port.rsplit(':').next().unwrap().parse().unwrap();
        Self { note, url, port, stop, thread: Some(thread) }
    }

    fn ask(&self, head: &str, body: &str) -> TcpStream {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        let length = body.len();
        write!(stream, "{head}\r\nConnection: close\r\nContent-Length: {length}\r\n\r\n{body}").unwrap();
        stream
    }

    /// Status and the whole answer.
    fn answer(&self, head: &str, body: &str) -> (u16, String) {
        let mut text = String::new();
        self.ask(head, body).read_to_string(&mut text).unwrap();
        (status(&text), text)
    }

    /// A command with further header lines.
    fn command(&self, headers: &str, body: &str) -> (u16, String) {
        let head = format!("POST /command HTTP/1.1\r\nContent-Type: application/json\r\n{headers}");
        self.answer(&head, body)
    }

    /// The stream of events up to a text; the text must come.
    fn events(&self, head: &str, until: &str) -> String {
        let mut stream = self.ask(head, "");
        let (mut seen, mut chunk) = (Vec::new(), [0; 4096]);
        loop {
            let count = stream.read(&mut chunk).expect("events");
            seen.extend_from_slice(&chunk[..count]);
            let text = String::from_utf8_lossy(&seen).into_owned();
            if text.contains(until) || count == 0 {
                assert!(text.contains(until), "{text}");
                return text;
            }
        }
    }

    fn orders(&self) -> Vec<Order> {
        self.note.orders.lock().unwrap().clone()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(std::thread::JoinHandle::join);
        if !std::thread::panicking() {
            ended.unwrap().unwrap();
        }
    }
}

fn status(answer: &str) -> u16 {
    answer.split(' ').nth(1).and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("no HTTP: {answer}"))
}

const STOP: &str = r#""stop""#;

#[test]
fn on_this_pc_its_own_page_commands_and_no_other_site_does() {
    let served = Served::on("127.0.0.1:0");
    let (port, host) = (served.port, format!("Host: 127.0.0.1:{}", served.port));
    assert_eq!(served.url, format!("http://127.0.0.1:{port}/"));
    // Another site's page in the same browser, by its origin; and by a name of its own that leads here.
    for headers in [
        format!("{host}\r\nOrigin: http://evil.example"),
        format!("{host}\r\nOrigin: null"),
        format!("{host}\r\nOrigin: http://127.0.0.1:1"),
        format!("Host: evil.example:{port}\r\nOrigin: http://evil.example:{port}"),
        "Host: evil.example".to_owned(),
    ] {
        let (status, text) = served.command(&headers, STOP);
        assert_eq!(status, 403, "{headers}: {text}");
        let (status, _) = served.answer(&format!("GET /events HTTP/1.1\r\n{headers}"), "");
        assert_eq!(status, 403, "{headers}");
    }
    // What a form can send without asking first.
    let form = format!("POST /command HTTP/1.1\r\n{host}\r\nContent-Type: text/plain");
    assert_eq!(served.answer(&form, STOP).0, 415);
    assert_eq!(served.orders(), []);
    // Nor does the server tell a browser that other sites may.
    let ask = format!(
        "OPTIONS /command HTTP/1.1\r\n{host}\r\nOrigin: http://evil.example\r\nAccess-Control-Request-Method: POST"
    );
    assert!(!served.answer(&ask, "").1.to_lowercase().contains("access-control-allow"));

    let (status, text) = served.command(&format!("{host}\r\nOrigin: http://127.0.0.1:{port}"), STOP);
    assert_eq!(status, 200, "{text}");
    assert!(text.contains("stopped"), "{text}");
    assert_eq!(served.orders(), [Order::Hold(Which::All)]);
}

#[test]
fn where_others_can_reach_it_the_token_counts() {
    let served = Served::on("0.0.0.0:0");
    let token = served.url.split("#token=").nth(1).expect("a token").to_owned();
    assert!(token.len() == 32 && token.bytes().all(|byte| byte.is_ascii_hexdigit()), "{token}");
    let host = format!("Host: 127.0.0.1:{}", served.port);
    let wrong = "0".repeat(32);
    for headers in [host.clone(), format!("{host}\r\nX-Token: {wrong}"), format!("{host}\r\nX-Token:")] {
        let (status, text) = served.command(&headers, STOP);
        assert_eq!(status, 403, "{text}");
        assert!(!text.contains(&token));
    }
    let other = format!("{host}\r\nX-Token: {token}\r\nOrigin: http://evil.example");
    assert_eq!(served.command(&other, STOP).0, 403);
    for place in ["/events".to_owned(), format!("/events?token={wrong}")] {
        assert_eq!(served.answer(&format!("GET {place} HTTP/1.1\r\n{host}"), "").0, 403, "{place}");
    }
    assert_eq!(served.orders(), []);
    // A phone can open it: not by a name of this PC's own, if it has a network.
    let place = served.url.split("://").nth(1).and_then(|rest| rest.split('/').next()).expect("a place");
    assert!(
        !place.starts_with("0.0.0.0")
            && (place.starts_with("localhost:") || place.parse::<std::net::SocketAddr>().is_ok()),
        "{place}"
    );
    // The page itself is no secret, and knows none.
    let (status, page) = served.answer(&format!("GET / HTTP/1.1\r\n{host}"), "");
    assert!(status == 200 && !page.contains(&token));

    assert_eq!(served.command(&format!("{host}\r\nX-Token: {token}"), STOP).0, 200);
    assert_eq!(served.orders(), [Order::Hold(Which::All)]);
    served.events(&format!("GET /events?token={token} HTTP/1.1\r\n{host}"), "event: setup");
}

#[test]
fn commands_become_orders_and_nonsense_is_named() {
    let served = Served::on("127.0.0.1:0");
    let host = format!("Host: localhost:{}", served.port);
    let mut said = String::new();
    for body in [
        r#""dance""#,
        r#"{"grip":{}}"#,
        r#"{"grip":{"force_n":"much"}}"#,
        r#"{"object":{"finger":0,"object":{"shape":"circle","centre_mm":[1,2.5],"radius_mm":-3}}}"#,
        r#"{"object":{"finger":0,"object":{"star":{}}}}"#,
        "{",
    ] {
        let (status, text) = served.command(&host, body);
        let answer = text.split_once("\r\n\r\n").map_or(text.as_str(), |(_, answer)| answer);
        said += &format!("{status} {answer}\n");
    }
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
400 {"ok":false,"words":"unknown variant `dance`, expected one of `stop`, `grip`, `release`, `relax`, `close`, `object`, `limits`, `resume`"}
400 {"ok":false,"words":"missing field `force_n`"}
400 {"ok":false,"words":"invalid type: string \"much\", expected f32"}
409 {"ok":false,"words":"radius_mm = -3.0: allowed is 0.1 to 1000 mm"}
409 {"ok":false,"words":"star = {}: is neither a number, nor a word, nor a list"}
400 {"ok":false,"words":"EOF while parsing an object"}

"#]]
        .raw()
    );
    let long = format!(r#"{{"stop":"{}"}}"#, "x".repeat(20_000));
    assert_eq!(served.command(&host, &long).0, 413);
    assert_eq!(served.orders(), []);
    for (body, order) in [
        (r#"{"release":{"finger":1}}"#, Order::Open(Which::One(1))),
        (
            r#"{"object":{"finger":0,"object":{"shape":"circle","centre_mm":[34,45.5],"radius_mm":30}}}"#,
            Order::Object(0, ObjectDesign::Circle { centre: [34.0, 45.5], radius: 30.0 }.into()),
        ),
        (
            r#"{"object":{"finger":0,"object":{"shape":"circle","centre_mm":[34,45.5],"radius_mm":30,"friction":0.6}}}"#,
            Order::Object(
                0,
                Object { design: ObjectDesign::Circle { centre: [34.0, 45.5], radius: 30.0 }, friction: 0.6 },
            ),
        ),
    ] {
        let (status, text) = served.command(&host, body);
        assert_eq!(status, 200, "{text}");
        assert_eq!(served.orders().last(), Some(&order));
    }
    let limits = r#"{"force_limit_n":9.5,"current_limit_ma":700,"speed_deg_s":20,"low_deg":-5,"high_deg":12,"open_deg":-2,"rate_hz":250,"on_fault":"release","drive":"linear 1,0 12.5"}"#;
    let (status, text) = served.command(&host, &format!(r#"{{"limits":{{"finger":0,"limits":{limits}}}}}"#));
    assert_eq!(status, 200, "{text}");
    let orders = served.orders();
    let Some(Order::Settings(settings)) = orders.last() else { panic!("{orders:?}") };
    assert_eq!((settings.rate_hz, settings.on_fault), (250, messages::Reaction::Release));
    assert_eq!(settings.fingers[0].unwrap().force_limit, 9.5);
    assert_eq!(settings.fingers[0].unwrap().drive, Drive::linear([1.0, 0.0], 12.5));
    assert!((settings.fingers[0].unwrap().range[1] - 12.0_f32.to_radians()).abs() < 1e-6);
    let sideways = limits.replace("linear 1,0 12.5", "sideways");
    let (status, text) = served.command(&host, &format!(r#"{{"limits":{{"finger":0,"limits":{sideways}}}}}"#));
    assert!(status == 409 && text.contains("`sideways` is not rotating, linear X,Y MM_PER_RAD"), "{status} {text}");
}

#[test]
fn the_page_is_one_document_and_gets_what_the_source_tells() {
    let served = Served::on("127.0.0.1:0");
    let host = format!("Host: 127.0.0.1:{}", served.port);
    let (status, page) = served.answer(&format!("GET / HTTP/1.1\r\n{host}"), "");
    assert_eq!(status, 200);
    assert!(page.contains("content-security-policy: default-src 'none'"), "{}", &page[..600]);
    for outside in ["src=", "@import", "url(", "https://", "http://", "/*STYLE*/", "/*SCRIPT*/"] {
        assert!(!page.contains(outside), "the page has {outside}");
    }
    let note = served.note.clone();
    let estimate = Estimate {
        force: [3.0, 4.0],
        standard_deviation: f32::INFINITY,
        motor_angle: 0.1,
        ..Estimate::blank(Status::Converged)
    };
    let report = Report {
        sequence: 41,
        finger: 0,
        phase: Phase::Gripped,
        time_us: 2_000_000,
        estimate,
        goal: 0.1,
        position: 2100,
        current: 12.0,
        cost: 150,
    };
    let over = Arc::new(AtomicBool::new(false));
    let telling = std::thread::spawn({
        let over = over.clone();
        move || {
            while !over.load(Ordering::Relaxed) {
                note.listeners.tell(&Told::Report(report));
                std::thread::sleep(Duration::from_millis(2));
            }
        }
    });
    let text = served.events(&format!("GET /events HTTP/1.1\r\n{host}"), r#""sequence":41"#);
    let text = text + &served.events(&format!("GET /events HTTP/1.1\r\n{host}"), r#""force_n":5.0"#);
    over.store(true, Ordering::Relaxed);
    telling.join().unwrap();
    for words in ["event: setup", "event: frame", r#""deviation_n":null"#, r#"["missing reports","7"]"#] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(text.contains(r#""radius_mm":40.0"#) && text.contains(r#""cost":"150 µs, 0 it.""#), "{text}");
}
