//! inari and MPFR behind a C interface: an oracle for the tests of `veribound-interval` and a rival in
//! its benchmark, loaded at run time, since inari compiles only for processors with FMA.
//!
//! A batch is prepared from structures of arrays, kept in inari's own layout, passed over as often as
//! wanted, and read back. The empty set is `[+inf, -inf]` on both sides of the interface.

mod operation;
mod tight;

use inari::Interval;
use operation::Operation;

/// Counts changes of this interface, so that an old library is not taken for a new one.
const INTERFACE: u32 = 1;

/// The lower and the upper ends of one argument.
#[repr(C)]
pub struct Column {
    lo: *const f64,
    hi: *const f64,
}

/// One operation with its arguments and results.
pub struct Batch {
    operation: Operation,
    arguments: Vec<Vec<Interval>>,
    results: Vec<Interval>,
}

/// The number of this interface.
#[unsafe(no_mangle)]
pub extern "C" fn peer_interface() -> u32 {
    INTERFACE
}

/// A batch of `count` cases of the operation with this name; null if there is none with this number of
/// arguments. Ends that are not those of an interval count as the empty set.
///
/// # Safety
/// `name` has to point to `length` bytes, `columns` to `arity` columns, and each column to `count` lower
/// and `count` upper ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_prepare(
    name: *const u8,
    length: usize,
    columns: *const Column,
    arity: usize,
    count: usize,
) -> *mut Batch {
    // SAFETY: promised by the caller.
    let name = unsafe { std::slice::from_raw_parts(name, length) };
    let Some(operation) = Operation::named(name).filter(|found| found.arity() == arity) else {
        return std::ptr::null_mut();
    };
    // SAFETY: promised by the caller.
    let columns = unsafe { std::slice::from_raw_parts(columns, arity) };
    let arguments = columns.iter().map(|column| {
        // SAFETY: promised by the caller.
        let ends = unsafe {
            (
                std::slice::from_raw_parts(column.lo, count),
                std::slice::from_raw_parts(column.hi, count),
            )
        };
        let ends = ends.0.iter().zip(ends.1);
        ends.map(|(&lo, &hi)| Interval::try_from((lo, hi)).unwrap_or(Interval::EMPTY))
            .collect()
    });
    Box::into_raw(Box::new(Batch {
        operation,
        arguments: arguments.collect(),
        results: vec![Interval::EMPTY; count],
    }))
}

/// Carries out the operation on all cases.
///
/// # Safety
/// `batch` has to come from [`peer_prepare`], and nobody else may use it at the same time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_pass(batch: *mut Batch) {
    // SAFETY: promised by the caller.
    let batch = unsafe { &mut *batch };
    batch.operation.pass(&batch.arguments, &mut batch.results);
}

/// Writes the ends of all results.
///
/// # Safety
/// `batch` as for [`peer_pass`]; `lo` and `hi` have to have room for the count of its cases.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_read(batch: *const Batch, lo: *mut f64, hi: *mut f64) {
    // SAFETY: promised by the caller.
    let (batch, lo, hi) = unsafe {
        let batch = &*batch;
        let count = batch.results.len();
        (
            batch,
            std::slice::from_raw_parts_mut(lo, count),
            std::slice::from_raw_parts_mut(hi, count),
        )
    };
    for ((result, lo), hi) in batch.results.iter().zip(lo).zip(hi) {
        (*lo, *hi) = (result.inf(), result.sup());
    }
}

/// Gives the memory of a batch back.
///
/// # Safety
/// `batch` has to come from [`peer_prepare`] and may not be used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_free(batch: *mut Batch) {
    // SAFETY: promised by the caller.
    drop(unsafe { Box::from_raw(batch) });
}
