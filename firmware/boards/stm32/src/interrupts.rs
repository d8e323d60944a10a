//! Which interrupt of a chip does what for the gripper.

/// The interrupts of a board's [`Line`](crate::Line)s, of its bus task and of its control task, and `above`, which starts the executors of
/// the last two.
///
/// ```ignore
/// stm32::interrupts! {
///     BUS by BUS_USART on USART2, LINK by LINK_USART on USART3;
///     // Three devices that nothing here uses.
///     waking on SPDIF_RX; bus task on DCMI; control task on CEC
/// }
/// ```
///
/// A line's interrupt takes no lock (see [`critical`](crate::critical)) and runs from RAM (see [`fast`](crate::fast)); it has the one behind `waking on` wake whoever
/// waits. `Above` is of [`gripper::tasks!`]. The board's crate depends on `embassy-executor` and `embassy-stm32`.
#[macro_export]
macro_rules! interrupts {
    (
        $($line:ident by $usart:ident on $interrupt:ident),+;
        waking on $waking:ident; bus task on $serve:ident; control task on $control:ident
    ) => {
        embassy_stm32::bind_interrupts!(struct Lines {
            $waking => Waking;
            $serve => Serving;
            $control => Controlling;
        });

        static SERVE: embassy_executor::InterruptExecutor = embassy_executor::InterruptExecutor::new();
        static CONTROL: embassy_executor::InterruptExecutor = embassy_executor::InterruptExecutor::new();

        $(
            // The vector's own name, as `bind_interrupts!` would write it, but from RAM.
            #[allow(non_snake_case)]
            #[unsafe(no_mangle)]
            #[unsafe(link_section = ".fast")]
            unsafe extern "C" fn $interrupt() {
                use embassy_stm32::interrupt::typelevel::Interrupt;
                if $line.service(&$usart, $crate::cycles::now()) {
                    embassy_stm32::interrupt::typelevel::$waking::pend();
                }
            }
        )+

        struct Waking;
        impl embassy_stm32::interrupt::typelevel::Handler<embassy_stm32::interrupt::typelevel::$waking> for Waking {
            unsafe fn on_interrupt() {
                $($line.wake();)+
            }
        }

        struct Serving;
        impl embassy_stm32::interrupt::typelevel::Handler<embassy_stm32::interrupt::typelevel::$serve> for Serving {
            unsafe fn on_interrupt() {
                // SAFETY: this is its interrupt, which `above` lets through by starting it.
                unsafe { SERVE.on_interrupt() };
            }
        }

        struct Controlling;
        impl embassy_stm32::interrupt::typelevel::Handler<embassy_stm32::interrupt::typelevel::$control> for Controlling {
            unsafe fn on_interrupt() {
                // SAFETY: this is its interrupt, which `above` lets through by starting it.
                unsafe { CONTROL.on_interrupt() };
            }
        }

        /// Lets those of them through that a line's interrupt does not have started by itself.
        fn above() -> Above {
            use embassy_stm32::interrupt::{self, InterruptExt, typelevel::Interrupt};
            // SAFETY: `Waking` is its handler.
            unsafe { embassy_stm32::interrupt::typelevel::$waking::enable() };
            interrupt::$serve.set_priority($crate::critical::SERVE);
            interrupt::$control.set_priority($crate::critical::CONTROL);
            Above { serve: SERVE.start(interrupt::$serve), control: CONTROL.start(interrupt::$control) }
        }
    };
}
