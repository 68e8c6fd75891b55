//! Files read within bounds.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::DatasetError;

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
