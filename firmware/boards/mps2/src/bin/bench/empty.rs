//! The board without a model: what the others' flash is counted from.

#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    let _board = mps2::init();
    defmt::println!("end");
    mps2::exit(mps2::Exit::Success)
}
