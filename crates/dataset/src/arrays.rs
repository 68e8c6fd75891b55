//! Files of named arrays: safetensors, compressed by zstd, whose checksum tells a damaged one.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use ppnpack_files::write_whole;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use crate::error::DatasetError;

/// Maximum size of any file before compression, in bytes.
pub(crate) const MAX_BYTES: u64 = 1 << 30;

const LEVEL: i32 = 9;

/// Arrays to be written.
#[derive(Debug, Default)]
pub(crate) struct Arrays(Vec<(&'static str, Dtype, Vec<usize>, Vec<u8>)>);

impl Arrays {
    /// Adds an array by the little-endian bytes of its numbers.
    pub(crate) fn add<const N: usize>(
        &mut self,
        name: &'static str,
        kind: Dtype,
        shape: Vec<usize>,
        numbers: impl Iterator<Item = [u8; N]>,
    ) {
        self.0
            .push((name, kind, shape, numbers.flatten().collect()));
    }

    /// Gives the content of a file; or what is wrong with the arrays.
    pub(crate) fn packed(&self) -> Result<Vec<u8>, String> {
        let views = self.0.iter().map(|(name, kind, shape, data)| {
            let view = TensorView::new(*kind, shape.clone(), data);
            view.map(|view| (name, view))
        });
        let views = views.collect::<Result<Vec<_>, _>>();
        let content = views.and_then(|views| safetensors::serialize(views, None));
        let content = content.map_err(|error| error.to_string())?;
        if content.len() as u64 > MAX_BYTES {
            return Err(format!("it has more than {MAX_BYTES} bytes"));
        }
        let compress = || {
            let mut encoder = zstd::Encoder::new(Vec::new(), LEVEL)?;
            encoder.include_checksum(true)?;
            encoder.write_all(&content)?;
            encoder.finish()
        };
        compress().map_err(|error| error.to_string())
    }
}

/// Writes a file that does not have this content yet.
pub(crate) fn write_changed(path: &Path, content: &[u8]) -> Result<(), DatasetError> {
    if std::fs::read(path).is_ok_and(|found| found == content) {
        return Ok(());
    }
    Ok(write_whole(path, content)?)
}

/// Decompresses a file, which may have so many bytes, and reads it; what `read` says is wrong is
/// wrong with the file.
pub(crate) fn read<T>(
    path: &Path,
    most_bytes: u64,
    read: impl FnOnce(&SafeTensors<'_>) -> Result<T, String>,
) -> Result<T, DatasetError> {
    let file = File::open(path).map_err(|error| DatasetError::Read(path.to_owned(), error))?;
    let mut content = Vec::new();
    let decoder = zstd::Decoder::new(file);
    let unpacked = decoder.and_then(|decoder| {
        let mut bounded = decoder.take(most_bytes + 1);
        bounded.read_to_end(&mut content)
    });
    let checked = match unpacked {
        Ok(bytes) if bytes as u64 > most_bytes => {
            Err(format!("it has more than {most_bytes} bytes"))
        }
        Ok(_) => SafeTensors::deserialize(&content).map_err(|error| error.to_string()),
        Err(error) => Err(format!("it cannot be decompressed: {error}")),
    };
    let read = checked.and_then(|arrays| read(&arrays));
    read.map_err(|reason| DatasetError::Damaged(path.to_owned(), reason))
}

/// Gives the numbers of an array, made of their little-endian bytes; or what is wrong with it.
pub(crate) fn numbers<T, const N: usize>(
    arrays: &SafeTensors<'_>,
    name: &str,
    kind: Dtype,
    from_bytes: fn([u8; N]) -> T,
) -> Result<Vec<T>, String> {
    let array = arrays.tensor(name).map_err(|error| error.to_string())?;
    if array.dtype() != kind {
        return Err(format!("its {name} are {:?}, not {kind:?}", array.dtype()));
    }
    let (numbers, _) = array.data().as_chunks::<N>();
    Ok(numbers.iter().copied().map(from_bytes).collect())
}
