//! A queue of bytes between an interrupt and the program, without a lock: one side pushes, the other pops.

use core::sync::atomic::{AtomicU8, AtomicUsize, Ordering};

/// Room for `N` − 1 bytes. All zeros when empty, so that it takes no room in the image.
pub struct Ring<const N: usize> {
    bytes: [AtomicU8; N],
    /// Where the next byte is popped. Written by the side that pops.
    first: AtomicUsize,
    /// Where the next byte is pushed. Written by the side that pushes.
    free: AtomicUsize,
}

impl<const N: usize> Default for Ring<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Ring<N> {
    /// An empty one.
    pub const fn new() -> Self {
        Self { bytes: [const { AtomicU8::new(0) }; N], first: AtomicUsize::new(0), free: AtomicUsize::new(0) }
    }

    #[inline(always)]
    const fn after(place: usize) -> usize {
        if place + 1 < N { place + 1 } else { 0 }
    }

    /// Adds a byte; returns whether there was room.
    #[inline(always)]
    pub fn push(&self, byte: u8) -> bool {
        let free = self.free.load(Ordering::Relaxed);
        let next = Self::after(free);
        if next == self.first.load(Ordering::Acquire) {
            return false;
        }
        let Some(place) = self.bytes.get(free) else {
            return false;
        };
        place.store(byte, Ordering::Relaxed);
        self.free.store(next, Ordering::Release);
        true
    }

    /// Takes the oldest byte.
    #[inline(always)]
    pub fn pop(&self) -> Option<u8> {
        let first = self.first.load(Ordering::Relaxed);
        if first == self.free.load(Ordering::Acquire) {
            return None;
        }
        let byte = self.bytes.get(first)?.load(Ordering::Relaxed);
        self.first.store(Self::after(first), Ordering::Release);
        Some(byte)
    }

    /// Bytes inside.
    #[inline(always)]
    pub fn len(&self) -> usize {
        let first = self.first.load(Ordering::Acquire);
        let free = self.free.load(Ordering::Acquire);
        if free >= first { free - first } else { free + N - first }
    }

    /// Whether there is none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether half of the room is taken.
    #[inline(always)]
    pub fn is_half_full(&self) -> bool {
        self.len() * 2 >= N
    }
}
