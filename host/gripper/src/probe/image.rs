//! A firmware image: what goes into flash, and where its log is found.

use std::fs;
use std::path::{Path, PathBuf};

#[cfg(feature = "log")]
use fre_log::Log;
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};

use super::{Board, ProbeError};

/// An image.
pub struct Image {
    path: PathBuf,
    #[cfg(feature = "log")]
    bytes: Vec<u8>,
    pieces: Vec<Piece>,
    rtt: Option<u64>,
    label: Option<(String, String)>,
}

/// Bytes of an image and where they go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Address in flash.
    pub address: u64,
    /// What goes there.
    pub bytes: Vec<u8>,
}

impl Image {
    /// Reads an image for this board.
    ///
    /// # Errors
    /// No file; no ELF file for a 32-bit Arm processor, or one with nothing to load.
    pub fn read(path: &Path, board: &str) -> Result<Self, ProbeError> {
        let bytes = fs::read(path).map_err(|source| ProbeError::NoImage {
            path: path.to_owned(),
            board: board.to_owned(),
            source,
        })?;
        Self::parse(path, bytes)
    }

    /// Takes an image's bytes apart; the path is for messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(path: &Path, bytes: Vec<u8>) -> Result<Self, ProbeError> {
        let bad = |why: String| ProbeError::BadImage { path: path.to_owned(), why };
        let (pieces, rtt, label) = contents(&bytes).map_err(bad)?;
        Ok(Self {
            path: path.to_owned(),
            pieces,
            rtt,
            label,
            #[cfg(feature = "log")]
            bytes,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The words of its log.
    ///
    /// # Errors
    /// It does not log by defmt, or by another version of it.
    #[cfg(feature = "log")]
    pub fn log(&self) -> Result<Log, ProbeError> {
        Log::of(&self.bytes).map_err(|why| ProbeError::BadImage { path: self.path.clone(), why: why.to_string() })
    }

    /// What goes into flash, by rising addresses.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Address of the control block by which the log is read over RTT.
    pub fn rtt(&self) -> Option<u64> {
        self.rtt
    }

    /// The version of its program, as its label says.
    pub fn version(&self) -> Option<&str> {
        self.label.as_ref().map(|(_, version)| version.as_str())
    }

    /// That it is this board's, by its label, and that all of it belongs into the board's flash.
    ///
    /// # Errors
    /// It has no label or another board's, or a piece does not belong there.
    pub fn fits(&self, board: &Board) -> Result<(), ProbeError> {
        match &self.label {
            Some((name, _)) if name == board.name => {}
            Some((name, _)) => {
                return Err(ProbeError::OtherBoard { path: self.path.clone(), board: board.name, label: name.clone() });
            }
            None => {
                let why = "no label says which board it is for".to_owned();
                return Err(ProbeError::BadImage { path: self.path.clone(), why });
            }
        }
        let (start, end) = board.flash;
        let outside = |piece: &&Piece| piece.address < start || piece.address + piece.bytes.len() as u64 > end;
        match self.pieces.iter().find(outside) {
            None => Ok(()),
            Some(piece) => Err(ProbeError::WrongBoard {
                path: self.path.clone(),
                board: board.name,
                address: piece.address,
                bytes: piece.bytes.len() as u64,
                start,
                end,
            }),
        }
    }
}

/// Pieces, the log's address, the label.
type Contents = (Vec<Piece>, Option<u64>, Option<(String, String)>);

fn contents(bytes: &[u8]) -> Result<Contents, String> {
    let words = |error: object::Error| error.to_string();
    let header = FileHeader32::<Endianness>::parse(bytes).map_err(|error| format!("no 32-bit ELF file ({error})"))?;
    let endian = header.endian().map_err(words)?;
    if header.e_machine(endian) != object::elf::EM_ARM {
        return Err("it is for another processor than an Arm".to_owned());
    }
    let mut pieces = Vec::new();
    for segment in header.program_headers(endian, bytes).map_err(words)? {
        let data = segment.data(endian, bytes).map_err(|()| "it is cut off".to_owned())?;
        if segment.p_type(endian) == PT_LOAD && !data.is_empty() {
            pieces.push(Piece { address: u64::from(segment.p_paddr(endian)), bytes: data.to_vec() });
        }
    }
    if pieces.is_empty() {
        return Err("it has nothing to load".to_owned());
    }
    pieces.sort_by_key(|piece| piece.address);
    let file = object::File::parse(bytes).map_err(words)?;
    let rtt = file.symbols().find(|symbol| symbol.name() == Ok("_SEGGER_RTT")).map(|symbol| symbol.address());
    let section = file.section_by_name(fre_boards::SECTION).and_then(|section| section.data().ok());
    let label = section.and_then(fre_boards::Label::read);
    Ok((pieces, rtt, label.map(|(board, version)| (board.to_owned(), version.to_owned()))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file with these segments (physical address, bytes) for the OpenCR.
    fn elf(machine: u16, segments: &[(u32, &[u8])]) -> Vec<u8> {
        test_bus::elf(machine, segments, Some(("opencr", "0.2.0")))
    }

    const ARM: u16 = 40;

    #[test]
    fn what_goes_into_flash_is_found() {
        let image =
            Image::parse(Path::new("x"), elf(ARM, &[(0x0804_0100, b"code"), (0x0804_0000, b"vectors")])).unwrap();
        let pieces: Vec<_> = image.pieces().iter().map(|piece| (piece.address, piece.bytes.as_slice())).collect();
        assert_eq!(pieces, [(0x0804_0000, b"vectors".as_slice()), (0x0804_0100, b"code")]);
        assert_eq!((image.rtt(), image.version()), (None, Some("0.2.0")));
        assert!(image.fits(&Board::named("opencr").unwrap()).is_ok());
    }

    #[test]
    fn an_image_is_its_board_s_by_its_label_whatever_the_addresses() {
        let image = Image::parse(Path::new("x"), elf(ARM, &[(0x0804_0000, b"code")])).unwrap();
        let error = image.fits(&Board::named("nucleo-h743zi").unwrap()).unwrap_err().to_string();
        let right = "`cargo xtask firmware nucleo-h743zi` builds the right one";
        assert_eq!(error, format!("x is an image for opencr, not for nucleo-h743zi; {right}"));
        let bare = test_bus::elf(ARM, &[(0x0804_0000, b"code")], None);
        let image = Image::parse(Path::new("x"), bare).unwrap();
        let error = image.fits(&Board::named("opencr").unwrap()).unwrap_err().to_string();
        snapbox::assert_data_eq!(
            error,
            snapbox::str!["x is not an image for a board: no label says which board it is for"]
        );
    }

    #[test]
    fn an_opencr_keeps_its_boot_loader() {
        let opencr = Board::named("opencr").unwrap();
        let mut said = String::new();
        for (address, bytes) in [(0x0800_0000, 4), (0x0803_fffe, 4), (0x080f_fffe, 4)] {
            let image = Image::parse(Path::new("other"), elf(ARM, &[(address, &vec![0; bytes])])).unwrap();
            said += &format!("{}\n", image.fits(&opencr).unwrap_err());
        }
        snapbox::assert_data_eq!(
            said,
            snapbox::str![[r#"
other does not belong on opencr: it has 4 bytes at 0x08000000, and the board's flash for programs is 0x08040000 to 0x08100000; `cargo xtask firmware opencr` builds the right one
other does not belong on opencr: it has 4 bytes at 0x0803fffe, and the board's flash for programs is 0x08040000 to 0x08100000; `cargo xtask firmware opencr` builds the right one
other does not belong on opencr: it has 4 bytes at 0x080ffffe, and the board's flash for programs is 0x08040000 to 0x08100000; `cargo xtask firmware opencr` builds the right one

"#]]
        );
    }

    #[test]
    fn what_is_no_image_is_refused_with_the_reason() {
        let why = |bytes: Vec<u8>| Image::parse(Path::new("x.elf"), bytes).err().unwrap().to_string();
        let mut cut = test_bus::elf(ARM, &[(0x0800_0000, b"four")], None);
        cut.truncate(cut.len() - 1);
        let bad = [
            Vec::new(),
            b"not an ELF file, but long enough to hold the header of one, if it were".to_vec(),
            elf(62, &[(0, b"x")]),
            elf(ARM, &[]),
            cut,
        ];
        let mut said: String = bad.into_iter().map(|bytes| format!("{}\n", why(bytes))).collect();
        said += &Image::read(Path::new("/nowhere/gripper"), "opencr").err().unwrap().to_string();
        snapbox::assert_data_eq!(
            said,
            snapbox::str![[r#"
x.elf is not an image for a board: no 32-bit ELF file (Invalid ELF header size or alignment)
x.elf is not an image for a board: no 32-bit ELF file (Unsupported ELF header)
x.elf is not an image for a board: it is for another processor than an Arm
x.elf is not an image for a board: it has nothing to load
x.elf is not an image for a board: it is cut off
/nowhere/gripper cannot be read (No such file or directory (os error 2)); `cargo xtask firmware opencr` builds the image for opencr
"#]]
        );
    }
}
