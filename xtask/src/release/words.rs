//! What goes beside the command: shells' completions and manual pages, both made by the command itself.

use crate::command::output;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Shells, with the file's name under which each looks for completions.
const SHELLS: [(&str, &str); 5] =
    [("bash", "fre.bash"), ("elvish", "fre.elv"), ("fish", "fre.fish"), ("powershell", "_fre.ps1"), ("zsh", "_fre")];

/// Writes `completions/` and `man/man1/` into a folder.
pub fn write(program: &Path, folder: &Path) -> Result<()> {
    let completions = folder.join("completions");
    fs::create_dir(&completions).with_context(|| format!("cannot make {}", completions.display()))?;
    for (shell, name) in SHELLS {
        let text = output(Command::new(program).args(["completions", shell]))?;
        let file = completions.join(name);
        fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
    }
    output(Command::new(program).arg("man").arg("--out").arg(folder.join("man/man1")))?;
    Ok(())
}

/// That they are there, and are about this program.
pub fn check(folder: &Path) -> Result<()> {
    let mut files: Vec<_> = SHELLS.iter().map(|(_, name)| folder.join("completions").join(name)).collect();
    files.extend(["fre.1", "fre-solve.1", "fre-sweep-merge.1"].map(|page| folder.join("man/man1").join(page)));
    for file in files {
        let text = fs::read_to_string(&file).with_context(|| format!("{} is not in the archive", file.display()))?;
        ensure!(text.contains("fre") && text.lines().count() > 10, "{} is empty", file.display());
    }
    Ok(())
}
