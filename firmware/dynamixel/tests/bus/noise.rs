//! What a bad line does to each side of the bus, counted: nothing hangs, nothing false is believed, and the next sound
//! packet is heard.

use crate::id;
use crate::servo::Servo;
use crate::traffic::{Frame, SERVOS, TIMING, Traffic, is_position};
use crate::world::{Bus, Clock};
use dynamixel::{Answer, Decoder, Device, Error, Heard, Instruction, Master, Tap, Timing, encode, xm430};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Bytes of noise.
const NOISE: usize = 1_000_000;

/// Random bytes; every other kilobyte is made of what headers are made of.
fn noise(seed: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut bytes = vec![0; NOISE];
    random.fill_bytes(&mut bytes);
    for kilobyte in bytes.chunks_mut(1000).step_by(2) {
        for byte in kilobyte.iter_mut().filter(|byte| **byte & 3 > 0) {
            *byte = [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x55][usize::from(*byte >> 2) % 6];
        }
    }
    bytes
}

#[test]
fn the_codec_takes_a_million_bytes_of_noise() {
    let ping = encode(&mut [0; 16], id(1), Instruction::Ping, &[]).unwrap().to_vec();
    let mut decoder = Decoder::<512>::new();
    let (mut packets, mut broken, mut pings) = (0, 0, 0);
    for piece in noise(1).chunks(1000) {
        let mut bytes = piece;
        while let Some(event) = decoder.feed(&mut bytes) {
            *if event.is_ok() { &mut packets } else { &mut broken } += 1;
        }
        // A header in the noise may promise more than comes: a pause ends it, and the next packet is heard.
        decoder.pause();
        let mut bytes = ping.as_slice();
        while let Some(event) = decoder.feed(&mut bytes) {
            pings += u32::from(event.is_ok_and(|packet| packet.id == id(1) && packet.parameters.is_empty()));
        }
    }
    println!("codec: {packets} packets and {broken} broken ones in {NOISE} bytes; {pings} of 1000 pings heard");
    // One broken packet in 65,536 has a fitting CRC.
    assert!(packets <= 1 && broken > 100, "{packets} packets, {broken} broken");
    assert_eq!(pings, 1000);
}

#[test]
fn the_tap_learns_nothing_from_a_million_bytes_of_noise() {
    let mut tap = Tap::<256, 4>::new(TIMING);
    assert!(SERVOS.into_iter().all(|servo| tap.watch(id(servo))));
    let mut traffic = Traffic::new(7);
    let (mut now_us, mut told, mut learned) = (0, 0, 0);
    for piece in noise(2).chunks(1000) {
        now_us += 20_000;
        let mut bytes = piece;
        while let Some(heard) = tap.hear(now_us, &mut bytes) {
            told += u32::from(matches!(heard, Heard::Read { .. } | Heard::Written { .. } | Heard::Found { .. }));
        }
        now_us += 1_000;
        for Frame { bytes, .. } in traffic.ask(2, Instruction::Read, &[132, 0, 4, 0]) {
            now_us += 10 * bytes.len() as u64;
            let mut bytes = bytes.as_slice();
            while let Some(heard) = tap.hear(now_us, &mut bytes) {
                learned += u32::from(matches!(heard, Heard::Read { address: 132, .. }));
            }
        }
    }
    println!("tap: {told} things told by {NOISE} bytes of noise; {learned} of 1000 positions between them learned");
    assert_eq!((told, learned), (0, 1000));
    assert!(is_position(2, tap.servo(id(2)).unwrap().position.unwrap().value));
}

#[test]
fn a_device_answers_after_a_million_bytes_of_noise() {
    let mut device = Device::<128>::new(Timing::at(1_000_000));
    let mut servo = Servo::new(1);
    let ping = encode(&mut [0; 16], id(1), Instruction::Ping, &[]).unwrap().to_vec();
    let before = servo.memory;
    let (mut now_us, mut babble, mut answers) = (0, 0, 0);
    for piece in noise(3).chunks(1000) {
        now_us += 20_000;
        let mut bytes = piece;
        while device.hear(now_us, &mut bytes, &mut servo).is_some() {
            babble += 1;
        }
        now_us += 10_000;
        while device.poll(now_us, &mut servo).is_some() {
            babble += 1;
        }
        let mut bytes = ping.as_slice();
        answers += u32::from(device.hear(now_us, &mut bytes, &mut servo).is_some());
    }
    println!("device: {babble} answers to {NOISE} bytes of noise; {answers} of 1000 pings answered");
    // What looks like an instruction to it with a wrong CRC is answered as such.
    assert!(babble < 50, "{babble}");
    assert_eq!((answers, servo.memory), (1000, before));
}

#[test]
fn a_master_on_a_noisy_line_gets_the_truth_or_an_error() {
    let bus = Bus::new(&[1, 2]);
    bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, 166));
    bus.servo(1, |servo| servo.put(xm430::PRESENT_POSITION, 2_079));
    let patient = Timing { latency_us: 1_000, ..TIMING };
    let mut master: Master<Bus, Clock> = Master::new(bus.clone(), Clock(bus.clone()), patient);
    let (mut right, mut failed) = (0, 0);
    for (round, piece) in noise(4).chunks(100).enumerate() {
        // Half of the noise is there when the master asks, half comes with the answer.
        let (before, with) = piece.split_at(50);
        bus.inject(before);
        let with = with[..round % 50].to_vec();
        bus.tamper(move |answer| vec![(0, [with.as_slice(), answer].concat())]);
        let device = 1 + (round % 2) as u8;
        match bus.run(master.get(id(device), xm430::PRESENT_POSITION)) {
            Ok(Answer { value, .. }) => {
                assert_eq!(value, [166, 2_079][round % 2]);
                right += 1;
            }
            Err(Error::Port(never)) => match never {},
            Err(_) => failed += 1,
        }
    }
    println!("master: {right} answers right, {failed} failed, none wrong, with {NOISE} bytes of noise");
    assert!(right > 7_000, "{right} right, {failed} failed");
    assert!(bus.run(master.ping(id(1))).is_ok());
}

/// One bit in a thousand, frames that get lost, frames that come twice: what the master is told is right or an error, and the
/// next question is answered as if nothing had been.
#[test]
fn a_master_with_bad_answers_gets_the_truth_or_an_error() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut below = move |limit: u32| random.next_u32() % limit;
    for (kind, least) in [("bits", 8_000), ("drop", 8_000), ("double", 9_990)] {
        let bus = Bus::new(&[1]);
        let mut master: Master<Bus, Clock> = Master::new(bus.clone(), Clock(bus.clone()), TIMING);
        let (mut right, mut failed, mut clean) = (0, 0, 0);
        for round in 0..10_000 {
            bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, round));
            let (flips, chance): (Vec<bool>, _) = ((0..256).map(|_| below(1000) == 0).collect(), below(10));
            bus.tamper(move |answer| match kind {
                "bits" => {
                    let mut answer = answer.to_vec();
                    for (at, byte) in answer.iter_mut().enumerate() {
                        let bits = flips[8 * at..8 * at + 8].iter().enumerate();
                        *byte ^= bits.map(|(bit, &flip)| u8::from(flip) << bit).sum::<u8>();
                    }
                    vec![(0, answer)]
                }
                "drop" if chance == 0 => vec![],
                "double" if chance == 0 => vec![(0, answer.repeat(2))],
                _ => vec![(0, answer.to_vec())],
            });
            // What comes a second time is over when the master asks again.
            bus.rest(500);
            match bus.run(master.get(id(1), xm430::PRESENT_POSITION)) {
                Ok(answer) => {
                    assert_eq!(answer.value, round, "{kind}");
                    right += 1;
                }
                Err(_) => {
                    failed += 1;
                    clean += u32::from(bus.run(master.get(id(1), xm430::PRESENT_POSITION)).is_ok());
                }
            }
        }
        println!("master, {kind}: {right} of 10000 answers right, {failed} failed, {clean} right when asked again");
        assert!(right >= least, "{kind}: {right}");
        assert_eq!(clean, failed, "{kind}");
    }
}
