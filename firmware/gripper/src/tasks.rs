//! The program's memory and tasks, which embassy wants written out for each board's types.

/// The memory of a [`Board`](crate::Board)'s gripper, its four tasks, and `run`, which starts them.
///
/// ```ignore
/// gripper::tasks!(MyBoard, sends: UartTx, hears: UartRx);
/// // … once the board is up; `control` spawns into an executor whose interrupt goes before thread mode, `serve` into one before that:
/// run(Above { serve, control }, spawner, (bus, watchdog), (tx, rx), (flash, boot));
/// ```
///
/// The board's crate depends on `defmt`, `embassy-executor`, `fre-boards` and `static_cell`.
#[macro_export]
macro_rules! tasks {
    ($board:ty, sends: $outgoing:ty, hears: $incoming:ty) => {
        /// What the image's file says of itself; the linker's script keeps it out of the board's memory.
        #[used]
        #[unsafe(link_section = ".fre_image")]
        static LABEL: fre_boards::Label = fre_boards::Label::new(<$board as $crate::Board>::NAME, $crate::VERSION);

        static SHARED: $crate::Shared = $crate::Shared::new();
        // What every tick works with is in a section of its own: a board's linker script can put it into memory without wait states.
        type Near = [$crate::Model; 1];
        type Far = [$crate::Model; <$board as $crate::Board>::FINGERS - 1];
        #[unsafe(link_section = ".bss.near")]
        static NEAR_MODELS: static_cell::ConstStaticCell<Near> =
            static_cell::ConstStaticCell::new([const { $crate::Model::EMPTY }; _]);
        static MODELS: static_cell::ConstStaticCell<Far> =
            static_cell::ConstStaticCell::new([const { $crate::Model::EMPTY }; _]);

        type BusOf = <$board as $crate::Board>::Bus;
        type WatchdogOf = <$board as $crate::Board>::Watchdog;
        type FlashOf = <$board as $crate::Board>::Flash;

        /// Where tasks are started that interrupt others.
        struct Above {
            /// For the bus task: before all others.
            serve: embassy_executor::SendSpawner,
            /// For the control task.
            control: embassy_executor::SendSpawner,
        }

        /// Starts the tasks.
        fn run(
            above: Above,
            below: embassy_executor::Spawner,
            (port, watchdog): (BusOf, WatchdogOf),
            (outgoing, incoming): ($outgoing, $incoming),
            (flash, boot): (FlashOf, $crate::Boot),
        ) {
            static BUS: static_cell::StaticCell<$crate::Bus<BusOf>> = static_cell::StaticCell::new();
            let bus = BUS.init_with(|| $crate::Bus::new(port, <$board as $crate::Board>::BUS_LATENCY_US));
            match (serve(bus), control(NEAR_MODELS.take(), MODELS.take(), bus, watchdog)) {
                (Ok(serves), Ok(controls)) => {
                    above.serve.spawn(serves);
                    above.control.spawn(controls);
                }
                _ => defmt::error!("no room for the control task and the bus task"),
            }
            start(below, send(outgoing));
            start(below, answer(incoming, flash, boot));
        }

        fn start<S>(
            spawner: embassy_executor::Spawner,
            task: Result<embassy_executor::SpawnToken<S>, embassy_executor::SpawnError>,
        ) {
            match task {
                Ok(task) => spawner.spawn(task),
                Err(_) => defmt::error!("no room for a task"),
            }
        }

        #[embassy_executor::task]
        async fn serve(bus: &'static $crate::Bus<BusOf>) -> ! {
            $crate::serve::<$board>(&SHARED, bus).await
        }

        #[embassy_executor::task]
        async fn control(
            near: &'static mut Near,
            far: &'static mut Far,
            bus: &'static $crate::Bus<BusOf>,
            watchdog: WatchdogOf,
        ) -> ! {
            $crate::control::<$board>(&SHARED, near.iter_mut().chain(far), bus, watchdog).await
        }

        #[embassy_executor::task]
        async fn send(link: $outgoing) -> ! {
            $crate::send(&SHARED, link).await
        }

        #[embassy_executor::task]
        async fn answer(link: $incoming, flash: FlashOf, boot: $crate::Boot) -> ! {
            $crate::answer::<$board, _>(&SHARED, link, flash, boot).await
        }
    };
}
