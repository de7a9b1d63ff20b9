//! Consistent Overhead Byte Stuffing: bytes without zeros, so that a zero can end a frame.
//!
//! Each block is a code `n` and `n - 1` bytes that are not zero; a block of less than 255 stands for its bytes and one zero, except
//! the last of the frame. Source: Cheshire & Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Trans. Networking 7(2), 1999.
//! Our own because the crates' decoders index their buffer unchecked, and a linked image must hold no panic path.

use postcard::ser_flavors::Flavor;
use postcard::{Error, Result};

/// Bytes of a block at most, its code not counted.
const RUN_MAX: usize = 254;

/// Bytes that `plain` bytes become at most, with the zero that ends the frame.
pub(crate) const fn bound(plain: usize) -> usize {
    plain + plain / RUN_MAX + 2
}

/// Writes COBS into a slice, byte by byte; yields the length of the frame with its final zero.
pub(crate) struct CobsWriter<'a> {
    out: &'a mut [u8],
    /// Where the open block's code will stand.
    code_at: usize,
    /// Bytes in the open block.
    run: usize,
}

impl<'a> CobsWriter<'a> {
    pub(crate) fn new(out: &'a mut [u8]) -> Self {
        Self { out, code_at: 0, run: 0 }
    }

    fn put(&mut self, at: usize, byte: u8) -> Result<()> {
        *self.out.get_mut(at).ok_or(Error::SerializeBufferFull)? = byte;
        Ok(())
    }

    fn close_block(&mut self) -> Result<()> {
        // the run is at most RUN_MAX, so the code fits
        self.put(self.code_at, (self.run + 1) as u8)?;
        self.code_at += self.run + 1;
        self.run = 0;
        Ok(())
    }
}

impl Flavor for CobsWriter<'_> {
    type Output = usize;

    fn try_push(&mut self, byte: u8) -> Result<()> {
        if self.run == RUN_MAX {
            self.close_block()?;
        }
        if byte == 0 {
            return self.close_block();
        }
        self.put(self.code_at + 1 + self.run, byte)?;
        self.run += 1;
        Ok(())
    }

    fn finalize(mut self) -> Result<usize> {
        self.close_block()?;
        self.put(self.code_at, 0)?;
        Ok(self.code_at + 1)
    }
}

/// Decodes a frame (without its final zero) onto itself; yields the plain length, `None` where it is not COBS.
pub(crate) fn decode_in_place(frame: &mut [u8]) -> Option<usize> {
    let (mut read, mut write) = (0, 0);
    while let Some(&code) = frame.get(read) {
        let end = read + usize::from(code);
        if code == 0 || end > frame.len() {
            return None;
        }
        read += 1;
        while read < end {
            let byte = *frame.get(read)?;
            if byte == 0 {
                return None;
            }
            *frame.get_mut(write)? = byte;
            read += 1;
            write += 1;
        }
        if usize::from(code) <= RUN_MAX && read < frame.len() {
            *frame.get_mut(write)? = 0;
            write += 1;
        }
    }
    Some(write)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn encode(plain: &[u8]) -> Vec<u8> {
        let mut out = vec![0xAA; bound(plain.len())];
        let mut writer = CobsWriter::new(&mut out);
        for &byte in plain {
            writer.try_push(byte).unwrap();
        }
        let n = writer.finalize().unwrap();
        out.truncate(n);
        out
    }

    #[test]
    fn the_paper_s_examples() {
        let table: [(&[u8], &[u8]); 7] = [
            (&[], &[1, 0]),
            (&[0], &[1, 1, 0]),
            (&[0, 0], &[1, 1, 1, 0]),
            (&[0x11, 0x22, 0, 0x33], &[3, 0x11, 0x22, 2, 0x33, 0]),
            (&[0x11, 0x22, 0x33, 0x44], &[5, 0x11, 0x22, 0x33, 0x44, 0]),
            (&[0x11, 0, 0, 0], &[2, 0x11, 1, 1, 1, 0]),
            (&[0, 0x45], &[1, 2, 0x45, 0]),
        ];
        for (plain, coded) in table {
            assert_eq!(encode(plain), coded, "{plain:02x?}");
        }
    }

    #[test]
    fn every_length_round_trips_and_holds_no_inner_zero() {
        for n in 0..1100_usize {
            for zero_every in [usize::MAX, 1, 2, 253, 254, 255, 256] {
                let plain: Vec<u8> = (0..n).map(|i| if (i + 1) % zero_every == 0 { 0 } else { (i % 255 + 1) as u8 }).collect();
                let mut coded = encode(&plain);
                assert!(coded.len() <= bound(n));
                assert_eq!(coded.pop(), Some(0));
                assert!(!coded.contains(&0));
                let back = decode_in_place(&mut coded).unwrap();
                assert_eq!(coded[..back], plain, "length {n}, zeros every {zero_every}");
            }
        }
    }

    #[test]
    fn what_is_not_cobs_is_refused() {
        for bad in [&[0_u8][..], &[2], &[5, 1, 2], &[3, 1, 0], &[1, 0, 1]] {
            let mut frame = bad.to_vec();
            assert_eq!(decode_in_place(&mut frame), None, "{bad:?}");
        }
    }

    #[test]
    fn a_full_buffer_is_an_error_at_every_size() {
        let plain = [1, 0, 2, 3, 0, 0, 4];
        for size in 0..encode(&plain).len() {
            let mut out = vec![0; size];
            let mut writer = CobsWriter::new(&mut out);
            let done = plain.iter().try_for_each(|&b| writer.try_push(b)).and_then(|()| writer.finalize().map(|_| ()));
            assert_eq!(done, Err(Error::SerializeBufferFull), "size {size}");
        }
    }
}
