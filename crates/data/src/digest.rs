//! SHA-256 of files, so that a run names exactly what it was made from.

use crate::failure;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use veribound_model::diagnostic::Diagnostic;

/// Passes bytes on and takes their digest.
#[derive(Debug)]
pub(crate) struct Digesting<R> {
    input: R,
    digest: Sha256,
}

impl<R: Read> Digesting<R> {
    pub(crate) fn new(input: R) -> Self {
        Digesting {
            input,
            digest: Sha256::new(),
        }
    }

    /// Digest of all bytes passed on so far, in hexadecimal digits.
    pub(crate) fn finish(self) -> String {
        hexadecimal(&self.digest.finalize())
    }
}

impl<R: Read> Read for Digesting<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.digest.update(buffer.get(..count).unwrap_or_default());
        Ok(count)
    }
}

/// SHA-256 of all bytes of a file, in hexadecimal digits: what `run.toml` has of every file that was
/// read.
///
/// *Errors*: `E0401` when the file cannot be read.
pub fn sha256_of_file(path: impl AsRef<Path>) -> Result<String, Diagnostic> {
    let path = path.as_ref();
    let refuse = |error| failure::unreadable(&path.display().to_string(), &error);
    let mut input = Digesting::new(File::open(path).map_err(refuse)?);
    io::copy(&mut input, &mut io::sink()).map_err(refuse)?;
    Ok(input.finish())
}

/// SHA-256 of a text, in hexadecimal digits.
pub(crate) fn sha256_of_text(text: &str) -> String {
    sha256_of_bytes(text.as_bytes())
}

/// SHA-256 of bytes, in hexadecimal digits.
pub fn sha256_of_bytes(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_the_published_one() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_of_text("abc"), expected);
        let mut input = Digesting::new(&b"abc"[..]);
        io::copy(&mut input, &mut io::sink()).unwrap();
        assert_eq!(input.finish(), expected);
    }
}
