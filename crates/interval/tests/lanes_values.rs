//! What eight lanes have besides operations: construction, choices, numbers and questions, each
//! against the one of [`Interval`]; and the product with one factor for all lanes.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use support::Source;
use veribound_interval::lanes::{Arithmetic, Kernel, LANES, Lanewise, Mask, Path, Value};
use veribound_interval::{Interval, Interval8};

/// Ends at which a question has another answer, and where sums overflow.
const ENDS: [f64; 12] = [
    f64::NEG_INFINITY,
    f64::MIN,
    -2.0,
    -1.0,
    -f64::MIN_POSITIVE,
    0.0,
    f64::MIN_POSITIVE,
    0.1,
    1.0,
    2.0,
    f64::MAX,
    f64::INFINITY,
];

fn grid() -> Vec<Interval> {
    let mut all = vec![Interval::EMPTY];
    for lo in ENDS {
        all.extend(ENDS.iter().filter_map(|&hi| Interval::new(lo, hi)));
    }
    all
}

/// Eight of the grid, ordinary ones only in every second case.
fn eight(source: &mut Source, grid: &[Interval]) -> Interval8 {
    let ordinary = source.below(2) == 0;
    Interval8::from_fn(|_| {
        if ordinary {
            let lo = source.between(-9.0, 9.0);
            Interval::new(lo, lo + source.unit()).unwrap()
        } else {
            grid[source.below(grid.len() as u64) as usize]
        }
    })
}

#[test]
fn numbers_of_lanes_are_those_of_intervals() {
    let (grid, mut source) = (grid(), Source(0x8a));
    for _ in 0..20_000 {
        let x = eight(&mut source, &grid);
        let (lo, hi, mid) = (x.lo(), x.hi(), x.mid());
        let (width, mag) = (x.width(), x.mag());
        for lane in 0..LANES {
            let one = x.get(lane);
            assert_eq!((lo[lane], hi[lane]), (one.lo(), one.hi()), "{one:?}");
            assert_eq!(mid[lane], one.mid(), "{x:?}");
            assert_eq!(width[lane], one.width(), "{one:?}");
            assert_eq!(mag[lane], one.mag(), "{one:?}");
        }
        let doubled = x.map(|x| x + x);
        assert_eq!(
            doubled,
            Interval8::from_fn(|lane| x.get(lane) + x.get(lane))
        );
    }
}

#[test]
fn questions_of_lanes_are_those_of_intervals() {
    let (grid, mut source) = (grid(), Source(0x8b));
    for _ in 0..20_000 {
        let (x, mut y) = (eight(&mut source, &grid), eight(&mut source, &grid));
        y.set(source.below(8) as usize, Interval::EMPTY);
        for lane in 0..LANES {
            let (a, b) = (x.get(lane), y.get(lane));
            let what = format!("{a:?} {b:?}");
            assert_eq!(x.is_empty().get(lane), a.is_empty(), "{what}");
            assert_eq!(x.is_bounded().get(lane), a.is_bounded(), "{what}");
            assert_eq!(x.contains_zero().get(lane), a.contains(0.0), "{what}");
            assert_eq!(x.is_subset_of(&y).get(lane), a.is_subset_of(b), "{what}");
            assert_eq!(
                x.is_interior_of(&y).get(lane),
                a.is_interior_of(b),
                "{what}"
            );
            assert_eq!(x.intersects(&y).get(lane), a.intersects(b), "{what}");
            assert_eq!(x.intersect(&y).get(lane), a.intersect(b), "{what}");
            assert_eq!(x.hull(&y).get(lane), a.hull(b), "{what}");
        }
    }
}

#[test]
fn lanes_are_built_as_intervals_are() {
    let mut source = Source(0x8c);
    let mut numbers = ENDS.to_vec();
    numbers.push(f64::NAN);
    for _ in 0..20_000 {
        let mut draw = |count: usize| -> [f64; LANES] {
            std::array::from_fn(|_| numbers[source.below(count as u64) as usize])
        };
        let (a, b) = (draw(numbers.len()), draw(numbers.len()));
        // Without the last two and the first: finite in all lanes.
        let finite = draw(numbers.len() - 2).map(|x| x.max(f64::MIN));
        let (point, between) = (Interval8::point(a), Interval8::between(a, b));
        let points = Interval8::point(finite);
        for lane in 0..LANES {
            assert_eq!(point.get(lane), Interval::point(a[lane]), "{a:?}");
            assert_eq!(points.get(lane), Interval::point(finite[lane]));
            let wanted = Interval::new(a[lane], b[lane]).unwrap_or(Interval::EMPTY);
            assert_eq!(between.get(lane), wanted, "{a:?} {b:?}");
        }
    }
}

/// Every mask: choices, sets of lanes, and the operators.
#[test]
fn masks_are_sets_of_lanes() {
    let (grid, mut source) = (grid(), Source(0x8d));
    for bits in 0..=u8::MAX {
        let mask = Mask::from_bits(bits);
        let other = Mask::from_bits(source.bits() as u8);
        let members: Vec<usize> = (0..LANES).filter(|lane| bits >> lane & 1 == 1).collect();
        assert_eq!(mask.lanes().collect::<Vec<usize>>(), members);
        assert_eq!(mask.bits(), bits);
        assert_eq!(mask.any(), !members.is_empty());
        assert_eq!(mask.none(), members.is_empty());
        assert_eq!(mask.all(), members.len() == LANES);
        assert_eq!(Mask::from_fn(|lane| mask.get(lane)), mask);
        let (mut met, mut joined) = (mask, mask);
        met &= other;
        joined |= other;
        let (x, y) = (eight(&mut source, &grid), eight(&mut source, &grid));
        let (chosen, mut assigned) = (x.or_else(mask, &y), y);
        assigned.assign(mask, &x);
        for lane in 0..LANES {
            let (a, b) = (members.contains(&lane), other.get(lane));
            assert_eq!(mask.get(lane), a);
            assert_eq!((!mask).get(lane), !a);
            assert_eq!((mask & other).get(lane), a && b);
            assert_eq!((mask | other).get(lane), a || b);
            assert_eq!((met.get(lane), joined.get(lane)), (a && b, a || b));
            assert_eq!(mask.without(other).get(lane), a && !b);
            let wanted = if a { x.get(lane) } else { y.get(lane) };
            assert_eq!(chosen.get(lane), wanted);
            assert_eq!(assigned.get(lane), wanted);
        }
    }
    for count in 0..=LANES {
        let first: Vec<usize> = Mask::first(count).lanes().collect();
        assert_eq!(first, (0..count).collect::<Vec<usize>>());
    }
    for lane in 0..LANES {
        assert_eq!(Mask::lane(lane).lanes().collect::<Vec<usize>>(), [lane]);
    }
    assert_eq!(<Mask as Lanewise>::splat(true), Mask::ALL);
    assert_eq!(<Mask as Lanewise>::splat(false), Mask::NONE);
    assert!(<bool as Lanewise>::splat(true) && !<bool as Lanewise>::splat(false));
    assert!(Lanewise::any(true) && Lanewise::all(true));
    assert!(!Lanewise::any(false) && !Lanewise::all(false));
}

/// What [`Arithmetic`] has beside the operations of [`Interval`], for eight lanes and for one.
struct Others<'a, V: Value>(&'a V, &'a V, Interval);

impl<V: Value> Kernel<V> for Others<'_, V> {
    type Output = ([V; 4], [V::Mask; 2]);

    #[inline(always)]
    fn run<A: Arithmetic<Value = V>>(self) -> Self::Output {
        let Others(a, b, factor) = self;
        (
            [
                A::scale(a, factor),
                A::map(a, Interval::recip),
                A::map2(a, b, |a, b| a - b),
                A::map3(a, b, a, Interval::fma),
            ],
            [
                A::test(a, Interval::is_bounded),
                A::test2(a, b, Interval::is_subset_of),
            ],
        )
    }
}

/// Factors of every sign and size for all lanes, on every path; and the scalar arithmetic.
#[test]
fn a_factor_for_all_lanes_and_functions_lane_by_lane() {
    let (grid, mut source) = (grid(), Source(0x8e));
    for case in 0..20_000 {
        let (mut x, y) = (eight(&mut source, &grid), eight(&mut source, &grid));
        if case % 4 == 0 {
            x = Interval8::from_fn(|_| {
                let (a, b) = source.floats();
                Interval::new(a.min(b), a.max(b)).unwrap()
            });
        }
        let factor = match case % 3 {
            0 => grid[source.below(grid.len() as u64) as usize],
            1 => Interval::point(source.float().abs()),
            _ => {
                let (a, b) = source.floats();
                Interval::new(a.abs().min(b.abs()), a.abs().max(b.abs())).unwrap()
            }
        };
        for path in Path::available() {
            let (sets, claims) = path.run(Others(&x, &y, factor)).unwrap();
            for lane in 0..LANES {
                let (a, b) = (x.get(lane), y.get(lane));
                let what = format!("{path:?} {x:?} {y:?} {factor:?}");
                assert_eq!(sets[0].get(lane), a * factor, "{what}");
                assert_eq!(sets[1].get(lane), a.recip(), "{what}");
                assert_eq!(sets[2].get(lane), a - b, "{what}");
                assert_eq!(sets[3].get(lane), a.fma(b, a), "{what}");
                assert_eq!(claims[0].get(lane), a.is_bounded(), "{what}");
                assert_eq!(claims[1].get(lane), a.is_subset_of(b), "{what}");
            }
        }
        let (a, b) = (x.get(case % LANES), y.get(case % LANES));
        let (sets, claims) = Interval::run(Others(&a, &b, factor));
        assert_eq!(sets, [a * factor, a.recip(), a - b, a.fma(b, a)]);
        assert_eq!(claims, [a.is_bounded(), a.is_subset_of(b)]);
    }
}
