//! LZF, the compression of binary_compressed PCD files: runs of plain bytes, and copies of what
//! came before.

/// Gives the bytes that `packed` stands for; `None` where they are damaged or not `length`.
pub(super) fn unpack(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut unpacked: Vec<u8> = Vec::new();
    let mut rest = packed;
    while let Some((control, after)) = rest.split_first() {
        let control = usize::from(*control);
        rest = after;
        if control < 32 {
            let (plain, after) = rest.split_at_checked(control + 1)?;
            unpacked.extend_from_slice(plain);
            rest = after;
        } else {
            let mut count = control >> 5;
            if count == 7 {
                let (more, after) = rest.split_first()?;
                count += usize::from(*more);
                rest = after;
            }
            let (low, after) = rest.split_first()?;
            rest = after;
            let back = ((control & 31) << 8) + usize::from(*low) + 1;
            copy(&mut unpacked, back, count + 2)?;
        }
        if unpacked.len() > length {
            return None;
        }
    }
    (unpacked.len() == length).then_some(unpacked)
}

/// Appends `count` bytes from `back` bytes before the end. What is copied may itself be part of the
/// copy.
fn copy(unpacked: &mut Vec<u8>, back: usize, count: usize) -> Option<()> {
    let from = unpacked.len().checked_sub(back)?;
    for index in from..from + count {
        let byte = *unpacked.get(index)?;
        unpacked.push(byte);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_copies_are_unpacked() {
        // "abc", then 6 bytes from 3 back, then 1 plain byte.
        let packed = [2, b'a', b'b', b'c', 4 << 5, 2, 0, b'!'];
        assert_eq!(unpack(&packed, 10).unwrap(), b"abcabcabc!");
        // A long copy: 7 and 200 more, and 2.
        let packed = [0, b'z', 7 << 5, 200, 0];
        assert_eq!(unpack(&packed, 210).unwrap(), vec![b'z'; 210]);
        assert_eq!(unpack(&[], 0).unwrap(), b"");
    }

    #[test]
    fn damaged_data_is_refused() {
        for (packed, length) in [
            (&[2, b'a'][..], 3),
            (&[0, b'a', 1 << 5], 4),
            (&[0, b'a', 7 << 5, 0], 12),
            (&[0, b'a', 1 << 5, 1], 4),
            (&[0, b'a'], 2),
            (&[1, b'a', b'b'], 1),
        ] {
            assert_eq!(unpack(packed, length), None, "{packed:?}");
        }
    }
}
