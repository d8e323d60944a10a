//! An instruction kept while it is being answered: who is asked for what, in which order.

use crate::packet::{Id, Instruction, Packet, fast_length};

/// One device's part of a reading instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// As written in the packet; above 252 nobody answers.
    pub(crate) id: u8,
    pub(crate) address: u16,
    pub(crate) length: u16,
}

/// An instruction with up to `N` parameter bytes.
#[derive(Clone, Debug)]
pub(crate) struct Request<const N: usize> {
    pub(crate) id: Id,
    /// None: no instruction, or one that has been answered.
    pub(crate) instruction: Option<Instruction>,
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Request<N> {
    pub(crate) const NONE: Self = Self { id: Id::BROADCAST, instruction: None, bytes: [0; N], length: 0 };

    /// Keeps an instruction. One that Protocol 2.0 does not define, or that is too long, is kept as none.
    pub(crate) fn keep(&mut self, packet: &Packet<'_>) {
        self.instruction = None;
        if let Some(place) = self.bytes.get_mut(..packet.parameters.len()) {
            place.copy_from_slice(packet.parameters);
            self.length = packet.parameters.len();
            self.id = packet.id;
            self.instruction = packet.instruction();
        }
    }

    /// Nothing is asked any more.
    pub(crate) fn drop(&mut self) {
        self.instruction = None;
    }

    pub(crate) fn parameters(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    /// Whether the devices answer with one packet.
    pub(crate) fn is_fast(&self) -> bool {
        matches!(self.instruction, Some(Instruction::FastSyncRead | Instruction::FastBulkRead))
    }

    /// Who answers after `place` others, and what; nothing behind the last, and if nothing is read.
    pub(crate) fn entry(&self, place: usize) -> Option<Entry> {
        entry(self.instruction?, self.id, self.parameters(), place)
    }

    /// The entries from `place` on.
    pub(crate) fn entries(&self, place: usize) -> impl Iterator<Item = Entry> {
        (place..).map_while(|place| self.entry(place))
    }

    /// Length field of the packet with which a fast read is answered; nothing if no packet is as long.
    pub(crate) fn fast_length(&self) -> Option<u16> {
        fast_length(self.entries(0).map(|entry| entry.length))
    }
}

fn entry(instruction: Instruction, id: Id, parameters: &[u8], place: usize) -> Option<Entry> {
    match instruction {
        Instruction::Read => match *parameters {
            [a, b, c, d] if place == 0 && !id.is_broadcast() => {
                Some(Entry { id: id.get(), address: u16::from_le_bytes([a, b]), length: u16::from_le_bytes([c, d]) })
            }
            _ => None,
        },
        Instruction::SyncRead | Instruction::FastSyncRead => {
            let (&[a, b, c, d], ids) = parameters.split_first_chunk()?;
            let &id = ids.get(place)?;
            Some(Entry { id, address: u16::from_le_bytes([a, b]), length: u16::from_le_bytes([c, d]) })
        }
        Instruction::BulkRead | Instruction::FastBulkRead => {
            let (&[id, a, b, c, d], _) = parameters.get(place.checked_mul(5)?..)?.split_first_chunk()?;
            Some(Entry { id, address: u16::from_le_bytes([a, b]), length: u16::from_le_bytes([c, d]) })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(id: Id, instruction: Instruction, parameters: &[u8]) -> Request<16> {
        let mut request = Request::NONE;
        request.keep(&Packet { id, code: instruction.code(), parameters });
        request
    }

    #[test]
    fn entries_are_in_the_order_of_the_instruction() {
        let one = Id::new(1).unwrap();
        let read = kept(one, Instruction::Read, &[132, 0, 4, 0]);
        assert_eq!(read.entries(0).collect::<std::vec::Vec<_>>(), [Entry { id: 1, address: 132, length: 4 }]);
        let sync = kept(Id::BROADCAST, Instruction::FastSyncRead, &[126, 0, 10, 0, 7, 3]);
        let ids: std::vec::Vec<u8> = sync.entries(0).map(|entry| entry.id).collect();
        assert_eq!((ids.as_slice(), sync.is_fast(), sync.fast_length()), ([7, 3].as_slice(), true, Some(29)));
        let bulk = kept(Id::BROADCAST, Instruction::BulkRead, &[3, 132, 0, 4, 0, 7, 124, 0, 2, 0, 9]);
        assert_eq!(bulk.entry(1), Some(Entry { id: 7, address: 124, length: 2 }));
        assert_eq!((bulk.entry(2), bulk.is_fast()), (None, false));
    }

    #[test]
    fn what_reads_nothing_has_no_entries() {
        assert_eq!(kept(Id::BROADCAST, Instruction::Read, &[132, 0, 4, 0]).entry(0), None);
        assert_eq!(kept(Id::BROADCAST, Instruction::SyncRead, &[132, 0, 4]).entry(0), None);
        assert_eq!(kept(Id::BROADCAST, Instruction::Ping, &[]).entry(0), None);
        assert_eq!(kept(Id::BROADCAST, Instruction::SyncRead, &[0; 17]).instruction, None);
    }
}
