"""Figures with matplotlib. A band is drawn between its ends, sample by sample; nothing is thinned out."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from . import _frames

_BLUE, _GREY, _ORANGE, _GREEN = "#1f5fa8", "#b8b8b8", "#c8641e", "#2e8b57"


def _axes(figure: Any, count: int, share: bool = True) -> "tuple[Any, list[Any]]":
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("figures need matplotlib: pip install matplotlib") from error
    if figure is None:
        figure = plt.figure(figsize=(8.0, 1.9 * count + 0.8), layout="constrained")
    axes = figure.subplots(count, 1, sharex=share, squeeze=False)[:, 0]
    return figure, list(axes)


def _close(figure: Any) -> Any:
    """A figure that is returned is shown by the notebook; pyplot would show it once more."""
    import matplotlib.pyplot as plt

    plt.close(figure)
    return figure


def _label(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _band(
    axis: Any, times: np.ndarray, lo: np.ndarray, hi: np.ndarray, color: str, label: str, step: Any = None
) -> None:
    # The edge keeps a band visible that is narrower than a pixel.
    look = {"facecolor": color, "edgecolor": color, "linewidth": 0.6, "alpha": 0.55}
    axis.fill_between(times, lo, hi, step=step, label=label, **look)


def observation(result: Any, what: str, figure: Any) -> Any:
    if what not in ("params", "states", "outputs"):
        raise ValueError(f"there is no figure of {what!r}; choose 'params', 'states' or 'outputs'")
    model, done, times = result.model, result._done, result.times
    bands = _frames.bands(done.bands(what))
    quantities = {"params": model.params, "states": model.states, "outputs": model.outputs}[what]
    figure, axes = _axes(figure, len(quantities))
    measured = _frames.bands(done.bands("measured")) if what == "outputs" else {}
    resets = _frames.words(done.words("resets"))
    for axis, quantity in zip(axes, quantities):
        name = quantity.name
        if measured:
            lo, hi = measured[f"{name}.lo"], measured[f"{name}.hi"]
            there = ~np.isnan(lo)
            _band(axis, times[there], lo[there], hi[there], _GREY, "measured")
        # A parameter keeps its bounds until the next sample.
        step = "post" if what == "params" else None
        _band(axis, times, bands[f"{name}.lo"], bands[f"{name}.hi"], _BLUE, "proved", step)
        if what == "params" and quantity.bounds is not None:
            for end in quantity.bounds:
                axis.axhline(end, color="black", linewidth=0.8, linestyle=":")
            at = [t for t, names in zip(times, resets) if name in names.split("|")]
            axis.plot(at, np.full(len(at), 0.97), "|", color=_ORANGE, transform=axis.get_xaxis_transform())
        axis.set_ylabel(_label(name, quantity.unit))
        axis.margins(x=0.01)
    if measured:
        axes[0].legend(loc="best", fontsize="small")
    axes[-1].set_xlabel("t [s]")
    figure.suptitle(f"{model.name}: {result.verdict}")
    return _close(figure)


def enclosure(result: Any, what: str, figure: Any) -> Any:
    if what not in ("states", "outputs"):
        raise ValueError(f"there is no figure of {what!r}; choose 'states' or 'outputs'")
    model, done, times = result.model, result._done, result.times
    quantities = {"states": model.states, "outputs": model.outputs}[what]
    since = _frames.bands(done.bands(f"{what}_since"))
    figure, axes = _axes(figure, len(quantities))
    # What is proved of all times between two rows is drawn as wide between them.
    corners = np.repeat(times, 2)[1:-1] if len(times) > 1 else times
    for axis, quantity in zip(axes, quantities):
        ends = [since[f"{quantity.name}.{end}"] for end in ("lo", "hi")]
        lo, hi = [np.repeat(values[1:], 2) if len(times) > 1 else values for values in ends]
        _band(axis, corners, lo, hi, _BLUE, "proved for all solutions")
        axis.set_ylabel(_label(quantity.name, quantity.unit))
        axis.margins(x=0.01)
    axes[-1].set_xlabel("t [s]")
    figure.suptitle(f"{model.name}: all solutions")
    return _close(figure)


def identification(result: Any, what: str, figure: Any) -> Any:
    if what == "paving":
        return _paving(result, figure)
    if what != "bounds":
        raise ValueError(f"there is no figure of {what!r}; choose 'bounds' or 'paving'")
    entries = result._done.bounds()
    figure, axes = _axes(figure, len(entries), share=False)
    for axis, entry in zip(axes, entries):
        rows = [("prior", entry["prior"], _GREY), ("outer", entry["bounds"], _BLUE), ("inner", entry["inner"], _GREEN)]
        for height, (_, ends, color) in enumerate(rows):
            if ends is not None and ends[0] == ends[0]:
                axis.plot(ends, [-height, -height], color=color, linewidth=5, marker="|", markersize=11)
        axis.set_yticks([0, -1, -2], [label for label, _, _ in rows])
        axis.set_ylim(-2.7, 0.7)
        axis.set_xlabel(_label(entry["name"], entry["unit"]))
    figure.suptitle(f"{result.model.name}: {result.verdict}")
    return _close(figure)


def _paving(result: Any, figure: Any) -> Any:
    columns, status, _ = result._done.paving()
    # What agrees of a tile that is divided along other axes is somewhere in it.
    status = ["undecided" if kind == "turned" else kind for kind in status]
    if not status:
        raise ValueError("there is no paving; ask for one, as in identify(..., paving='1%')")
    names = [name for name, _, _ in columns]
    pairs = list(combinations(names, 2)) or [(names[0], names[0])]
    bands = _frames.bands(columns)
    import matplotlib.pyplot as plt
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    if figure is None:
        figure = plt.figure(figsize=(4.2 * len(pairs), 4.0), layout="constrained")
    axes = figure.subplots(1, len(pairs), squeeze=False)[0]
    # What is inside lies above: a projection of tiles shows what is possible.
    colors = [("outside", "#eeeeee"), ("undecided", "#f0c040"), ("inside", _GREEN)]
    for axis, (x, y) in zip(axes, pairs):
        for kind, color in colors:
            tiles = [
                Rectangle((a, c), b - a, d - c)
                for a, b, c, d, is_kind in zip(
                    bands[f"{x}.lo"], bands[f"{x}.hi"], bands[f"{y}.lo"], bands[f"{y}.hi"], status
                )
                if is_kind == kind
            ]
            axis.add_collection(PatchCollection(tiles, facecolor=color, edgecolor=color, linewidth=0.3))
        # What is left, with as much of what is excluded around it.
        for name, limit in ((x, axis.set_xlim), (y, axis.set_ylim)):
            left = [at for at, kind in enumerate(status) if kind != "outside"] or range(len(status))
            lo, hi = min(bands[f"{name}.lo"][at] for at in left), max(bands[f"{name}.hi"][at] for at in left)
            limit(lo - 0.3 * (hi - lo), hi + 0.3 * (hi - lo))
        units = {param.name: param.unit for param in result.model.params}
        axis.set_xlabel(_label(x, units[x]))
        axis.set_ylabel(_label(y, units[y]))
    figure.suptitle(f"{result.model.name}: inside green, undecided yellow")
    return _close(figure)


def simulation(result: Any, figure: Any) -> Any:
    import csv

    lines = [line for line in result.text.splitlines() if not line.startswith("#")]
    rows = list(csv.reader(lines))
    names = rows[0][1:]
    times = np.array([float(row[0]) for row in rows[1:]])
    figure, axes = _axes(figure, len(names))
    for at, (axis, name) in enumerate(zip(axes, names)):
        values = np.array([float(row[at + 1]) for row in rows[1:]])
        axis.plot(times, values, color=_BLUE, linewidth=0.9, drawstyle="steps-post")
        axis.set_ylabel(name)
        axis.margins(x=0.01)
    axes[-1].set_xlabel("t [s]")
    figure.suptitle(f"{result.model.name}: simulated record")
    return _close(figure)
