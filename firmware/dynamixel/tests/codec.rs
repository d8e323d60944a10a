//! Encoder and decoder against each other, against an encoder written straight from the manual, and against damage.

use dynamixel::{DecodeError, Decoder, Encoder, Id, encode, longest_packet_length};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

const LONGEST: usize = 512;

/// An owned packet.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Whole {
    id: u8,
    code: u8,
    parameters: Vec<u8>,
}

struct Source(ChaCha8Rng);

impl Source {
    fn new(seed: u64) -> Self {
        Source(ChaCha8Rng::seed_from_u64(seed))
    }

    fn below(&mut self, limit: usize) -> usize {
        self.0.next_u32() as usize % limit
    }

    /// Half of the bytes come from what headers and stuffing are made of.
    fn byte(&mut self) -> u8 {
        if self.below(2) == 0 { [0xFF, 0xFF, 0xFD, 0x00][self.below(4)] } else { self.0.next_u32() as u8 }
    }

    fn bytes(&mut self, most: usize) -> Vec<u8> {
        (0..self.below(most + 1)).map(|_| self.byte()).collect()
    }

    fn packet(&mut self, most: usize) -> Whole {
        let id = if self.below(5) == 0 { 254 } else { self.below(253) as u8 };
        // One in ten is the answer to a fast read, which is not stuffed.
        let code = if id == 254 && self.below(2) == 0 { 0x55 } else { self.byte() };
        Whole { id, code, parameters: self.bytes(most) }
    }
}

fn id(id: u8) -> Id {
    if id == 254 { Id::BROADCAST } else { Id::new(id).unwrap() }
}

fn ours(packet: &Whole) -> Vec<u8> {
    let mut buffer = [0; LONGEST];
    Encoder::with_code(&mut buffer, id(packet.id), packet.code).bytes(&packet.parameters).finish().unwrap().to_vec()
}

/// The manual's "processing order of transmission", step by step, CRC by polynomial division.
fn manual(packet: &Whole) -> Vec<u8> {
    let body: Vec<u8> = [&[packet.code], packet.parameters.as_slice()].concat();
    let mut stuffed = Vec::new();
    for (at, &byte) in body.iter().enumerate() {
        stuffed.push(byte);
        let fast_answer = packet.id == 254 && packet.code == 0x55;
        if at >= 2 && !fast_answer && body[at - 2..=at] == [0xFF, 0xFF, 0xFD] {
            stuffed.push(0xFD);
        }
    }
    let length = stuffed.len() as u16 + 2;
    let mut bytes = vec![0xFF, 0xFF, 0xFD, 0x00, packet.id, length as u8, (length >> 8) as u8];
    bytes.extend(stuffed);
    let mut remainder = 0u32;
    for bit in bytes.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1)) {
        remainder ^= u32::from(bit) << 15;
        remainder <<= 1;
        if remainder & 0x1_0000 != 0 {
            remainder ^= 0x1_8005;
        }
    }
    bytes.extend([remainder as u8, (remainder >> 8) as u8]);
    bytes
}

fn decode<const N: usize>(decoder: &mut Decoder<N>, mut bytes: &[u8]) -> Vec<Result<Whole, DecodeError>> {
    let mut events = Vec::new();
    while let Some(event) = decoder.feed(&mut bytes) {
        events.push(event.map(|packet| Whole {
            id: packet.id.get(),
            code: packet.code,
            parameters: packet.parameters.to_vec(),
        }));
    }
    assert!(bytes.is_empty());
    events
}

#[test]
fn round_trip_in_any_pieces() {
    let mut source = Source::new(1);
    let mut decoder = Decoder::<LONGEST>::new();
    for _ in 0..20_000 {
        let packets: Vec<Whole> = (0..1 + source.below(3)).map(|_| source.packet(60)).collect();
        let mut bytes = Vec::new();
        for packet in &packets {
            let encoded = ours(packet);
            assert_eq!(encoded, manual(packet));
            assert!(encoded.len() <= longest_packet_length(packet.parameters.len()));
            bytes.extend(encoded);
        }
        let mut rest = bytes.as_slice();
        let mut events = Vec::new();
        while !rest.is_empty() {
            let (piece, behind) = rest.split_at(1 + source.below(rest.len()));
            events.extend(decode(&mut decoder, piece));
            rest = behind;
        }
        assert_eq!(events, packets.into_iter().map(Ok).collect::<Vec<_>>());
        assert_eq!((decoder.pending(), decoder.skipped()), (0, 0));
    }
}

#[test]
fn every_length_up_to_the_capacity() {
    let mut decoder = Decoder::<128>::new();
    for length in 0..=118 {
        let packet = Whole { id: 3, code: 0x03, parameters: vec![0xAA; length] };
        assert_eq!(decode(&mut decoder, &ours(&packet)), [Ok(packet)]);
    }
    let long = Whole { id: 3, code: 0x03, parameters: vec![0xAA; 119] };
    let next = Whole { id: 4, code: 0x01, parameters: vec![] };
    let events = decode(&mut decoder, &[ours(&long), ours(&next)].concat());
    assert_eq!(events, [Err(DecodeError::Length { id: 3, length: 122, longest: 121 }), Ok(next)]);
}

/// Every beginning of a packet, followed by another: the second is there as soon as its last byte is.
#[test]
fn a_truncated_packet_does_not_cost_the_next() {
    let mut source = Source::new(2);
    for _ in 0..300 {
        let (first, second) = (source.packet(20), source.packet(20));
        let encoded = ours(&first);
        for kept in 0..encoded.len() {
            let bytes = [&encoded[..kept], &ours(&second)].concat();
            let events = decode(&mut Decoder::<LONGEST>::new(), &bytes);
            // A lost last byte can be replaced by the next header's 0xFF, which then lacks it.
            let completed = kept + 1 == encoded.len() && encoded[kept] == 0xFF;
            let completed = completed || (kept + 2 == encoded.len() && encoded[kept..] == [0xFF, 0xFF]);
            if completed {
                assert_eq!(events, [Ok(first.clone())]);
            } else {
                assert_eq!(events.last(), Some(&Ok(second.clone())), "{kept} of {encoded:02X?}");
                assert!(events[..events.len() - 1].iter().all(Result::is_err));
            }
        }
    }
}

#[test]
fn errors_say_what_was_received() {
    let mut decoder = Decoder::<64>::new();
    let header = [0xFF, 0xFF, 0xFD, 0x00];
    for id in [253, 255] {
        let events = decode(&mut decoder, &[&header[..], &[id, 3, 0]].concat());
        assert_eq!(events, [Err(DecodeError::Id { id })]);
    }
    for length in [0, 1, 2, 58, 0xFFFF] {
        let [low, high] = u16::to_le_bytes(length);
        let events = decode(&mut decoder, &[&header[..], &[9, low, high]].concat());
        assert_eq!(events, [Err(DecodeError::Length { id: 9, length, longest: 57 })]);
    }
    let ping = encode(&mut [0; 16], Id::new(1).unwrap(), dynamixel::Instruction::Ping, &[]).unwrap().to_vec();
    let events = decode(&mut decoder, &[&header[..], &[9, 20, 0, 2, 0], &ping].concat());
    assert_eq!(events[0], Err(DecodeError::Interrupted { id: 9, length: 20, received: 9 }));
    assert!(matches!(events[1..], [Ok(_)]));
    let mut damaged = ping.clone();
    damaged[9] ^= 1;
    let crc = DecodeError::Crc { id: 1, code: 1, computed: 0x4E19, received: 0x4F19 };
    assert_eq!(decode(&mut decoder, &damaged), [Err(crc)]);
}

/// Garbage of any kind between packets: every packet comes out, once what could still belong to the garbage is over.
#[test]
fn packets_are_found_in_garbage() {
    let mut source = Source::new(3);
    for round in 0..20_000 {
        let packets: Vec<Whole> = (0..3).map(|_| source.packet(20)).collect();
        let mut bytes = Vec::new();
        for packet in &packets {
            bytes.extend(source.bytes(40));
            bytes.extend(ours(packet));
        }
        bytes.extend([0; LONGEST]);
        let mut decoder = Decoder::<LONGEST>::new();
        let found: Vec<Whole> = decode(&mut decoder, &bytes).into_iter().flatten().collect();
        assert_eq!(found, packets, "round {round}: {bytes:02X?}");
    }
}

/// Up to three flipped bits are within the CRC's power (Hamming distance 4), unless they move the packet's end.
#[test]
fn flipped_bits_are_never_accepted_and_cost_one_packet() {
    let mut source = Source::new(4);
    let (mut lost, mut accepted) = (0, 0);
    for _ in 0..50_000 {
        let (first, second) = (source.packet(20), source.packet(20));
        let good = ours(&first);
        let mut encoded = good.clone();
        for _ in 0..=source.below(3) {
            let at = source.below(encoded.len());
            encoded[at] ^= 1 << source.below(8);
        }
        if encoded == good {
            continue;
        }
        let bytes = [encoded.as_slice(), &ours(&second), &[0; LONGEST]].concat();
        let found: Vec<Whole> = decode(&mut Decoder::<LONGEST>::new(), &bytes).into_iter().flatten().collect();
        lost += usize::from(!found.contains(&second));
        accepted += found.iter().filter(|packet| **packet != second).count();
    }
    assert_eq!((lost, accepted), (0, 0));
}

/// Lost, doubled, foreign bytes: what a 16-bit CRC lets through is one in 65,536 at most.
#[test]
fn arbitrary_damage_is_rejected_as_far_as_a_crc_can() {
    let mut source = Source::new(5);
    let mut accepted = 0;
    for _ in 0..50_000 {
        let first = source.packet(20);
        let good = ours(&first);
        let mut encoded = good.clone();
        let at = source.below(encoded.len());
        match source.below(4) {
            0 => {
                encoded.remove(at);
            }
            1 => encoded.insert(at, good[at]),
            2 => encoded[at] = source.byte(),
            _ => {
                let end = at + source.below(encoded.len() - at);
                for byte in &mut encoded[at..=end] {
                    *byte = source.byte();
                }
            }
        }
        encoded.extend([0; LONGEST]);
        let found = decode(&mut Decoder::<LONGEST>::new(), &encoded).into_iter().flatten();
        accepted += found.filter(|packet| *packet != first).count();
    }
    assert!(accepted <= 4, "{accepted}");
}

/// Any bytes at all: the decoder takes them all, keeps what it holds bounded, and still works.
#[test]
fn noise_leaves_the_decoder_whole() {
    let mut source = Source::new(6);
    let mut decoder = Decoder::<64>::new();
    for _ in 0..20_000 {
        decode(&mut decoder, &source.bytes(100));
        assert!(decoder.pending() < 64);
    }
    decoder.reset();
    let packet = source.packet(20);
    assert_eq!(decode(&mut decoder, &ours(&packet)), [Ok(packet)]);
}
