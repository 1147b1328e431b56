"""The observer for data that arrive while the machine runs."""

from __future__ import annotations

from html import escape
from typing import Any, Mapping, Optional, Sequence, Union

from . import _runs, _veribound, _words
from ._interval import Interval


class Step:
    """What is known after one sample. `verdict` is a value, not an exception:

    - ``"consistent"``: every solution that agrees with all samples so far lies in the bounds;
    - ``"inconsistent"``: proved, that none does; the observer is at its end;
    - ``"undecided"``: nothing could be proved about this sample; the bounds of the one before hold.
    """

    __slots__ = ("_step",)

    def __init__(self, step: "_veribound.Step") -> None:
        self._step = step

    @property
    def t(self) -> float:
        """Time of the sample, in seconds."""
        return self._step.t

    @property
    def nanoseconds(self) -> int:
        """What the step took in Rust; compare it with the time between two samples."""
        return self._step.nanoseconds

    @property
    def verdict(self) -> str:
        """``"consistent"``, ``"inconsistent"`` or ``"undecided"``."""
        return self._step.verdict

    @property
    def message(self) -> Optional[str]:
        """Why it is not consistent; None where it is."""
        return self._step.message

    @property
    def boxes(self) -> int:
        """Number of boxes in the list."""
        return self._step.boxes

    @property
    def modes(self) -> "list[str]":
        """Modes that are possible now, or were at some time since the sample before."""
        return self._step.modes

    @property
    def resets(self) -> "list[str]":
        """Parameters that may have taken a new value at this sample."""
        return self._step.resets

    def __getitem__(self, name: str) -> Interval:
        """Bounds of a parameter, state or output by its name."""
        return Interval(*self._step.ends(name))

    def _bounds(self, kind: str) -> "dict[str, Interval]":
        return {entry["name"]: Interval(*entry["bounds"]) for entry in self._step.bounds(kind)}

    @property
    def params(self) -> "dict[str, Interval]":
        """Bounds of the parameters; empty where the verdict is not consistent."""
        return self._bounds("params")

    @property
    def states(self) -> "dict[str, Interval]":
        """Bounds of the states."""
        return self._bounds("states")

    @property
    def outputs(self) -> "dict[str, Interval]":
        """Bounds of the outputs, after the measurement."""
        return self._bounds("outputs")

    def __repr__(self) -> str:
        parts = [f"{name} {bounds}" for name, bounds in {**self.params, **self.states}.items()]
        told = self.message or ", ".join(parts)
        return f"<t = {self.t} s: {self.verdict}; {told}>"

    def _repr_html_(self) -> str:
        return f"<code>{escape(repr(self))}</code>"


class Observer:
    """Follows a machine sample by sample; one `step` for each.

    Guarantee and options are those of `veribound.observe`; memory does not grow, and the time for a sample is bounded
    by the number of boxes, and with ``method="polytope"`` by `budget`.

    >>> import veribound as vb
    >>> model = vb.Model.from_toml('''
    ... format = 1
    ... states = ["x [m]"]
    ... init = { x = 1 }
    ... [params]
    ... k = [0, 2]
    ... [der]
    ... x = "-k*x"
    ... [outputs]
    ... x_m = "x +- 0.01"
    ... ''')
    >>> observer = vb.Observer(model)
    >>> observer.step(0.0, x_m=1.0).verdict
    'consistent'
    >>> 1.0 in observer.step(0.5, x_m=0.6065)["k"]
    True
    """

    def __init__(
        self,
        model: Any,
        *,
        reset: "Union[None, str, Sequence[str]]" = None,
        input_error: "Optional[Mapping[str, Any]]" = None,
        output_error: "Optional[Mapping[str, Any]]" = None,
        boxes: Optional[int] = None,
        bisections: Optional[int] = None,
        every: Optional[int] = None,
        epsilon: Optional[float] = None,
        velocity_horizon: Optional[float] = None,
        windows: Optional["Sequence[int]"] = None,
        trisect: bool = False,
        parameter_rule: Optional[str] = None,
        merge_across_modes: bool = False,
        order: Optional[int] = None,
        halvings: Optional[int] = None,
        longest_step: Optional[float] = None,
        engine: Optional[str] = None,
        method: Optional[str] = None,
        rows: Optional[int] = None,
        replay: Optional[int] = None,
        history: Optional[int] = None,
        budget: Optional[int] = None,
        exact: bool = False,
    ) -> None:
        given = dict(locals())
        self.model = _runs._model(model)
        """The model."""
        words = ["observe", _runs._name(self.model), "stream", "-o", "nowhere", *_words.words(given)]
        self._stepper = _veribound.Stepper(self.model._model, words, exact)

    @property
    def samples(self) -> int:
        """Number of samples that were taken."""
        return self._stepper.samples

    @property
    def assumptions(self) -> "list[str]":
        """What is assumed beside the model file, in sentences."""
        return self._stepper.assumptions

    def step(self, t: Any, values: "Optional[Mapping[str, Any]]" = None, /, **named: Any) -> Step:
        """Takes the next sample.

        `t` is its time in seconds, later than the one before; values are given by name, as ``step(0.01, u=0.2,
        phi=1.5)`` or as a dictionary, in the units of the model. Every input needs one, with every sample; an output
        or signal that is left out, None or NaN was not measured.
        """
        return Step(self._stepper.step(t, values, **named))
