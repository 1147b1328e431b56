//! Columns of numbers as one text: floats bit by bit, compressed.
//!
//! The bytes of a column of floats are turned around, first bytes first, so that what they share stands side by side
//! and compresses well.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// Columns in the order in which they were added; the page reads them in the same order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns(Vec<u8>);

impl Columns {
    /// Adds floats, little end first.
    pub fn floats(&mut self, column: impl Iterator<Item = f64> + Clone) {
        for byte in 0..8 {
            let bytes = column.clone().map(|x| x.to_le_bytes());
            self.0.extend(bytes.filter_map(|x| x.get(byte).copied()));
        }
    }

    /// Adds small numbers.
    pub fn bytes(&mut self, column: impl Iterator<Item = u8>) {
        self.0.extend(column);
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All columns, compressed (gzip), in base64.
    pub fn packed(&self) -> String {
        let mut packed = GzEncoder::new(Vec::new(), Compression::default());
        // Writing to memory does not fail; an empty text is shown as plots that cannot be read.
        let written = packed.write_all(&self.0).and_then(|()| packed.finish());
        written.map_or_else(|_| String::new(), |bytes| STANDARD.encode(bytes))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use flate2::read::GzDecoder;
    use std::io::Read;

    /// The bytes of a packed text.
    pub fn unpacked(text: &str) -> Vec<u8> {
        let packed = STANDARD.decode(text).unwrap();
        let mut bytes = Vec::new();
        GzDecoder::new(packed.as_slice())
            .read_to_end(&mut bytes)
            .unwrap();
        bytes
    }

    /// The next column of floats.
    pub fn floats(bytes: &[u8], from: &mut usize, count: usize) -> Vec<f64> {
        let part = &bytes[*from..*from + 8 * count];
        *from += 8 * count;
        let number = |k: usize| f64::from_le_bytes(std::array::from_fn(|b| part[b * count + k]));
        (0..count).map(number).collect()
    }

    #[test]
    fn floats_come_back_bit_by_bit() {
        let numbers = [0.1, -0.0, f64::INFINITY, f64::NAN, 1e-310, 8001.0];
        let mut columns = Columns::default();
        columns.floats(numbers.iter().copied());
        columns.bytes([1, 2, 3].into_iter());
        columns.floats([7.5].into_iter());
        let bytes = unpacked(&columns.packed());
        let mut from = 0;
        let back = floats(&bytes, &mut from, numbers.len());
        assert!(
            back.iter()
                .zip(numbers)
                .all(|(a, b)| a.to_bits() == b.to_bits())
        );
        assert_eq!(bytes[from..from + 3], [1, 2, 3]);
        from += 3;
        assert_eq!(floats(&bytes, &mut from, 1), [7.5]);
    }
}
