//! Dynamixel packets: any bytes decode the same in any pieces, what decodes encodes again, and the next packet is heard.

use dynamixel::{DecodeError, Decoder, Encoder, Id, Instruction, encode, examples};

use crate::Target;

pub(crate) const TARGET: Target = Target { name: "codec", run, seeds, words: Vec::new };

/// Longest packet, bytes.
const LONGEST: usize = 256;

type Event = Result<(Id, u8, Vec<u8>), DecodeError>;

fn decode(decoder: &mut Decoder<LONGEST>, mut bytes: &[u8], events: &mut Vec<Event>) {
    while let Some(event) = decoder.feed(&mut bytes) {
        events.push(event.map(|packet| (packet.id, packet.code, packet.parameters.to_vec())));
    }
    assert!(bytes.is_empty() && decoder.pending() <= LONGEST);
}

fn run(bytes: &[u8]) {
    let (mut whole, mut pieces) = (Decoder::new(), Decoder::new());
    let (mut events, mut same) = (Vec::new(), Vec::new());
    decode(&mut whole, bytes, &mut events);
    bytes.iter().for_each(|&byte| decode(&mut pieces, &[byte], &mut same));
    assert_eq!((&events, whole.pending()), (&same, pieces.pending()));
    for (id, code, parameters) in events.into_iter().flatten() {
        let mut buffer = [0; LONGEST];
        let encoded = Encoder::with_code(&mut buffer, id, code).bytes(&parameters).finish();
        // A packet that has stuffing where none is needed is longer than ours, never shorter.
        let encoded = encoded.expect("what was received fits");
        let mut again = Vec::new();
        decode(&mut Decoder::new(), encoded, &mut again);
        assert_eq!(again, [Ok((id, code, parameters))]);
    }
    whole.pause();
    let mut after = Vec::new();
    let ping = encode(&mut [0; 16], Id::MAX, Instruction::Ping, &[]).expect("a ping is short").to_vec();
    decode(&mut whole, &ping, &mut after);
    assert_eq!(after.last(), Some(&Ok((Id::MAX, Instruction::Ping.code(), Vec::new()))));
}

/// The protocol's published packets, one by one and together, and a fast answer, which is not stuffed.
fn seeds() -> Vec<Vec<u8>> {
    let published = examples::EXAMPLES.iter().map(|example| example.bytes.to_vec());
    let together: Vec<u8> = examples::EXAMPLES.iter().flat_map(|example| example.bytes.iter().copied()).collect();
    let fast = Encoder::with_code(&mut [0; 64], Id::BROADCAST, Instruction::Status.code())
        .bytes(&[0, 3, 0xFF, 0xFF, 0xFD, 0x00, 0, 0, 0, 7, 1, 2, 3, 4])
        .finish()
        .expect("it fits")
        .to_vec();
    published.chain([together, fast]).collect()
}
