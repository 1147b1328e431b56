"""What runs come to."""

from __future__ import annotations

import json
from html import escape
from typing import Any, Iterator, Optional

import numpy as np

from . import _figures, _frames
from ._interval import Interval


class _Result:
    """What all runs have in common."""

    def __init__(self, done: Any, model: Any, frames: str, output: Optional[str]) -> None:
        self._done = done
        self._frames = frames
        self.model = model
        """The model that was run."""
        self.output = output
        """The folder with the files of the run, if one was asked for."""

    @property
    def verdict(self) -> str:
        """``"consistent"``, ``"inconsistent"`` (proved: nothing in the priors explains the record) or
        ``"undecided"`` (neither is proved; the bounds hold as far as they go). Of an enclosure ``"proved"`` or
        ``"undecided"``."""
        return self._done.verdict

    @property
    def message(self) -> Optional[str]:
        """What the program says where the verdict is not the good one: why, where, and one thing to do."""
        return self._done.message

    @property
    def assumptions(self) -> "list[str]":
        """What was assumed beside the model file, in sentences."""
        return self._done.assumptions

    @property
    def notes(self) -> "list[str]":
        """What one should know of the record: missing values, columns that were not used, likely slips."""
        return self._done.notes

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the run; what is here was proved until then."""
        return self._done.interrupted

    @property
    def summary(self) -> "dict[str, Any]":
        """What the program writes as ``summary.json``: bounds as decimals, rounded outward."""
        return json.loads(self._done.json)

    def table(self) -> str:
        """The table that the program prints."""
        return self._done.table()

    def __str__(self) -> str:
        return self.table().rstrip()

    def __repr__(self) -> str:
        return self.table().rstrip()

    def _frame(self, columns: "dict[str, Any]", index: Optional[str] = "t") -> Any:
        return _frames.make(columns, self._frames, index)

    def _entries(self) -> "list[dict[str, Any]]":
        raise NotImplementedError

    def __getitem__(self, name: str) -> Interval:
        """The bounds of a parameter, state or output by its name, at the end of the run."""
        for entry in self._entries():
            if entry["name"] == name:
                return Interval(*entry["bounds"])
        known = "`, `".join(entry["name"] for entry in self._entries())
        raise KeyError(f"the model has no `{name}`; it has `{known}`")

    def __iter__(self) -> "Iterator[str]":
        return (entry["name"] for entry in self._entries())

    def __contains__(self, name: object) -> bool:
        return any(entry["name"] == name for entry in self._entries())

    def _html(self, heads: "list[str]", rows: "list[list[str]]") -> str:
        cell = "padding:0.15em 0.9em;text-align:left"
        head = "".join(f'<th style="{cell}">{escape(text)}</th>' for text in heads)
        body = "".join(
            "<tr>" + "".join(f'<td style="{cell}">{escape(text or "")}</td>' for text in row) + "</tr>" for row in rows
        )
        first = self.table().strip().splitlines()[0].strip()
        parts = [f"<p><b>{escape(self.verdict)}</b> <small>{escape(first)}</small></p>"]
        if rows:
            parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")
        if self.message:
            parts.append(f"<pre>{escape(self.message.rstrip())}</pre>")
        said = [f"<li>{escape(text)}</li>" for text in self.assumptions + self.notes]
        if said:
            parts.append(f"<details><summary>assumed, and seen in the record</summary><ul>{''.join(said)}</ul></details>")
        return "".join(parts)


class Observation(_Result):
    """What an observation proved, sample by sample.

    Every solution of the model that agrees with the record up to a sample lies in the bounds of that sample, if the
    record's errors are inside their declared bounds. Frames have one row for each of the `m` samples, indexed by
    the time `t` in seconds, and two columns for every quantity, `name.lo` and `name.hi`, in the unit of the model.
    The floats are what was proved; the program's files have the same rounded outward to 12 digits.
    """

    def _entries(self) -> "list[dict[str, Any]]":
        return self._done.bounds("params") + self._done.bounds("states")

    @property
    def times(self) -> np.ndarray:
        """Time stamps in seconds, shape ``(m,)``: the nearest floats to the record's decimals."""
        return _frames.floats(self._done.times())

    @property
    def params(self) -> Any:
        """Bounds of the parameters after every sample, and the names of those that may have a new value
        (``resets``): shape ``(m, 2 p + 1)``."""
        columns: "dict[str, Any]" = {"t": self.times, **_frames.bands(self._done.bands("params"))}
        columns["resets"] = _frames.words(self._done.words("resets"))
        return self._frame(columns)

    @property
    def states(self) -> Any:
        """Bounds of the states after every sample, the modes that are possible, and the number of boxes: shape
        ``(m, 2 n + 2)``."""
        columns: "dict[str, Any]" = {"t": self.times, **_frames.bands(self._done.bands("states"))}
        columns["modes"] = _frames.words(self._done.words("modes"))
        columns["boxes"] = _frames.floats(self._done.box_counts()).astype(np.int64)
        return self._frame(columns)

    @property
    def outputs(self) -> Any:
        """Bounds of the outputs after every sample: shape ``(m, 2 q)``."""
        return self._frame({"t": self.times, **_frames.bands(self._done.bands("outputs"))})

    @property
    def measured(self) -> Any:
        """What the samples allow of the outputs, error bounds included; NaN where nothing was measured: shape
        ``(m, 2 q)``."""
        return self._frame({"t": self.times, **_frames.bands(self._done.bands("measured"))})

    @property
    def boxes(self) -> Any:
        """The boxes that are left after the last sample, one in each row: states, parameters, and modes."""
        columns, modes = self._done.boxes()
        found = {"box": np.arange(1, len(modes) + 1), **_frames.bands(columns)}
        found["modes"] = np.array(modes, dtype=object)
        return self._frame(found, "box")

    @property
    def bounds(self) -> Any:
        """Parameters and states at the end, one in each row: ``unit``, ``prior.lo``, ``prior.hi``, ``lo``, ``hi``."""
        return self._frame(_bounds_columns(self._entries()), "name")

    def plot(self, what: str = "params", *, figure: Any = None) -> Any:
        """Bounds over time as a matplotlib figure: ``"params"``, ``"states"`` or ``"outputs"`` (with the samples)."""
        return _figures.observation(self, what, figure)

    def _repr_html_(self) -> str:
        heads = ["", "prior", "proved", "unit", "shrink"]
        rows = [
            [entry["name"], entry["prior_shown"], entry["shown"], entry["unit"], entry["shrink"]]
            for entry in self._entries()
        ]
        return self._html(heads, rows if self.verdict != "inconsistent" else [])


class Identification(_Result):
    """What records leave of the parameters, proved from both sides.

    ``result["alpha"]`` has the outer bounds: every value that agrees with model and records lies inside.
    `inner` tells what is proved to be reached, so that no narrower bounds can be true.
    """

    def _entries(self) -> "list[dict[str, Any]]":
        return self._done.bounds()

    def inner(self, name: str) -> Optional[Interval]:
        """Both ends are proved to be reached by parameters that agree with the records; None where nothing is."""
        for entry in self._entries():
            if entry["name"] == name:
                return None if entry["inner"] is None else Interval(*entry["inner"])
        raise KeyError(f"the model has no parameter `{name}`")

    def tightness(self, name: str) -> float:
        """The outer bounds are at most so many times as wide as the best that anybody could prove."""
        for entry in self._entries():
            if entry["name"] == name:
                return float(entry["tightness"])
        raise KeyError(f"the model has no parameter `{name}`")

    def start(self, record: int = 0) -> "dict[str, Interval]":
        """Bounds of the states at the first sample of a record, by its position."""
        if not 0 <= record < self._done.records:
            raise IndexError(f"there are {self._done.records} records, and none at position {record}")
        return {entry["name"]: Interval(*entry["bounds"]) for entry in self._done.bounds(record)}

    @property
    def bounds(self) -> Any:
        """Parameters, one in each row: ``unit``, ``prior.lo``, ``prior.hi``, ``lo``, ``hi`` (outer), ``inner.lo``,
        ``inner.hi``, ``tightness``."""
        entries = self._entries()
        columns = _bounds_columns(entries)
        inner = [entry["inner"] or (np.nan, np.nan) for entry in entries]
        columns["inner.lo"] = np.array([lo for lo, _ in inner])
        columns["inner.hi"] = np.array([hi for _, hi in inner])
        columns["tightness"] = np.array([entry["tightness"] for entry in entries])
        return self._frame(columns, "name")

    @property
    def least_error(self) -> Optional[Interval]:
        """The least factor of all declared measurement errors with which anything agrees: below the lower end nothing
        does, at the upper end (infinite where none is known) something does. None where it was not looked for."""
        ends = self._done.least_error()
        return None if ends is None else Interval(*ends)

    @property
    def points(self) -> Any:
        """Parameters that are proved to agree with model and records, one point (as a tiny box) in each row."""
        columns = _frames.bands(self._done.points())
        count = len(next(iter(columns.values()), []))
        return self._frame({"point": np.arange(1, count + 1), **columns}, "point")

    @property
    def paving(self) -> Any:
        """The tiles of the prior, if a paving was asked for, one in each row: ends, ``status``, ``reason``. What agrees of
        those that are ``turned`` is in `turned`."""
        columns, status, reasons = self._done.paving()
        found: "dict[str, Any]" = _frames.bands(columns)
        found["status"] = np.array(status, dtype=object)
        found["reason"] = np.array(reasons, dtype=object)
        return self._frame(found, None)

    @property
    def turned(self) -> Any:
        """Turned tiles, which hold all that agrees of tiles whose status is ``turned``: number of the frame, ends of the
        coordinates, ``status``, ``reason``."""
        frames, columns, status, reasons = self._done.turned()
        found: "dict[str, Any]" = {"frame": np.array(frames, dtype=int), **_frames.bands(columns)}
        found["status"] = np.array(status, dtype=object)
        found["reason"] = np.array(reasons, dtype=object)
        return self._frame(found, None)

    @property
    def frames(self) -> Any:
        """Frames of turned tiles, one in each row: coordinates ``y`` stand for ``middle + y1 * .y1 + y2 * .y2 + ...``."""
        found: "dict[str, Any]" = {"frame": np.arange(1, len(self._done.frames()) + 1)}
        for at, param in enumerate(self.model.params):
            found[f"{param.name}.middle"] = np.array([middle[at] for middle, _ in self._done.frames()])
            for axis in range(len(next((axes[at] for _, axes in self._done.frames()), []))):
                found[f"{param.name}.y{axis + 1}"] = np.array([axes[at][axis] for _, axes in self._done.frames()])
        return self._frame(found, "frame")

    def plot(self, what: str = "bounds", *, figure: Any = None) -> Any:
        """A matplotlib figure: ``"bounds"`` (prior, outer and inner), or ``"paving"`` of every two parameters."""
        return _figures.identification(self, what, figure)

    def _repr_html_(self) -> str:
        heads = ["", "prior", "outer", "inner", "at most", "unit"]
        rows = [
            [
                entry["name"],
                entry["prior_shown"],
                entry["shown"],
                entry["inner_shown"],
                entry["tightness_shown"],
                entry["unit"],
            ]
            for entry in self._entries()
        ]
        return self._html(heads, rows if self.verdict != "inconsistent" else [])


class Enclosure(_Result):
    """Bounds of all solutions of a model: every start, parameter, disturbance and input error that it allows.

    Frames have a row for every time that is proved, indexed by ``t`` in seconds, and two columns for each quantity.
    """

    def _entries(self) -> "list[dict[str, Any]]":
        return self._done.bounds("states") + self._done.bounds("outputs")

    def always(self, name: str) -> Interval:
        """Bounds of a state or output over all times that are proved."""
        for entry in self._entries():
            if entry["name"] == name:
                return Interval(*entry["always"])
        raise KeyError(f"the model has no state or output `{name}`")

    @property
    def times(self) -> np.ndarray:
        """Time stamps in seconds, shape ``(m,)``."""
        return _frames.floats(self._done.times())

    @property
    def states(self) -> Any:
        """Bounds of the states at the times, and the modes that may have acted since the time before: shape
        ``(m, 2 n + 1)``."""
        columns: "dict[str, Any]" = {"t": self.times, **_frames.bands(self._done.bands("states"))}
        columns["modes"] = _frames.words(self._done.words("modes"))
        return self._frame(columns)

    @property
    def outputs(self) -> Any:
        """Bounds of the outputs at the times: shape ``(m, 2 q)``."""
        return self._frame({"t": self.times, **_frames.bands(self._done.bands("outputs"))})

    @property
    def tube(self) -> Any:
        """Bounds of states and outputs at all times since the one before: shape ``(m, 2 n + 2 q)``."""
        since = {**_frames.bands(self._done.bands("states_since")), **_frames.bands(self._done.bands("outputs_since"))}
        return self._frame({"t": self.times, **since})

    def plot(self, what: str = "states", *, figure: Any = None) -> Any:
        """Bounds over time as a matplotlib figure: ``"states"`` or ``"outputs"``."""
        return _figures.enclosure(self, what, figure)

    def _repr_html_(self) -> str:
        heads = ["", "start", "at the end", "at all times", "unit"]
        rows = [
            [entry["name"], entry["prior_shown"], entry["shown"], entry["always_shown"], entry["unit"]]
            for entry in self._entries()
        ]
        return self._html(heads, rows)


class Simulation:
    """A record of a model with known parameters: what was measured differs from the true outputs by no more than
    the errors that were asked for, which is proved for every decimal in it."""

    def __init__(self, text: str, model: Any, frames: str, notes: "list[str]") -> None:
        self.text = text
        """The record as the program writes it (CSV)."""
        self.model = model
        """The model."""
        self.notes = notes
        """Values outside of the priors, which no observation can find."""
        self._frames = frames

    @property
    def frame(self) -> Any:
        """The record as a frame, with the columns of the record: ``t``, inputs, outputs, signals."""
        import csv

        lines = [line for line in self.text.splitlines() if not line.startswith("#")]
        rows = list(csv.reader(lines))
        columns = {name: np.array([float(row[at]) for row in rows[1:]]) for at, name in enumerate(rows[0])}
        return _frames.make(columns, self._frames)

    def to_csv(self, path: Any) -> None:
        """Writes the record."""
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(self.text)

    def plot(self, *, figure: Any = None) -> Any:
        """Inputs and outputs over time as a matplotlib figure."""
        return _figures.simulation(self, figure)

    def __repr__(self) -> str:
        rows = sum(1 for line in self.text.splitlines() if not line.startswith("#")) - 1
        return f"<veribound.Simulation of {self.model.name!r}: {rows} samples>"


def _bounds_columns(entries: "list[dict[str, Any]]") -> "dict[str, Any]":
    none = (np.nan, np.nan)
    return {
        "name": np.array([entry["name"] for entry in entries], dtype=object),
        "unit": np.array([entry["unit"] for entry in entries], dtype=object),
        "prior.lo": np.array([(entry["prior"] or none)[0] for entry in entries]),
        "prior.hi": np.array([(entry["prior"] or none)[1] for entry in entries]),
        "lo": np.array([entry["bounds"][0] for entry in entries]),
        "hi": np.array([entry["bounds"][1] for entry in entries]),
    }
