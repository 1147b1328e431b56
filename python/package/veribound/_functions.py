"""Functions of symbols; what each means stands in the documentation of the model file."""

from __future__ import annotations

from typing import Any

from . import _veribound
from ._numbers import operand


def _function(name: str, what: str) -> Any:
    def function(*arguments: Any) -> Any:
        return _veribound.call(name, [operand(argument) for argument in arguments])

    function.__name__ = function.__qualname__ = name
    function.__doc__ = what
    return function


sqrt = _function("sqrt", "Square root.")
exp = _function("exp", "The exponential function.")
ln = _function("ln", "The natural logarithm.")
log2 = _function("log2", "The logarithm to the base 2.")
log10 = _function("log10", "The logarithm to the base 10.")
sin = _function("sin", "The sine of an angle in radian.")
cos = _function("cos", "The cosine of an angle in radian.")
tan = _function("tan", "The tangent of an angle in radian.")
asin = _function("asin", "The arc sine, in radian.")
acos = _function("acos", "The arc cosine, in radian.")
atan = _function("atan", "The arc tangent, in radian.")
atan2 = _function("atan2", "The angle of the point (x, y), given as atan2(y, x), in radian.")
sinh = _function("sinh", "The hyperbolic sine.")
cosh = _function("cosh", "The hyperbolic cosine.")
tanh = _function("tanh", "The hyperbolic tangent.")
asinh = _function("asinh", "The inverse of the hyperbolic sine.")
acosh = _function("acosh", "The inverse of the hyperbolic cosine.")
atanh = _function("atanh", "The inverse of the hyperbolic tangent.")
cbrt = _function("cbrt", "The cube root, of negative numbers too.")
floor = _function("floor", "The next whole number below.")
ceil = _function("ceil", "The next whole number above.")
trunc = _function("trunc", "The next whole number towards zero.")
sign = _function("sign", "1 where the value is positive, -1 where it is negative, everything between at 0.")
minimum = _function("minimum", "The smaller of two values.")
maximum = _function("maximum", "The larger of two values.")
sat = _function("sat", "sat(x, lower, upper): the value, cut off at the limits.")
deadzone = _function("deadzone", "deadzone(x, lower, upper): 0 between the limits, beyond them the distance to them.")
friction = _function(
    "friction",
    "friction(velocity, drive, level): dry friction of a level at a velocity under a drive, a force to subtract from\n"
    "the drive; friction(velocity, drive, sliding, holding) sticks up to `holding`. Three modes.",
)


def table(x: Any, points: Any) -> Any:
    """Straight lines between points ``[(x, y), ...]``, constant before the first and after the last; two points one
    above the other are a jump."""
    ends = [operand(end) for point in points for end in point]
    return _veribound.call("table", [operand(x), *ends])


def if_else(condition: Any, yes: Any, no: Any) -> Any:
    """`yes` where the condition holds, else `no`: two modes; on the border both are possible."""
    return _veribound.choose(condition, operand(yes), operand(no))


pi = _veribound.call("pi", [])
"""The circle constant."""
