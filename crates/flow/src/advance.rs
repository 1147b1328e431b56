//! Straight motion of several boxes.

use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Interval8, Kernel, Value};

/// `from + time * velocity` for every state, into `to`.
pub(crate) fn advance(
    from: &[Interval8],
    time: Interval,
    velocity: &[Interval8],
    to: &mut [Interval8],
) {
    Interval8::run(Advance {
        from,
        time,
        velocity,
        to,
    });
}

struct Advance<'a> {
    from: &'a [Interval8],
    time: Interval,
    velocity: &'a [Interval8],
    to: &'a mut [Interval8],
}

impl Kernel<Interval8> for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        for ((to, from), velocity) in self.to.iter_mut().zip(self.from).zip(self.velocity) {
            *to = A::add(from, &A::scale(velocity, self.time));
        }
    }
}
