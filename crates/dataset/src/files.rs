//! Files written whole and read within bounds.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use crate::error::DatasetError;

/// The beginning of the names of files that are being written.
const UNFINISHED: &str = ".unfinished-";

/// Writes a file so that it has all of its content or does not change, also after a kill or a power cut.
pub(crate) fn write_whole(path: &Path, content: &[u8]) -> Result<(), DatasetError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let write = || -> std::io::Result<()> {
        let mut file = tempfile::Builder::new()
            .prefix(UNFINISHED)
            .tempfile_in(folder)?;
        file.write_all(content)?;
        readable_by_all(file.as_file())?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        File::open(folder)?.sync_all()
    };
    write().map_err(|source| DatasetError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Temporary files are private; datasets are not.
fn readable_by_all(file: &File) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    Ok(())
}

/// Removes what a killed process left half written. Only for the one process that writes into the folder.
pub(crate) fn remove_unfinished(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_string_lossy().starts_with(UNFINISHED) {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Reads a file of at most `most` bytes.
pub(crate) fn read_bounded(path: &Path, most: u64) -> Result<Vec<u8>, DatasetError> {
    let mut content = Vec::new();
    let read = |content: &mut Vec<u8>| {
        File::open(path)?
            .take(most.saturating_add(1))
            .read_to_end(content)
    };
    read(&mut content).map_err(|source| DatasetError::Read {
        path: path.to_owned(),
        source,
    })?;
    if content.len() as u64 > most {
        return Err(DatasetError::Damaged {
            path: path.to_owned(),
            reason: format!("it has more than {most} bytes"),
        });
    }
    Ok(content)
}

/// Decompresses data that must have exactly `size` bytes; gives what is wrong. Memory grows with what there is, not
/// with what is promised.
pub(crate) fn decompress(packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    let mut content = Vec::new();
    let read = zstd::Decoder::with_buffer(packed).and_then(|decoder| {
        decoder
            .take(size.saturating_add(1))
            .read_to_end(&mut content)
    });
    match read {
        Ok(_) if content.len() as u64 == size => Ok(content),
        Ok(_) => Err("a block does not have the size it names".to_owned()),
        Err(error) => Err(format!("a block cannot be decompressed: {error}")),
    }
}
