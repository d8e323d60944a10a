//! The stretch below a stack that nobody may touch: every access to it faults, and none beside it does.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use cortex_m::peripheral::{MPU, SCB};
use cortex_m_rt::exception;
use stm32::guard::BYTES;

/// The stretch with as much memory on either side.
#[repr(align(4096))]
struct Memory([AtomicU8; 3 * BYTES as usize]);

static MEMORY: Memory = Memory([const { AtomicU8::new(0) }; _]);
/// Where the last fault was; 0 where none was.
static FAULT: AtomicU32 = AtomicU32::new(0);

/// Notes the address (MMFAR), and lets the access pass.
#[exception]
fn MemoryManagement() {
    // SAFETY: reads a register; nobody else holds the system control block or the memory protection unit.
    let address = unsafe { (*SCB::PTR).mmfar.read() };
    FAULT.store(address, Ordering::Relaxed);
    // SAFETY: the same.
    unsafe { (*MPU::PTR).ctrl.write(0) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

#[embedded_test::tests(default_timeout = 30, executor = mps2::Executor::new())]
mod tests {
    use super::*;
    use cortex_m::Peripherals;
    use cortex_m::peripheral::scb::Exception;
    use mps2::Board;

    #[init]
    fn init() -> Board {
        mps2::init()
    }

    /// The address at which an access to a byte of the memory faults.
    fn fault(core: &mut Peripherals, byte: usize, reads: bool) -> Option<u32> {
        let start = MEMORY.0.as_ptr().addr() as u32 + BYTES;
        stm32::guard::keep(&mut core.MPU, start);
        FAULT.store(0, Ordering::Relaxed);
        if reads {
            MEMORY.0[byte].load(Ordering::SeqCst);
        } else {
            MEMORY.0[byte].store(1, Ordering::SeqCst);
        }
        Some(FAULT.load(Ordering::Relaxed)).filter(|address| *address != 0)
    }

    #[test]
    fn only_what_is_guarded_faults(_board: Board) {
        // SAFETY: the board support is done with them.
        let mut core = unsafe { Peripherals::steal() };
        core.SCB.enable(Exception::MemoryManagement);
        let (first, behind) = (BYTES as usize, 2 * BYTES as usize);
        for reads in [true, false] {
            for byte in [0, first - 1, behind, behind + first - 1] {
                assert!(fault(&mut core, byte, reads).is_none(), "byte {byte}");
            }
            for byte in [first, first + 1000, behind - 1] {
                let at = MEMORY.0[byte].as_ptr().addr() as u32;
                assert!(fault(&mut core, byte, reads) == Some(at), "byte {byte}");
            }
        }
        assert!(MEMORY.0[first].load(Ordering::SeqCst) == 1, "it went on behind the fault");
    }
}
