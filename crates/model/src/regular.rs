//! How regular expressions are on boxes.

use veribound_interval::Regularity;
use veribound_interval::lanes::Lanewise;

/// How regular an expression is on a whole box: one truth value, or one for each of several boxes.
///
/// Example: [`Tape`](crate::Tape).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regular<M = bool> {
    undefined: M,
    jump: M,
    kink: M,
}

impl<M: Lanewise> Regular<M> {
    /// Infinitely often differentiable everywhere.
    #[inline(always)]
    pub fn smooth() -> Regular<M> {
        let none = M::splat(false);
        Regular {
            undefined: none,
            jump: none,
            kink: none,
        }
    }

    /// [`Regularity::Smooth`]
    #[inline(always)]
    pub fn is_smooth(self) -> M {
        !(self.undefined | self.jump | self.kink)
    }

    /// [`Regularity::Kink`] or better.
    #[inline(always)]
    pub fn is_continuous(self) -> M {
        !(self.undefined | self.jump)
    }

    /// [`Regularity::Jump`] or better.
    #[inline(always)]
    pub fn is_defined(self) -> M {
        !self.undefined
    }

    #[inline(always)]
    pub(crate) fn undefined(mask: M) -> Regular<M> {
        Regular {
            undefined: mask,
            ..Regular::smooth()
        }
    }

    #[inline(always)]
    pub(crate) fn jump(mask: M) -> Regular<M> {
        Regular {
            jump: mask,
            ..Regular::smooth()
        }
    }

    #[inline(always)]
    pub(crate) fn kink(mask: M) -> Regular<M> {
        Regular {
            kink: mask,
            ..Regular::smooth()
        }
    }

    /// Smooth in the lanes of the mask.
    #[inline(always)]
    pub(crate) fn unless(self, mask: M) -> Regular<M> {
        Regular {
            undefined: self.undefined & !mask,
            jump: self.jump & !mask,
            kink: self.kink & !mask,
        }
    }

    /// The less regular one.
    #[inline(always)]
    pub(crate) fn and(self, other: Regular<M>) -> Regular<M> {
        Regular {
            undefined: self.undefined | other.undefined,
            jump: self.jump | other.jump,
            kink: self.kink | other.kink,
        }
    }

    /// From the lanes of which `test` says that they are exactly so regular.
    #[inline(always)]
    pub(crate) fn by_lane(test: impl Fn(Regularity) -> M) -> Regular<M> {
        Regular {
            undefined: test(Regularity::Undefined),
            jump: test(Regularity::Jump),
            kink: test(Regularity::Kink),
        }
    }
}
