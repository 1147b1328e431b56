"""Bounds."""

from __future__ import annotations

from typing import NamedTuple

from . import _veribound


class Interval(NamedTuple):
    """Bounds of one quantity: every value that is possible lies between `lo` and `hi`, both included.

    The ends are the floats that were proved; what is printed is rounded outward from them.

    >>> Interval(0.1, 0.25).width
    0.15
    """

    lo: float
    """Lower bound, in the unit of the quantity."""
    hi: float
    """Upper bound, in the unit of the quantity."""

    @property
    def mid(self) -> float:
        """The middle."""
        return 0.5 * (self.lo + self.hi)

    @property
    def width(self) -> float:
        """The distance of the ends, in plain floating point."""
        return self.hi - self.lo

    @property
    def is_empty(self) -> bool:
        """True where nothing is left: the model is refuted."""
        return self.lo != self.lo

    def __contains__(self, value: object) -> bool:
        return self.lo <= value <= self.hi  # type: ignore[operator]

    def __str__(self) -> str:
        return _veribound.shown(self.lo, self.hi)

    def __repr__(self) -> str:
        return f"Interval({self.lo!r}, {self.hi!r})"
