//! The link's frames: any bytes decode the same in any pieces, what decodes encodes again, and the next frame is heard.

use messages::frame::{Decoder, FRAME, FrameError, MESSAGE, encode};

use crate::Target;

pub(crate) const TARGET: Target = Target { name: "frame", run, seeds, words: Vec::new };

fn decode(decoder: &mut Decoder, mut bytes: &[u8], events: &mut Vec<Result<Vec<u8>, FrameError>>) {
    while let Some(event) = decoder.feed(&mut bytes) {
        events.push(event.map(|message| message.to_vec()));
    }
    assert!(bytes.is_empty());
}

fn frame(message: &[u8]) -> Vec<u8> {
    encode(message, &mut [0; FRAME]).expect("a message fits").to_vec()
}

fn run(bytes: &[u8]) {
    let (mut whole, mut pieces) = (Decoder::new(), Decoder::new());
    let (mut events, mut same) = (Vec::new(), Vec::new());
    decode(&mut whole, bytes, &mut events);
    bytes.iter().for_each(|&byte| decode(&mut pieces, &[byte], &mut same));
    assert_eq!(events, same);
    for message in events.into_iter().flatten().filter(|message| message.len() <= MESSAGE) {
        let mut again = Vec::new();
        decode(&mut Decoder::new(), &frame(&message), &mut again);
        assert_eq!(again, [Ok(message)]);
    }
    // A frame begins with the zero that ends whatever came before.
    let mut after = Vec::new();
    decode(&mut whole, &frame(b"next"), &mut after);
    assert_eq!(after.last(), Some(&Ok(b"next".to_vec())));
}

/// Messages of every kind of length for the encoding, alone and one after another.
fn seeds() -> Vec<Vec<u8>> {
    let messages =
        [vec![], vec![0; 3], b"a message".to_vec(), vec![1; 254], vec![7; 255], (0..=255).cycle().take(600).collect()];
    let frames = messages.iter().map(|message: &Vec<u8>| frame(message));
    frames.chain([messages.iter().flat_map(|message| frame(message)).collect()]).collect()
}
