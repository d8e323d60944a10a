//! Where things are in the repository.

use std::path::PathBuf;

/// The repository's root.
pub fn root() -> PathBuf {
    // Cargo tells the running program where the manifest is now; the compiled-in path serves a copied binary.
    let manifest =
        std::env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    manifest.parent().map(PathBuf::from).unwrap_or(manifest)
}

/// The boards' workspace, which is built for another target.
pub fn boards() -> PathBuf {
    root().join("firmware/boards")
}

/// Everything that is built or fetched.
pub fn target() -> PathBuf {
    root().join("target")
}

/// Target folder of the boards' workspace.
pub fn boards_target() -> PathBuf {
    target().join("boards")
}
