//! A file read forward with its offset known.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

/// Octets asked from the system at once.
const BUFFER: usize = 256 * 1024;

#[derive(Debug)]
pub(crate) struct Source<R> {
    inner: BufReader<R>,
    pub(crate) offset: u64,
}

impl<R: Read + Seek> Source<R> {
    pub(crate) fn new(inner: R) -> Self {
        Self { inner: BufReader::with_capacity(BUFFER, inner), offset: 0 }
    }

    /// What comes next, without taking it: at most what is buffered, empty at the end.
    pub(crate) fn peek(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    /// Fills `into` as far as the file goes; gives how many octets came.
    pub(crate) fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut have = 0;
        while have < into.len() {
            match self.inner.read(&mut into[have..]) {
                Ok(0) => break,
                Ok(n) => have += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        self.offset += have as u64;
        Ok(have)
    }

    /// Appends `n` octets to `into` as far as the file goes. Memory grows with what is there, not
    /// with what a damaged length announces.
    pub(crate) fn read_more(&mut self, into: &mut Vec<u8>, n: usize) -> io::Result<usize> {
        let before = into.len();
        let mut limited = (&mut self.inner).take(n as u64);
        limited.read_to_end(into)?;
        let have = into.len() - before;
        self.offset += have as u64;
        Ok(have)
    }

    pub(crate) fn seek_to(&mut self, offset: u64) -> io::Result<()> {
        match i64::try_from(i128::from(offset) - i128::from(self.offset)) {
            Ok(by) => self.inner.seek_relative(by)?,
            Err(_) => {
                self.inner.seek(SeekFrom::Start(offset))?;
            }
        }
        self.offset = offset;
        Ok(())
    }

    /// Goes to the end; gives how many octets that passes over.
    pub(crate) fn skip_rest(&mut self) -> io::Result<u64> {
        let end = self.inner.seek(SeekFrom::End(0))?;
        let skipped = end.saturating_sub(self.offset);
        self.offset = end;
        Ok(skipped)
    }
}
