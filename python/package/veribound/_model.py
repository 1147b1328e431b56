"""Models, read and built."""

from __future__ import annotations

import os
from html import escape
from typing import Any, Iterable, Mapping, NamedTuple, Optional, Tuple, Union

from . import _runs, _veribound
from ._interval import Interval
from ._numbers import number, number_or_none, operand


class Quantity(NamedTuple):
    """A state, parameter, input, disturbance, output or signal of a model."""

    name: str
    """The user's name."""
    unit: str
    """The user's unit; empty where none is given."""
    bounds: Optional[Interval]
    """The prior of a parameter, the start interval of a state, the bounds of a disturbance; None of others."""


class Model:
    """The immutable mathematics of a system: states, inputs, parameters with priors, equations, outputs with errors.

    ``Model.load("rig.toml")`` reads a model file; `ModelBuilder` makes a model in Python. Both mean the same.
    """

    def __init__(self, model: "_veribound.Model") -> None:
        if not isinstance(model, _veribound.Model):
            raise TypeError("use Model.load(path), Model.from_toml(text) or a ModelBuilder")
        self._model = model

    @classmethod
    def load(cls, path: "Union[str, os.PathLike[str]]") -> "Model":
        """Reads a model file.

        Raises `Error` with all that is wrong with it, each with its line.
        """
        return cls(_veribound.Model.from_file(os.fspath(path)))

    @classmethod
    def from_toml(cls, text: str, name: str = "model.toml") -> "Model":
        """Reads the text of a model file; messages call it `name`."""
        return cls(_veribound.Model.from_text(name, text))

    @property
    def name(self) -> str:
        """The name that the model gives itself, else that of its file."""
        return self._model.name

    def to_toml(self) -> str:
        """The text of the model file."""
        return self._model.to_toml()

    def save(self, path: "Union[str, os.PathLike[str]]") -> None:
        """Writes the model file."""
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(self.to_toml())

    def check(self) -> str:
        """What was understood, whether the guards of the modes leave a gap, and how solutions will be enclosed."""
        return self._model.check()

    def _quantities(self, kind: str) -> "list[Quantity]":
        return [
            Quantity(entry["name"], entry["unit"], Interval(*entry["bounds"]) if entry["bounds"] else None)
            for entry in self._model.quantities(kind)
        ]

    @property
    def states(self) -> "list[Quantity]":
        """States, with their start intervals."""
        return self._quantities("states")

    @property
    def params(self) -> "list[Quantity]":
        """Unknown parameters, with their priors."""
        return self._quantities("params")

    @property
    def inputs(self) -> "list[Quantity]":
        """Inputs, which records have columns of."""
        return self._quantities("inputs")

    @property
    def disturbances(self) -> "list[Quantity]":
        """Disturbances, with their bounds."""
        return self._quantities("disturbances")

    @property
    def outputs(self) -> "list[Quantity]":
        """Measured outputs."""
        return self._quantities("outputs")

    @property
    def signals(self) -> "list[str]":
        """Names of the binary columns."""
        return [quantity.name for quantity in self._quantities("signals")]

    @property
    def modes(self) -> "list[str]":
        """Names of the modes."""
        return [quantity.name for quantity in self._quantities("modes")]

    # The functions of the package take the model first, as methods do.
    observe = _runs.observe
    identify = _runs.identify
    enclose = _runs.enclose
    simulate = _runs.simulate

    def __repr__(self) -> str:
        def counted(count: int, one: str) -> str:
            return f"{count} {one}" if count == 1 else f"{count} {one}s"

        parts = [
            counted(len(self.states), "state"),
            counted(len(self.params), "parameter"),
            counted(len(self.inputs), "input"),
            counted(len(self.outputs), "output"),
        ]
        return f"<veribound.Model {self.name!r}: {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.check().rstrip())}</pre>"

    def __reduce__(self) -> Any:
        return (_again, (self.to_toml(), self._model.source))


def _again(text: str, name: str) -> Model:
    return Model.from_toml(text, name)


#: What stands for a value of an equation: a symbol, or an exact number.
Value = Any

#: Two ends, or one number for both.
Ends = Any


def _ends(bounds: Ends) -> "Tuple[Value, Value]":
    if isinstance(bounds, (tuple, list)):
        if len(bounds) != 2:
            raise ValueError(f"{bounds!r} has {len(bounds)} entries; give a lower and an upper end")
        return operand(bounds[0]), operand(bounds[1])
    return operand(bounds), operand(bounds)


def _pairs(values: "Mapping[_veribound.Symbol, Value]") -> "list[Tuple[_veribound.Symbol, Value]]":
    return [(state, operand(value)) for state, value in values.items()]


class ModelBuilder:
    """A model under construction.

    Every method that declares a quantity gives its symbol back, for use in equations. Symbols know ``+ - * / **``,
    comparisons (which make conditions, joined by ``& | ~``) and the functions of this package: `sin`, `sqrt`,
    `friction`, `if_else` and others.

    Numbers are exact: ``0.1`` stands for a tenth, as it does in a model file; ``decimal.Decimal(0.1)`` stands for
    the number that the float holds.

    >>> import veribound as vb
    >>> rig = vb.ModelBuilder("decay")
    >>> x = rig.state("x", init=(0.9, 1.1), unit="m")
    >>> k = rig.param("k", 0, 2, unit="1/s")
    >>> rig.der(x, -k * x)
    >>> rig.output("x_m", x, error=0.01)
    >>> rig.build().params[0].bounds
    Interval(0.0, 2.0)
    """

    def __init__(self, name: str) -> None:
        self._builder = _veribound.Builder(name)

    def state(self, name: str, init: Ends, *, unit: Optional[str] = None, domain: Optional[Ends] = None) -> Any:
        """Declares a state with its start interval; `domain` is where the guards of modes must leave no gap."""
        return self._builder.state(name, unit, _ends(init), None if domain is None else _ends(domain))

    def input(
        self,
        name: str,
        *,
        unit: Optional[str] = None,
        error: Any = None,
        relative_error: Any = None,
        error_hold: Optional[str] = None,
        column: Optional[str] = None,
        domain: Optional[Ends] = None,
    ) -> Any:
        """Declares an input, a column of the record, with the largest error of a recorded value (in its unit, and as
        a share of it); without one it is exact. With `error_hold="sample"` the error is constant from each sample to
        the next, with `"level"` as long as the recorded value stays the same; else it is any function of time."""
        errors = (number_or_none(error), number_or_none(relative_error))
        domain = None if domain is None else _ends(domain)
        return self._builder.input(name, unit, errors, error_hold, column, domain)

    def disturbance(
        self, name: str, lower: Value, upper: Value, *, unit: Optional[str] = None, hold: bool = False
    ) -> Any:
        """Declares a disturbance: any function of time between the ends; with `hold` constant from sample to sample."""
        return self._builder.disturbance(name, (operand(lower), operand(upper)), unit, hold)

    def param(
        self, name: str, lower: Value, upper: Value, *, unit: Optional[str] = None, nominal: Any = None
    ) -> Any:
        """Declares an unknown parameter with its prior; `nominal` is only drawn."""
        return self._builder.param(name, (operand(lower), operand(upper)), unit, number_or_none(nominal))

    def fixed(self, name: str, value: Value, *, unit: Optional[str] = None) -> Any:
        """Declares a parameter whose value is known."""
        return self._builder.fixed(name, operand(value), unit)

    def define(self, name: str, value: Value) -> Any:
        """Gives a part of an equation a name; what is used often should have one."""
        return self._builder.define(name, operand(value))

    def der(self, state: Any, velocity: Value) -> None:
        """The time derivative of a state, for models without modes of their own."""
        self._builder.der(state, operand(velocity))

    def mode(self, name: str, when: Any, der: "Mapping[Any, Value]") -> None:
        """Declares a mode: where its condition holds (None: always), states move as `der` says."""
        self._builder.mode(name, when, _pairs(der))

    def jump(self, name: str, when: Any, sets: "Mapping[Any, Value]") -> None:
        """Declares a jump: where its condition holds, states take new values."""
        self._builder.jump(name, when, _pairs(sets))

    def output(
        self,
        name: str,
        value: Value,
        error: Any,
        *,
        relative_error: Any = None,
        outliers: "Optional[tuple[int, int]]" = None,
        unit: Optional[str] = None,
        column: Optional[str] = None,
    ) -> None:
        """Declares what is measured, with the largest error of a recorded value, in its unit and beside that as a
        share of it. With `outliers=(2, 100)` at most 2 of any 100 samples in a row are off by more."""
        errors = (number(error), number_or_none(relative_error))
        self._builder.output(name, operand(value), errors, outliers, unit, column)

    def signal(
        self, name: str, *, proves: "Iterable[Any]" = (), latency: Any = 0, column: Optional[str] = None
    ) -> None:
        """Declares a binary column; once it was true for `latency` seconds, the equalities in `proves` hold."""
        proves = [proves] if isinstance(proves, _veribound.Condition) else list(proves)
        self._builder.signal(name, proves, number(latency), column)

    def event(self, name: str, signal: str, *, resets: "Iterable[Any]", lasts: Any = 0) -> None:
        """Declares an event: after `signal` was true for `lasts` seconds, parameters may have new values."""
        resets = [resets] if isinstance(resets, _veribound.Symbol) else list(resets)
        self._builder.event(name, signal, number(lasts), resets)

    def to_toml(self) -> str:
        """The model file."""
        return self._builder.to_toml()

    def build(self) -> Model:
        """Reads the model; raises `Error` with all that is wrong with it, shown in the text of `to_toml`."""
        return Model(self._builder.build())
