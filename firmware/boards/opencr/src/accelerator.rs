//! The flash's accelerator (ART), which caches and prefetches what is fetched by the interface beside the tightly coupled memory: the model's
//! code (`ACCELERATED` in memory.x). RM0385, section 3, FLASH_ACR.

use embassy_stm32::pac::FLASH;

/// Switches it on, with nothing of an earlier program in it. The flash's wait states are set before; that switches it off.
pub fn start() {
    FLASH.acr().modify(|w| w.set_arten(false));
    FLASH.acr().modify(|w| w.set_artrst(true));
    FLASH.acr().modify(|w| w.set_artrst(false));
    FLASH.acr().modify(|w| {
        w.set_arten(true);
        w.set_prften(true);
    });
}
