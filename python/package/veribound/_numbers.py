"""Numbers of Python as exact decimal text.

A float stands for its shortest decimal, ``repr(x)``: whoever writes ``0.1`` means a tenth, and a CSV file with
``0.1`` in it means the same. ``decimal.Decimal(0.1)`` stands for the number that the float holds, digit for digit.
"""

from __future__ import annotations

import decimal
import fractions
import numbers
from typing import Any

from . import _veribound


def number(x: Any) -> str:
    """The text of an exact decimal number."""
    if isinstance(x, str):
        return x
    if isinstance(x, bool):
        return str(int(x))
    if isinstance(x, decimal.Decimal):
        return str(x)
    if isinstance(x, numbers.Integral):
        return str(int(x))
    if isinstance(x, float):
        return repr(float(x))
    if isinstance(x, fractions.Fraction):
        return _of_fraction(x)
    if hasattr(x, "item") and hasattr(x, "dtype"):
        # NumPy's floats of other widths: the shortest decimal of their own width.
        return str(x) if x.dtype.kind == "f" else number(x.item())
    raise TypeError(f"{x!r} is no number; give an int, a float, a decimal.Decimal, or text as '0.1'")


def _of_fraction(x: fractions.Fraction) -> str:
    rest = x.denominator
    for factor in (2, 5):
        while rest % factor == 0:
            rest //= factor
    if rest != 1:
        raise TypeError(f"{x} has no finite decimal; give an expression as '1/3' where one is taken, or both ends")
    digits = len(str(x.denominator)) * 4
    with decimal.localcontext() as context:
        context.prec = max(digits + len(str(abs(x.numerator))), 28)
        context.traps[decimal.Inexact] = True
        return format(decimal.Decimal(x.numerator) / decimal.Decimal(x.denominator), "f")


def operand(x: Any) -> Any:
    """A symbol, or the text of a number, for use in an equation."""
    if isinstance(x, _veribound.Symbol):
        return x
    if isinstance(x, fractions.Fraction):
        return _veribound.call("ratio", [str(x.numerator), str(x.denominator)])
    if isinstance(x, _veribound.Condition):
        raise TypeError(f"`{x}` is a condition, not a value; use veribound.if_else({x}, yes, no)")
    return number(x)


def number_or_none(x: Any) -> Any:
    """The same; None stays None."""
    return None if x is None else number(x)
