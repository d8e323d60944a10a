//! A running board's memory, as QEMU's monitor (QMP) gives it.

use std::fs;
use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

/// How long the monitor may take to answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Reads so many bytes from an address on, by the monitor's socket; they pass through a file beside it.
pub(crate) fn read(monitor: &Path, first: u32, bytes: u32) -> io::Result<Vec<u8>> {
    let mut stream = UnixStream::connect(monitor)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut answers = BufReader::new(stream.try_clone()?).lines();
    let file = monitor.with_extension("memory");
    let save = format!(
        r#"{{"execute":"pmemsave","arguments":{{"val":{first},"size":{bytes},"filename":{:?}}}}}"#,
        file.to_string_lossy()
    );
    for command in [r#"{"execute":"qmp_capabilities"}"#, &save] {
        writeln!(stream, "{command}")?;
        loop {
            let answer = answers.next().ok_or(io::ErrorKind::UnexpectedEof)??;
            if answer.contains("\"error\"") {
                return Err(io::Error::other(answer));
            }
            // Greetings and events come between.
            if answer.contains("\"return\"") {
                break;
            }
        }
    }
    let memory = fs::read(&file)?;
    fs::remove_file(&file)?;
    Ok(memory)
}
