//! Files read within bounds.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::DatasetError;

/// Reads a file of at most `most` bytes.
pub(crate) fn read_bounded(path: &Path, most: u64) -> Result<Vec<u8>, DatasetError> {
    let mut content = Vec::new();
    let opened = File::open(path).map(|file| file.take(most.saturating_add(1)));
    let read = opened.and_then(|mut file| file.read_to_end(&mut content));
    let path = path.to_owned();
    match read {
        Err(source) => Err(DatasetError::Read { path, source }),
        Ok(_) if content.len() as u64 > most => {
            let reason = format!("it has more than {most} bytes");
            Err(DatasetError::Damaged { path, reason })
        }
        Ok(_) => Ok(content),
    }
}

/// Decompresses data of exactly `size` bytes; gives what is wrong. Memory grows with what there is, not the promise.
pub(crate) fn decompress(packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    let mut content = Vec::new();
    let decoder = zstd::Decoder::with_buffer(packed);
    let bounded = decoder.map(|decoder| decoder.take(size.saturating_add(1)));
    match bounded.and_then(|mut bounded| bounded.read_to_end(&mut content)) {
        Ok(_) if content.len() as u64 == size => Ok(content),
        Ok(_) => Err("a block does not have the size it names".to_owned()),
        Err(error) => Err(format!("a block cannot be decompressed: {error}")),
    }
}
