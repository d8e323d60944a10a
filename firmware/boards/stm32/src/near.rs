//! Variables in memory without wait states, where a board has such memory beside its RAM or at its beginning: the linker's script `near.x`.

// What the script says.
unsafe extern "C" {
    static mut __snear: u64;
    static mut __enear: u64;
}

/// Sets them to zero, as the start-up code does with all others. Call it first of all: nothing may have used them. By whole double
/// words, so that memory with error correction is never read before it is written.
pub fn clear() {
    let mut place = &raw mut __snear;
    while place < &raw mut __enear {
        // SAFETY: the script gives the stretch to these variables only, aligned, and none of them is in use yet.
        unsafe {
            place.write_volatile(0);
            place = place.add(1);
        }
    }
}
