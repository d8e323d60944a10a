//! Which interrupt of a chip does what for the gripper.

/// The interrupts of a board's [`Line`](crate::Line)s and of its control task, and `control_executor`, which starts the latter.
///
/// ```ignore
/// stm32::interrupts! {
///     BUS by BUS_USART on USART2, LINK by LINK_USART on USART3;
///     // Two devices that nothing here uses.
///     waking on SPDIF_RX; control task on CEC
/// }
/// ```
///
/// A line's interrupt takes no lock (see [`critical`](crate::critical)) and runs from RAM (see [`fast`](crate::fast)); it has the second one wake whoever waits. The third
/// runs the control task. The board's crate depends on `embassy-executor` and `embassy-stm32`.
#[macro_export]
macro_rules! interrupts {
    ($($line:ident by $usart:ident on $interrupt:ident),+; waking on $waking:ident; control task on $control:ident) => {
        embassy_stm32::bind_interrupts!(struct Lines {
            $waking => Waking;
            $control => Controlling;
        });

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

        struct Controlling;
        impl embassy_stm32::interrupt::typelevel::Handler<embassy_stm32::interrupt::typelevel::$control> for Controlling {
            unsafe fn on_interrupt() {
                // SAFETY: this is its interrupt, which `control_executor` lets through by starting it.
                unsafe { CONTROL.on_interrupt() };
            }
        }

        /// Lets the two of them through that a line's interrupt does not have started by itself.
        fn control_executor() -> embassy_executor::SendSpawner {
            use embassy_stm32::interrupt::{self, InterruptExt, typelevel::Interrupt};
            // SAFETY: `Waking` is its handler.
            unsafe { embassy_stm32::interrupt::typelevel::$waking::enable() };
            interrupt::$control.set_priority($crate::critical::CONTROL);
            CONTROL.start(interrupt::$control)
        }
    };
}
