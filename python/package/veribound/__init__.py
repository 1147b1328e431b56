"""Proved parameter and state bounds for dynamic systems with switches.

You have a model of a machine with unknown parameters, friction and all, and a record of what it did. veribound
returns bounds on the parameters and states that are proved: if the model and the declared error bounds are right,
the true values lie inside, rounding included.

>>> import veribound as vb
>>> model = vb.Model.load("rig.toml")              # doctest: +SKIP
>>> result = model.observe(frame)                  # doctest: +SKIP
>>> result["alpha"]                                # doctest: +SKIP
Interval(-2.018379, -1.986301)

`observe` goes through a record once, sample by sample; `identify` takes whole records and answers from both sides;
`enclose` bounds all solutions without a record; `simulate` makes records; `Observer` follows a running machine.
"""

from ._errors import Error, Interrupted, Problem
from ._functions import (
    acos,
    acosh,
    asin,
    asinh,
    atan,
    atan2,
    atanh,
    cbrt,
    ceil,
    cos,
    cosh,
    deadzone,
    exp,
    floor,
    friction,
    if_else,
    ln,
    log2,
    log10,
    maximum,
    minimum,
    pi,
    sat,
    sign,
    sin,
    sinh,
    sqrt,
    table,
    tan,
    tanh,
    trunc,
)
from ._interval import Interval
from ._model import Model, ModelBuilder, Quantity
from ._observer import Observer, Step
from ._results import Enclosure, Identification, Observation, Simulation
from ._runs import enclose, identify, observe, simulate
from ._veribound import Condition, Symbol, __version__

__all__ = [
    "Condition",
    "Enclosure",
    "Error",
    "Identification",
    "Interrupted",
    "Interval",
    "Model",
    "ModelBuilder",
    "Observation",
    "Observer",
    "Problem",
    "Quantity",
    "Simulation",
    "Step",
    "Symbol",
    "__version__",
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "ceil",
    "cos",
    "cosh",
    "deadzone",
    "enclose",
    "exp",
    "floor",
    "friction",
    "identify",
    "if_else",
    "ln",
    "log10",
    "log2",
    "maximum",
    "minimum",
    "observe",
    "pi",
    "sat",
    "sign",
    "simulate",
    "sin",
    "sinh",
    "sqrt",
    "table",
    "tan",
    "tanh",
    "trunc",
]
