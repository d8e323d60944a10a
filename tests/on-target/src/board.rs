//! The board support itself: arithmetic, clock, UARTs, counts, panics.

#[embedded_test::tests(default_timeout = 30, executor = mps2::Executor::new())]
mod tests {
    use core::hint::black_box;
    use embassy_futures::join::join;
    use embassy_time::{Duration, Instant, Timer, with_timeout};
    use embedded_io_async::{Read, Write};
    use mps2::{Board, UartRx, UartTx, cycles, stack};

    /// QEMU wakes a sleeping machine late by what the PC is busy with. A wrong rate would be off by more.
    const LATE_MICROS: u64 = 250_000;

    #[init]
    fn init() -> Board {
        mps2::init()
    }

    /// Single precision rounds as IEEE 754 says: the sum and the fused-free product, bit for bit.
    #[test]
    fn single_precision_is_ieee() {
        let (a, b) = (black_box(0.1_f32), black_box(0.2_f32));
        assert_eq!((a + b).to_bits(), 0x3e99_999a);
        assert_eq!((a * b).to_bits(), 0x3ca3_d70b);
        // (1 + 2⁻¹²)² − (1 + 2⁻¹¹) is 2⁻²⁴ if multiply and add are fused, 0 if each rounds.
        let c = black_box(1.0_f32 + 1.0 / 4096.0);
        let d = black_box(1.0_f32 + 1.0 / 2048.0);
        assert_eq!(c * c - d, 0.0);
    }

    #[test]
    fn double_precision_is_ieee() {
        let (a, b) = (black_box(0.1_f64), black_box(0.2_f64));
        assert_eq!((a + b).to_bits(), 0x3fd3_3333_3333_3334);
        assert_eq!(black_box(2.0_f64) / black_box(3.0_f64), 0.666_666_666_666_666_6);
    }

    /// The clock never goes back, and agrees with the independent 25 MHz counter.
    #[test]
    fn clock_is_monotonic_and_runs_at_the_right_rate(_board: Board) {
        let (start, cycles_start) = (Instant::now(), cycles::now());
        let mut last = start;
        while last - start < Duration::from_millis(20) {
            let now = Instant::now();
            assert!(now >= last);
            last = now;
        }
        let micros = (last - start).as_micros();
        let by_cycles = u64::from(cycles::now().wrapping_sub(cycles_start)) / 25;
        assert!(by_cycles.abs_diff(micros) <= 5, "{micros} µs by the clock, {by_cycles} by cycles");
    }

    /// An alarm comes after its time, and little after.
    #[test]
    async fn alarms_are_on_time(_board: Board) {
        for micros in [1, 50, 999, 30_000] {
            let start = Instant::now();
            Timer::after_micros(micros).await;
            let late = start.elapsed().as_micros().checked_sub(micros);
            assert!(late.is_some_and(|late| late < LATE_MICROS), "{micros} µs: {late:?} late");
        }
    }

    /// Alarms set out of order come in order.
    #[test]
    async fn alarms_come_in_order(_board: Board) {
        let start = Instant::now();
        let (long, short) = join(
            async {
                Timer::after_millis(20).await;
                start.elapsed()
            },
            async {
                Timer::after_millis(5).await;
                start.elapsed()
            },
        )
        .await;
        assert!(short < long && short.as_millis() >= 5 && long.as_millis() >= 20);
    }

    /// The 32-bit counter wraps after 71 minutes; time and alarms go on.
    #[test]
    async fn clock_survives_wraparound(_board: Board) {
        for wraps in 1..=2_u64 {
            mps2::skip_to_wraparound(3_000);
            let before = Instant::now();
            assert_eq!(before.as_micros() >> 32, wraps - 1);
            Timer::after_millis(10).await;
            let after = Instant::now();
            assert_eq!(after.as_micros() >> 32, wraps);
            let micros = (after - before).as_micros();
            assert!((10_000..10_000 + LATE_MICROS).contains(&micros), "{micros} µs");
        }
    }

    /// A timeout ends a read to which nothing comes.
    #[test]
    async fn a_silent_line_times_out(mut board: Board) {
        let mut byte = [0];
        let result = with_timeout(Duration::from_millis(5), board.bus.rx.read(&mut byte)).await;
        assert!(result.is_err());
    }

    const STREAM: usize = 20_000;

    fn byte_at(index: usize, seed: u32) -> u8 {
        ((index as u32).wrapping_mul(2_654_435_761) ^ seed).to_be_bytes()[0]
    }

    async fn send(tx: &mut UartTx, seed: u32) {
        let mut index = 0;
        while index < STREAM {
            let mut chunk = [0; 100];
            for (offset, byte) in chunk.iter_mut().enumerate() {
                *byte = byte_at(index + offset, seed);
            }
            let Ok(()) = tx.write_all(&chunk).await;
            index += chunk.len();
        }
        let Ok(()) = tx.flush().await;
    }

    async fn receive(rx: &mut UartRx, seed: u32, pause: Duration) {
        let mut index = 0;
        let mut buffer = [0; 700];
        while index < STREAM {
            Timer::after(pause).await;
            let Ok(count) = rx.read(&mut buffer).await;
            for byte in &buffer[..count] {
                assert_eq!(*byte, byte_at(index, seed), "byte {index}");
                index += 1;
            }
        }
        assert_eq!(index, STREAM);
    }

    /// Both lines at once, both ways, every byte in its place.
    #[test]
    async fn uarts_carry_both_ways(board: Board) {
        let (mut bus_tx, mut bus_rx) = board.bus.split();
        let (mut link_tx, mut link_rx) = board.link.split();
        let quick = Duration::from_ticks(0);
        join(
            join(send(&mut bus_tx, 1), receive(&mut link_rx, 1, quick)),
            join(send(&mut link_tx, 2), receive(&mut bus_rx, 2, quick)),
        )
        .await;
    }

    /// A reader slower than the sender finds its ring full, and loses nothing.
    #[test]
    async fn a_full_ring_loses_nothing(board: Board) {
        let (mut bus_tx, _) = board.bus.split();
        let (_, mut link_rx) = board.link.split();
        let slow = Duration::from_millis(20);
        join(send(&mut bus_tx, 3), receive(&mut link_rx, 3, slow)).await;
    }

    /// What does not fit is refused whole.
    #[test]
    fn a_frame_is_queued_whole_or_not_at_all(mut board: Board) {
        let frame = [0x55; 256];
        let mut refused = 0;
        // Nobody reads: the receiving ring, the socket between, then the sending ring fill up.
        for _ in 0..10_000 {
            let space = board.bus.tx.space();
            if !board.bus.tx.try_write_all(&frame) {
                assert!(space < frame.len(), "refused with {space} bytes free");
                refused += 1;
            }
        }
        assert!(refused > 0, "the line never filled up");
        assert!(board.bus.tx.space() < frame.len());
    }

    #[test]
    fn baud_rates_are_what_the_divider_gives(mut board: Board) {
        assert_eq!(board.bus.tx.set_baud(1_000_000), 1_000_000);
        assert_eq!(board.bus.tx.set_baud(57_600), 25_000_000 / 434);
        assert_eq!(board.bus.tx.set_baud(4_000_000), 1_562_500);
    }

    /// The runner's `-icount shift=2`: ten instructions a tick. A loop of n turns takes n times its instructions, exactly.
    #[test]
    fn cycles_count_instructions(_board: Board) {
        fn turns(n: u32) -> u32 {
            cycles::of(|| {
                for i in 0..n {
                    black_box(i);
                }
            })
            .1
        }
        let (one, ten) = (turns(100_000), turns(1_000_000));
        let ratio = f64::from(ten) / f64::from(one);
        assert!((9.9..10.1).contains(&ratio), "{one} and {ten} ticks");
        // Between 2 and 10 instructions a turn, whatever the compiler made of it.
        assert!((20_000..100_000).contains(&one), "{one} ticks for 100,000 turns");
    }

    /// An array of 8 KB on the stack is seen, and only when it is there.
    #[test]
    fn stack_use_is_measured(_board: Board) {
        #[inline(never)]
        fn deep() -> u8 {
            let mut array = [0_u8; 8192];
            for (index, byte) in array.iter_mut().enumerate() {
                *byte = black_box(index as u8);
            }
            black_box(&array)[black_box(100)]
        }
        let (value, with) = stack::peak_of(deep);
        assert_eq!(value, 100);
        let ((), without) = stack::peak_of(|| ());
        assert!((8192..10_000).contains(&with), "{with} bytes");
        assert!(without < 1024, "{without} bytes");
    }

    #[test]
    #[should_panic]
    fn a_panic_ends_the_test(_board: Board) {
        let index = black_box(3);
        assert!([0, 1, 2].get(index).is_some(), "index {index}");
    }
}
