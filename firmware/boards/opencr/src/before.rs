//! What comes before everything: the boot loader's tick and its USB run on when it jumps here, and their handlers are gone.
//!
//! cortex-m-rt calls `__pre_init` before variables exist, so it is assembler: interrupts are masked (`stm32::critical` lets
//! them through again), the tick is stopped, all lines of the interrupt controller are disabled and forgotten.

core::arch::global_asm!(
    ".section .text.__pre_init, \"ax\"",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "cpsid i",
    // SysTick's control register.
    "ldr r0, =0xe000e010",
    "movs r1, #0",
    "str r1, [r0]",
    // NVIC: clear-enable and clear-pending registers, eight words each.
    "ldr r0, =0xe000e180",
    "ldr r2, =0xe000e280",
    "mvn r1, #0",
    "movs r3, #8",
    "1:",
    "str r1, [r0], #4",
    "str r1, [r2], #4",
    "subs r3, r3, #1",
    "bne 1b",
    // Interrupt control: forget a pending SysTick (bit 25) and PendSV (bit 27).
    "ldr r0, =0xe000ed04",
    "ldr r1, =0x0a000000",
    "str r1, [r0]",
    "bx lr",
    ".ltorg",
    ".size __pre_init, . - __pre_init",
);
