//! Products of polynomials in time and in the unknowns, order by order.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers; orders stay below the stride"
)]

use super::monomials::Monomials;

/// Numbers in a vector.
pub(super) const LANES: usize = 4;

/// Vectors of the highest order, [`super::set::HIGHEST`].
const MOST_VECTORS: usize = 8;

/// Row `j` of the product of two registers, the second one backwards.
///
/// No product passes through more than `n = P (j + 1)` roundings, `P` the number of pairs of monomials:
/// besides the product itself, with `v` vectors per pair, there are at most `(P + 1) v / 2` sums of nonzero
/// numbers in a lane and its twin, and at most two sums of lanes for `j > 1` (one for `j = 1`, none for
/// `j = 0`), and `v <= (j + 4) / 4`; for `P = 1` there is no twin.
#[inline(always)]
pub(super) fn convolve_rows(
    monomials: &Monomials,
    a: &[f64],
    b: &[f64],
    (stride, j): (usize, usize),
    row: &mut [f64],
) {
    let a = a.as_chunks::<LANES>().0;
    let place = (stride / LANES, stride + LANES, stride - 1 - j);
    match j / LANES + 1 {
        1 => convolve_vectors::<1>(monomials, a, b, place, row),
        2 => convolve_vectors::<2>(monomials, a, b, place, row),
        3 => convolve_vectors::<3>(monomials, a, b, place, row),
        4 => convolve_vectors::<4>(monomials, a, b, place, row),
        5 => convolve_vectors::<5>(monomials, a, b, place, row),
        6 => convolve_vectors::<6>(monomials, a, b, place, row),
        7 => convolve_vectors::<7>(monomials, a, b, place, row),
        _ => convolve_vectors::<MOST_VECTORS>(monomials, a, b, place, row),
    }
}

/// [`convolve_rows`] in `V` vectors a pair; `width` vectors of `a` a monomial, `apart` numbers of `b`.
#[inline(always)]
fn convolve_vectors<const V: usize>(
    monomials: &Monomials,
    a: &[[f64; LANES]],
    b: &[f64],
    (width, apart, back): (usize, usize, usize),
    row: &mut [f64],
) {
    let (factors, place) = ((a, b), (width, apart, back));
    for (c, slot) in row.iter_mut().enumerate() {
        // Two sums at a time, since one addition has to wait for the other.
        let (mut sums, mut twins) = ([0.0; LANES], [0.0; LANES]);
        let (pairs, last) = monomials.factors(c).as_chunks::<2>();
        for [first, second] in pairs {
            add_pair::<V>(&mut sums, factors, place, *first);
            add_pair::<V>(&mut twins, factors, place, *second);
        }
        for pair in last {
            add_pair::<V>(&mut sums, factors, place, *pair);
        }
        for lane in 0..LANES {
            sums[lane] += twins[lane];
        }
        *slot = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }
}

/// Adds the products of one pair of monomials; no closure, which would be compiled without the instruction set.
#[inline(always)]
fn add_pair<const V: usize>(
    sums: &mut [f64; LANES],
    (a, b): (&[[f64; LANES]], &[f64]),
    (width, apart, back): (usize, usize, usize),
    (x, y): (u32, u32),
) {
    let left = a[x as usize * width..].first_chunk::<V>();
    let right = b[y as usize * apart + back..].as_chunks::<LANES>().0;
    if let (Some(left), Some(right)) = (left, right.first_chunk::<V>()) {
        for (l, r) in left.iter().zip(right) {
            for lane in 0..LANES {
                sums[lane] += l[lane] * r[lane];
            }
        }
    }
}

/// `Σ a_i b_(n-1-i)` in four partial sums, so that the compiler may use vectors; no term passes through
/// more than `n` roundings.
#[inline(always)]
pub(super) fn convolve(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let left = a.chunks_exact(4);
    let rest: f64 = left
        .remainder()
        .iter()
        .zip(b.iter().take(left.remainder().len()).rev())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in left.zip(b.rchunks_exact(4)) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += x[lane] * y[3 - lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
