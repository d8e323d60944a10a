//! QEMU's plugin: hands executed instructions and data addresses to a [`fre_cycles::Meter`].
//!
//! `-plugin libcycles_plugin.so,image=ELF,clock=0xADDRESS,out=FILE,layouts=all|image[,BOARD=ELF…]`: the image that QEMU runs, the address whose reads
//! delimit windows, where the windows go (a line each; `FILE.summary` has the rest, written anew from time to time, because QEMU may
//! be ended at any moment), whether layouts are followed that no image has, and the images of the boards that are of interest.
//!
//! The declarations follow QEMU's plugin interface, version 2 (QEMU 9) and later, which QEMU documents under "TCG plugins".

mod qemu;

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use fre_cycles::Meter;

/// Windows between two writings of the summary.
const EVERY: u32 = 250;

struct State {
    meter: Meter,
    out: File,
    summary: PathBuf,
    windows: u32,
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

fn state() -> MutexGuard<'static, Option<State>> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The version of the interface that this plugin wants.
#[unsafe(no_mangle)]
#[allow(non_upper_case_globals)]
pub static qemu_plugin_version: c_int = 2;

fn open(arguments: &[String]) -> Result<State, String> {
    let named = |name: &str| {
        let found = arguments.iter().find_map(|argument| argument.strip_prefix(name)?.strip_prefix('='));
        found.ok_or_else(|| format!("`{name}=` is missing"))
    };
    let read = |path: &str| std::fs::read(path).map_err(|error| format!("{path}: {error}"));
    let image = read(named("image")?)?;
    let clock = named("clock")?;
    let clock = clock.strip_prefix("0x").and_then(|digits| u32::from_str_radix(digits, 16).ok());
    let clock = clock.ok_or("`clock` is an address such as 0x40002004")?;
    let out = PathBuf::from(named("out")?);
    let all = match named("layouts")? {
        "all" => true,
        "image" => false,
        other => return Err(format!("`layouts` is `all` or `image`, not `{other}`")),
    };
    let mut boards = Vec::new();
    for argument in arguments {
        if let Some((board, elf)) =
            argument.split_once('=').filter(|(name, _)| !["image", "clock", "out", "layouts"].contains(name))
        {
            boards.push((board.to_owned(), read(elf)?));
        }
    }
    let meter = Meter::new(&image, &boards, clock, all).map_err(|error| error.to_string())?;
    let mut summary = out.clone().into_os_string();
    summary.push(".summary");
    let file = File::create(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    Ok(State { meter, out: file, summary: summary.into(), windows: 0 })
}

/// QEMU loads the plugin. Anything but 0 ends QEMU.
///
/// # Safety
/// QEMU calls this with `count` strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: qemu::Id,
    _info: *const c_void,
    count: c_int,
    strings: *const *const c_char,
) -> c_int {
    let count = usize::try_from(count).unwrap_or(0);
    // SAFETY: QEMU gives `count` pointers, each to a string that ends with a zero.
    let arguments: Vec<String> =
        (0..count).map(|index| unsafe { CStr::from_ptr(*strings.add(index)) }.to_string_lossy().into_owned()).collect();
    match open(&arguments) {
        Ok(opened) => *state() = Some(opened),
        Err(error) => {
            eprintln!("cycles-plugin: {error}");
            return 1;
        }
    }
    // SAFETY: the functions have the types that QEMU expects.
    unsafe {
        qemu::qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
        qemu::qemu_plugin_register_atexit_cb(id, at_end, std::ptr::null_mut());
    }
    0
}

extern "C" fn translated(_id: qemu::Id, block: *mut qemu::Block) {
    let mut state = state();
    let Some(State { meter, .. }) = state.as_mut() else { return };
    // SAFETY: the block, and the instructions that QEMU names in it, are valid during this call; the text is QEMU's until it is freed.
    unsafe {
        for index in 0..qemu::qemu_plugin_tb_n_insns(block) {
            let instruction = qemu::qemu_plugin_tb_get_insn(block, index);
            let text = qemu::qemu_plugin_insn_disas(instruction);
            let words = if text.is_null() { "?".into() } else { CStr::from_ptr(text).to_string_lossy() };
            let address = qemu::qemu_plugin_insn_vaddr(instruction) as u32;
            let number = meter.translate(address, qemu::qemu_plugin_insn_size(instruction) as u32, &words);
            drop(words);
            qemu::g_free(text.cast());
            let number = number as *mut c_void;
            qemu::qemu_plugin_register_vcpu_insn_exec_cb(instruction, executed, qemu::NO_REGISTERS, number);
            qemu::qemu_plugin_register_vcpu_mem_cb(
                instruction,
                accessed,
                qemu::NO_REGISTERS,
                qemu::READS_AND_WRITES,
                number,
            );
        }
    }
}

extern "C" fn executed(_processor: c_uint, number: *mut c_void) {
    let mut state = state();
    let Some(State { meter, out, summary, windows }) = state.as_mut() else { return };
    meter.execute(number as usize);
    let lines = meter.lines();
    if lines.is_empty() {
        return;
    }
    // A file that cannot be written is missed by whoever reads it.
    let _ = out.write_all(lines.as_bytes());
    if windows.is_multiple_of(EVERY) {
        let _ = std::fs::write(summary, meter.summary());
    }
    *windows += 1;
}

extern "C" fn accessed(_processor: c_uint, what: u32, address: u64, _number: *mut c_void) {
    if let Some(State { meter, .. }) = state().as_mut() {
        // SAFETY: QEMU's own word about this access.
        let write = unsafe { qemu::qemu_plugin_mem_is_store(what) };
        meter.access(address as u32, write);
    }
}

extern "C" fn at_end(_id: qemu::Id, _nothing: *mut c_void) {
    if let Some(State { meter, summary, .. }) = state().as_mut() {
        let _ = std::fs::write(summary, meter.summary());
    }
}
