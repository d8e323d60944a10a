//! The bus of the simulated servo: pseudo-terminal, sockets, several parties, and how fast it answers.

#[path = "../../gripper/tests/servo_case/mod.rs"]
mod servo_case;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::net::UnixStream;
use std::process::Command;
use std::time::{Duration, Instant};

use dynamixel::{Decoder, Id, Instruction, encode, xm430};
use fre_gripper::servo::{Clock, Config, Fault, Gains, Hub, PortError, Servo};
use servo_case::load;

/// How long an answer may take, on a machine that does a lot else.
const PATIENCE: Duration = Duration::from_secs(5);
/// After how long there is none.
const SILENCE: Duration = Duration::from_millis(300);

fn question(instruction: Instruction, parameters: &[u8]) -> Vec<u8> {
    let mut buffer = [0; 64];
    encode(&mut buffer, Id::new(1).unwrap(), instruction, parameters).unwrap().to_vec()
}

/// The question of the control task: current, velocity and position.
fn read_present() -> Vec<u8> {
    question(Instruction::Read, &[126, 0, 10, 0])
}

/// The parameters of the next status packet; none if it does not come.
fn answer(port: &mut (impl Read + ?Sized)) -> Option<Vec<u8>> {
    let mut decoder = Decoder::<256>::new();
    let mut byte = [0];
    loop {
        port.read_exact(&mut byte).ok()?;
        let Some(packet) = decoder.feed(&mut byte.as_slice()) else { continue };
        if let Some(status) = packet.ok()?.status() {
            return Some(status.parameters.to_vec());
        }
    }
}

fn patient(stream: UnixStream) -> UnixStream {
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream
}

#[test]
fn everyone_hears_everyone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hub");
    let mut hub = Hub::new();
    hub.servo(Servo::new(Config { return_delay_us: 0, ..Config::default() }).unwrap());
    hub.listen_unix(&path).unwrap();
    let address = hub.listen_tcp("127.0.0.1:0").unwrap();
    let mut inside = patient(hub.stream().unwrap());
    let bus = hub.spawn().unwrap();
    let mut unix = patient(UnixStream::connect(&path).unwrap());
    let mut tcp = TcpStream::connect(address).unwrap();
    tcp.set_read_timeout(Some(PATIENCE)).unwrap();
    // Who has got an answer is known to the bus.
    let ping = question(Instruction::Ping, &[]);
    let identity = [0xFC, 0x03, 45];
    for port in [&mut unix as &mut dyn Stream, &mut tcp] {
        port.write_all(&ping).unwrap();
        assert_eq!(answer(port).unwrap(), identity);
    }
    for port in [&mut inside as &mut dyn Stream, &mut unix, &mut tcp] {
        port.wait_for(SILENCE);
        let _ = port.read_to_end(&mut Vec::new());
        port.wait_for(PATIENCE);
    }
    // What the one asks, the others hear, and the answer too; nobody hears itself.
    unix.write_all(&ping).unwrap();
    for listener in [&mut inside as &mut dyn Stream, &mut tcp] {
        let mut bytes = vec![0; ping.len()];
        listener.read_exact(&mut bytes).unwrap();
        assert_eq!(bytes, ping);
        assert_eq!(answer(listener).unwrap(), identity);
    }
    let mut bytes = vec![0; 14];
    unix.read_exact(&mut bytes).unwrap();
    assert_eq!(answer(&mut bytes.as_slice()).unwrap(), identity);
    bus.stop();
    assert!(!path.exists(), "the socket is taken away");
}

trait Stream: Read + Write {
    fn wait_for(&mut self, longest: Duration);
}

impl Stream for UnixStream {
    fn wait_for(&mut self, longest: Duration) {
        self.set_read_timeout(Some(longest)).unwrap();
    }
}

impl Stream for TcpStream {
    fn wait_for(&mut self, longest: Duration) {
        self.set_read_timeout(Some(longest)).unwrap();
    }
}

#[test]
fn a_party_that_does_not_listen_holds_nobody() {
    let mut hub = Hub::new();
    hub.servo(Servo::new(Config { return_delay_us: 0, ..Config::default() }).unwrap());
    let _terminal = hub.pty().unwrap();
    let _deaf = hub.stream().unwrap();
    let mut master = patient(hub.stream().unwrap());
    let bus = hub.spawn().unwrap();
    for _ in 0..20_000 {
        master.write_all(&read_present()).unwrap();
        assert_eq!(answer(&mut master).unwrap().len(), 10);
    }
    assert!(bus.lost() > 0, "what has no room is counted");
}

#[test]
fn it_answers_every_question_of_a_500_hz_reader_and_not_before_its_delay() {
    for return_delay_us in [0, 500] {
        let mut hub = Hub::new();
        let config = Config {
            return_delay_us,
            load: load([41.0, 45.0], 13.0),
            noise_ma: 3.0,
            backlash_deg: 0.25,
            // With the factory's, the load keeps it short of its goal.
            gains: Gains::GREATEST,
            ..Config::default()
        };
        let handle = hub.servo(Servo::new(config).unwrap());
        let mut master = patient(hub.stream().unwrap());
        let _bus = hub.spawn().unwrap();
        let write = |address: u16, value: i32| {
            let mut parameters = address.to_le_bytes().to_vec();
            parameters.extend(value.to_le_bytes());
            question(Instruction::Write, &parameters)
        };
        master.write_all(&question(Instruction::Write, &[64, 0, 1])).unwrap();
        answer(&mut master).unwrap();
        for (address, value) in [(112, 20), (116, 2170)] {
            master.write_all(&write(address, value)).unwrap();
            answer(&mut master).unwrap();
        }
        let mut times = Vec::new();
        let begin = Instant::now();
        for tick in 1..=1000 {
            let asked = Instant::now();
            master.write_all(&read_present()).unwrap();
            assert_eq!(answer(&mut master).unwrap().len(), 10);
            times.push(asked.elapsed().as_secs_f64() * 1e6);
            std::thread::sleep((begin + Duration::from_millis(2 * tick)).saturating_duration_since(Instant::now()));
        }
        times.sort_by(f64::total_cmp);
        let [median, late, latest] = [500, 990, 999].map(|at: usize| times[at]);
        println!("return delay {return_delay_us} µs: median {median:.0} µs, 99 % {late:.0} µs, latest {latest:.0} µs");
        assert!(median >= f64::from(return_delay_us));
        assert_eq!(handle.statistics().position_reads, 1000);
        assert!(handle.truth().torque > 1000.0, "the finger was in contact meanwhile");
    }
}

#[test]
fn the_time_of_the_wall_moves_it_without_questions() {
    let mut hub = Hub::new();
    let config = Config { return_delay_us: 0, gains: Gains::GREATEST, ..Config::default() };
    let handle = hub.servo(Servo::new(config).unwrap());
    let mut master = patient(hub.stream().unwrap());
    let _bus = hub.spawn().unwrap();
    for parameters in [&[64, 0, 1][..], &[112, 0, 100, 0, 0, 0], &[116, 0, 0x98, 0x08, 0, 0]] {
        master.write_all(&question(Instruction::Write, parameters)).unwrap();
        answer(&mut master).unwrap();
    }
    let begin = Instant::now();
    while handle.truth().count != 0x0898 {
        assert!(begin.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    // 152 counts at 1563 counts/s.
    assert!(begin.elapsed() > Duration::from_millis(80), "{:?}", begin.elapsed());
}

#[test]
fn a_handle_makes_it_fail() {
    let mut hub = Hub::new();
    let handle =
        hub.servo(Servo::new(Config { clock: Clock::Requests { period_us: 2000 }, ..Config::default() }).unwrap());
    let mut master = patient(hub.stream().unwrap());
    let _bus = hub.spawn().unwrap();
    let mut ask = |longest| {
        master.wait_for(longest);
        master.write_all(&read_present()).unwrap();
        answer(&mut master)
    };
    assert!(ask(PATIENCE).is_some());
    handle.inject([Fault::Drop, Fault::Corrupt { index: 10, mask: 1 }]);
    assert_eq!((ask(SILENCE), ask(SILENCE)), (None, None));
    assert!(ask(PATIENCE).is_some());
    handle.silence(Duration::MAX);
    assert_eq!(ask(SILENCE), None);
    handle.speak();
    assert!(ask(PATIENCE).is_some());
    let begin = Instant::now();
    handle.silence(2 * SILENCE);
    assert_eq!(ask(SILENCE), None);
    std::thread::sleep((2 * SILENCE).saturating_sub(begin.elapsed()) + Duration::from_millis(1));
    assert!(ask(PATIENCE).is_some());
    assert_eq!(handle.statistics().faults, 2);
    handle.with(|servo| servo.fail(1));
    handle.reset();
    assert!(ask(PATIENCE).is_some());
}

#[test]
fn a_path_that_is_no_socket_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    std::fs::write(&path, "mine").unwrap();
    let error = Hub::new().listen_unix(&path).unwrap_err();
    assert!(matches!(error, PortError::Unix { .. }));
    snapbox::assert_data_eq!(
        error.to_string().replace(path.to_str().unwrap(), "PATH"),
        snapbox::str!["the socket PATH cannot be listened on: Address already in use (os error 98)"]
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    std::fs::remove_file(&path).unwrap();
    // A socket that a killed program left behind is replaced; one in use is not.
    drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
    let mut hub = Hub::new();
    hub.listen_unix(&path).unwrap();
    assert!(Hub::new().listen_unix(&path).is_err());
    assert!(UnixStream::connect(&path).is_ok());
}

/// Runs the command; gives it once it is ready, and where its bus is.
fn fre(arguments: &[&str]) -> (std::process::Child, Vec<String>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_fre"))
        .arg("servo")
        .args(arguments)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let out = std::io::BufReader::new(child.stdout.take().unwrap());
    let lines = std::io::BufRead::lines(out).map(Result::unwrap).take_while(|line| line != "ready").collect();
    (child, lines)
}

#[test]
fn the_command_serves_until_it_is_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let case = folder.path().join("case.toml");
    let text = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
                [motion]\nmotor_angles_deg = [2]\n";
    std::fs::write(&case, text).unwrap();
    let path = folder.path().join("bus");
    let unix = path.to_str().unwrap();
    let (child, places) = fre(&[
        case.to_str().unwrap(),
        "--unix",
        unix,
        "--pty",
        "--highest-deg",
        "3",
        "--elements",
        "reduced",
        "--scheme",
        "simpson",
        "--clock",
        "requests",
        "--id",
        "1",
        "--baud",
        "1000000",
        "--backlash-deg",
        "0.25",
        "--seed",
        "3",
    ]);
    assert!(places[0].starts_with("pty /dev/"), "{places:?}");
    assert_eq!(places[1], format!("unix {unix}"));
    let mut master = patient(UnixStream::connect(&path).unwrap());
    master.write_all(&read_present()).unwrap();
    assert_eq!(answer(&mut master).unwrap()[6..], 2026i32.to_le_bytes());
    let stop = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(stop.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let last = String::from_utf8_lossy(&output.stderr);
    snapbox::assert_data_eq!(
        last.into_owned(),
        snapbox::str![[r#"
fre: servo 1: 14 bytes heard, 1 answers, 1 reads of Present Position
fre: 0 bytes lost

"#]]
    );
    assert!(!path.exists());
}

#[test]
fn the_factory_settings_are_those_of_the_manual() {
    let mut servo = Servo::new(Config::default()).unwrap();
    for item in xm430::ITEMS.iter().filter(|item| item.area == dynamixel::Area::Eeprom && item.address != 6) {
        let [a, b] = item.address.to_le_bytes();
        let answers = servo.hear(0, &question(Instruction::Read, &[a, b, item.length as u8, 0]));
        let parameters = answer(&mut answers[0].bytes.as_slice()).unwrap();
        assert_eq!(item.decode(&parameters), Some(item.default), "{item:?}");
    }
}
