//! Frames survive any message, and a damaged one costs itself only.

use messages::frame::{Decoder, FRAME, FrameError, MESSAGE, encode};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

fn random(seed: u64) -> impl FnMut(usize) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move |length| {
        let mut bytes = vec![0; length];
        random.fill_bytes(&mut bytes);
        // Zeros and long runs without are what COBS is about.
        for byte in &mut bytes {
            *byte = if *byte < 16 { 0 } else { *byte };
        }
        bytes
    }
}

fn framed(message: &[u8]) -> Vec<u8> {
    let mut buffer = [0; FRAME];
    encode(message, &mut buffer).unwrap().to_vec()
}

/// Everything a decoder makes of bytes that arrive in pieces of this length.
fn heard(bytes: &[u8], piece: usize) -> Vec<Result<Vec<u8>, FrameError>> {
    let mut decoder: Decoder = Decoder::new();
    let mut all = Vec::new();
    for mut piece in bytes.chunks(piece) {
        while let Some(event) = decoder.feed(&mut piece) {
            all.push(event.map(|message| message.to_vec()));
        }
    }
    all
}

#[test]
fn messages_of_every_length_pass() {
    let mut random = random(1);
    for length in (0..600).chain([MESSAGE - 1, MESSAGE]) {
        for message in [vec![0; length], vec![1; length], random(length)] {
            let frame = framed(&message);
            assert_eq!(frame[0], 0);
            assert_eq!(frame.iter().filter(|&&byte| byte == 0).count(), 2, "zeros at the ends only");
            assert_eq!(heard(&frame, 7), [Ok(message)]);
        }
    }
}

#[test]
fn a_message_too_long_is_refused() {
    let mut buffer = [0; FRAME];
    assert_eq!(encode(&[1; MESSAGE + 300], &mut buffer), Err(FrameError::TooLong));
    assert_eq!(encode(&[1; 20], &mut buffer[..20]), Err(FrameError::TooLong));
}

#[test]
fn any_changed_byte_is_noticed_and_costs_one_frame() {
    let mut random = random(2);
    let messages = [random(40), random(90), random(300)];
    let frames = messages.each_ref().map(|message| framed(message));
    for place in 0..frames[1].len() {
        for change in [0x01, 0x80, 0xFF, frames[1][place]] {
            let mut damaged = frames[1].clone();
            damaged[place] ^= change;
            let stream = [frames[0].as_slice(), &damaged, &frames[2]].concat();
            let sound: Vec<_> = heard(&stream, 64).into_iter().filter_map(Result::ok).collect();
            let undamaged = change == 0;
            assert!(sound.contains(&messages[0]) && sound.contains(&messages[2]), "byte {place} ^ {change:#x}");
            // The outer zeros are redundant: changed, they cost at most the frame.
            let inside = place > 0 && place + 1 < damaged.len();
            assert!(!inside || undamaged || !sound.contains(&messages[1]), "byte {place} ^ {change:#x}");
        }
    }
}

#[test]
fn noise_between_frames_costs_nothing() {
    let mut random = random(3);
    for length in [1, 10, 5000] {
        let message = random(100);
        let stream = [framed(&message), random(length), framed(&message)].concat();
        let sound: Vec<_> = heard(&stream, 100).into_iter().filter_map(Result::ok).collect();
        assert_eq!(sound, [message.clone(), message]);
    }
}

#[test]
fn a_frame_too_long_is_reported_once() {
    let stream = [vec![1; 3 * FRAME], vec![0], framed(b"next")].concat();
    assert_eq!(heard(&stream, 1000), [Err(FrameError::TooLong), Ok(b"next".to_vec())]);
}
