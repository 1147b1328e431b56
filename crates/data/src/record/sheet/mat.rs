//! MATLAB MAT files of version 5 to 7: elements of a type and a length, one in another, perhaps compressed.
//!
//! After "MAT-File Format", The MathWorks. The crates that read it (matfile 0.5, matrw 0.1) panic on damaged files.

use super::{Column, Values, WIDEST, columns_of};
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Classes of arrays: structures, and the range of those of numbers.
const STRUCTURE: u8 = 2;
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;

/// Mark of complex numbers.
const COMPLEX: u32 = 0x0800;

/// Structures in structures are followed so far.
const DEEPEST: usize = 8;

/// No element is longer than this when it is not compressed any more.
const LONGEST: u64 = 1 << 31;

/// The real vectors and matrices of the file; those of a structure `s` are called `s.x`. What is complex, or of more
/// than two dimensions, is passed over.
pub(super) fn columns(bytes: &[u8]) -> Result<Vec<Column>, String> {
    let order = match bytes.get(126..128) {
        Some(b"IM") => Order::Little,
        Some(b"MI") => Order::Big,
        _ => return Err("its head is cut off".to_owned()),
    };
    let mut rest = Part {
        bytes: bytes.get(128..).unwrap_or_default(),
        order,
    };
    let mut columns = Vec::new();
    while !rest.bytes.is_empty() {
        let (kind, part) = rest.element().ok_or_else(cut_off)?;
        let unpacked;
        let (kind, part) = if kind == COMPRESSED {
            let mut all = Vec::new();
            let packed = ZlibDecoder::new(part.bytes)
                .take(LONGEST)
                .read_to_end(&mut all);
            packed.map_err(|error| format!("a part of it cannot be decompressed ({error})"))?;
            unpacked = all;
            let mut whole = Part {
                bytes: &unpacked,
                order,
            };
            whole.element().ok_or_else(cut_off)?
        } else {
            (kind, part)
        };
        if kind == MATRIX {
            array(part, None, 0, &mut columns).ok_or_else(cut_off)?;
        }
    }
    Ok(columns)
}

fn cut_off() -> String {
    "it is cut off or damaged".to_owned()
}

#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

/// Bytes that are still to be read.
#[derive(Clone, Copy)]
struct Part<'b> {
    bytes: &'b [u8],
    order: Order,
}

impl<'b> Part<'b> {
    fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    fn word(&mut self) -> Option<u32> {
        let bytes = self.take(4)?.try_into().ok()?;
        Some(match self.order {
            Order::Little => u32::from_le_bytes(bytes),
            Order::Big => u32::from_be_bytes(bytes),
        })
    }

    /// The next element: its type, and what is in it.
    fn element(&mut self) -> Option<(u32, Part<'b>)> {
        let first = self.word()?;
        let (kind, length, size) = match first >> 16 {
            0 => {
                let length = self.word()? as usize;
                // All but compressed ones fill eight bytes; the last of a file may not.
                let size = if first == COMPRESSED {
                    length
                } else {
                    length.checked_next_multiple_of(8)?.min(self.bytes.len())
                };
                (first, length, size)
            }
            // Short ones stand in the word behind type and length.
            length => (first & 0xffff, length as usize, 4),
        };
        let bytes = self.take(size)?.get(..length)?;
        Some((
            kind,
            Part {
                bytes,
                order: self.order,
            },
        ))
    }

    /// Signed words.
    fn words(mut self) -> Option<Vec<i64>> {
        let mut all = Vec::new();
        while !self.bytes.is_empty() {
            all.push(i64::from(self.word()?.cast_signed()));
        }
        Some(all)
    }

    /// Numbers that are stored as a type says.
    fn numbers(self, kind: u32) -> Option<Values> {
        macro_rules! list {
            ($number:ty, $into:ty) => {{
                let parts = self.bytes.chunks_exact(size_of::<$number>());
                let numbers = parts.filter_map(|part| {
                    let bytes = part.try_into().ok()?;
                    Some(<$into>::from(match self.order {
                        Order::Little => <$number>::from_le_bytes(bytes),
                        Order::Big => <$number>::from_be_bytes(bytes),
                    }))
                });
                numbers.collect()
            }};
        }
        Some(match kind {
            1 => Values::Whole(list!(i8, i64)),
            2 => Values::Whole(list!(u8, i64)),
            3 => Values::Whole(list!(i16, i64)),
            4 => Values::Whole(list!(u16, i64)),
            5 => Values::Whole(list!(i32, i64)),
            6 => Values::Whole(list!(u32, i64)),
            7 => Values::Floats(list!(f32, f64)),
            9 => Values::Floats(list!(f64, f64)),
            12 => Values::Whole(list!(i64, i64)),
            13 => Values::Large(list!(u64, u64)),
            _ => return None,
        })
    }
}

/// The columns of an array; `None` where it is damaged.
fn array(
    mut part: Part<'_>,
    within: Option<&str>,
    depth: usize,
    columns: &mut Vec<Column>,
) -> Option<()> {
    if part.bytes.is_empty() {
        // An empty field of a structure.
        return Some(());
    }
    let flags = part.element()?.1.word()?;
    let class = flags.to_le_bytes()[0];
    let size = part.element()?.1.words()?;
    let own = String::from_utf8_lossy(part.element()?.1.bytes).into_owned();
    let name = match within {
        None => own,
        Some(outer) => outer.to_owned(),
    };
    let [rows, width] = *size.as_slice() else {
        return Some(());
    };
    if class == STRUCTURE && (rows, width) == (1, 1) && depth < DEEPEST {
        let length = part.element()?.1.words()?.first().copied()?;
        let length = usize::try_from(length).ok().filter(|length| *length > 0)?;
        let names = part.element()?.1.bytes.chunks(length);
        for field in names {
            let (kind, inner) = part.element()?;
            let field = field.split(|byte| *byte == 0).next().unwrap_or_default();
            let name = format!("{name}.{}", String::from_utf8_lossy(field));
            if kind == MATRIX {
                array(inner, Some(&name), depth + 1, columns)?;
            }
        }
    } else if NUMBERS.contains(&class) && flags & COMPLEX == 0 {
        let (kind, numbers) = part.element()?;
        let values = numbers.numbers(kind)?;
        let (rows, width) = (usize::try_from(rows).ok()?, usize::try_from(width).ok()?);
        if rows.checked_mul(width)? != values.len() {
            return None;
        }
        // A row vector is a column, too.
        let width = if rows == 1 { 1 } else { width };
        if (1..=WIDEST).contains(&width) {
            columns.extend(columns_of(&name, width, values));
        }
    }
    Some(())
}
