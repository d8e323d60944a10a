//! What of QEMU's plugin interface is used. QEMU itself provides these functions when it loads the plugin.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// A plugin's number.
pub type Id = u64;

/// A block of instructions that was translated.
#[repr(C)]
pub struct Block {
    _private: [u8; 0],
}

/// An instruction of it.
#[repr(C)]
pub struct BlockInstruction {
    _private: [u8; 0],
}

/// A callback that reads no registers.
pub const NO_REGISTERS: c_int = 0;
/// Both kinds of access.
pub const READS_AND_WRITES: c_int = 3;

unsafe extern "C" {
    pub fn qemu_plugin_register_vcpu_tb_trans_cb(id: Id, callback: extern "C" fn(Id, *mut Block));
    pub fn qemu_plugin_register_atexit_cb(id: Id, callback: extern "C" fn(Id, *mut c_void), data: *mut c_void);
    pub fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    pub fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut BlockInstruction;
    pub fn qemu_plugin_insn_vaddr(instruction: *const BlockInstruction) -> u64;
    pub fn qemu_plugin_insn_size(instruction: *const BlockInstruction) -> usize;
    pub fn qemu_plugin_insn_disas(instruction: *const BlockInstruction) -> *mut c_char;
    pub fn qemu_plugin_register_vcpu_insn_exec_cb(
        instruction: *mut BlockInstruction,
        callback: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    pub fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut BlockInstruction,
        callback: extern "C" fn(c_uint, u32, u64, *mut c_void),
        flags: c_int,
        kinds: c_int,
        data: *mut c_void,
    );
    pub fn qemu_plugin_mem_is_store(what: u32) -> bool;
    pub fn g_free(memory: *mut c_void);
}
