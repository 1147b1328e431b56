"""Frames in and out: pandas, polars, and plain dictionaries of NumPy arrays."""

from __future__ import annotations

import os
import sys
from typing import Any, Iterable, Mapping, Optional, Tuple

import numpy as np

from . import _veribound

#: Names of a time column, as the program knows them.
_TIMES = ("t", "time", "timestamp", "stamp")

_MISSING_NAME = "veribound needs pandas or polars for frames; pass frames='numpy' for dictionaries of arrays"


def kind_of(record: Any) -> Optional[str]:
    """"pandas", "polars", "numpy"; None for a path."""
    for module in ("pandas", "polars"):
        frames = sys.modules.get(module)
        if frames is not None and isinstance(record, frames.DataFrame):
            return module
    return "numpy" if isinstance(record, Mapping) else None


def source(record: Any, exact: bool) -> "_veribound.Source":
    """A record or profile for a run: a path, a pandas or polars frame, or a mapping of columns."""
    if isinstance(record, _veribound.Source):
        return record
    if isinstance(record, (str, os.PathLike)):
        return _veribound.Source.file(os.fspath(record))
    kind = kind_of(record)
    if kind == "pandas":
        return _veribound.Source.table("<pandas frame>", list(_pandas(record)), exact)
    if kind == "polars":
        return _veribound.Source.table("<polars frame>", list(_polars(record)), exact)
    if kind == "numpy":
        columns = [column(str(name), np.asarray(values)) for name, values in record.items()]
        return _veribound.Source.table("<columns>", columns, exact)
    raise TypeError(
        f"a record is a path, a pandas or polars frame, or a dictionary of columns, not {type(record).__name__}"
    )


Column = Tuple[str, str, Any, Optional[list]]


def column(name: str, values: np.ndarray) -> Column:
    """A column as the Rust side takes it: name, kind, data, which values are there."""
    if values.ndim != 1:
        raise ValueError(f"the column `{name}` has the shape {values.shape}; give one value for each sample")
    kind = values.dtype.kind
    if kind == "f" and values.dtype.itemsize <= 4:
        return name, "f4", _bytes(values, np.float32), None
    if kind == "f":
        return name, "f8", _bytes(values, np.float64), None
    if kind == "b":
        return name, "b1", _bytes(values, np.uint8), None
    if kind == "u":
        return name, "u8", _bytes(values, np.uint64), None
    if kind == "i":
        return name, "i8", _bytes(values, np.int64), None
    if kind in "mM":
        return _times(name, values)
    return _texts(name, values.tolist())


def _bytes(values: np.ndarray, dtype: Any) -> bytes:
    return np.ascontiguousarray(values, dtype=dtype).tobytes()


def _times(name: str, values: np.ndarray) -> Column:
    """Times of a clock, or durations: exact seconds, those of a clock since the first sample."""
    present = ~np.isnat(values)
    if values.dtype.kind == "M":
        first = values[present][0] if present.any() else values
        values = values - first
    # NaT becomes a number that nobody reads.
    whole = values.astype("timedelta64[ns]").astype(np.int64)
    return name, "ns", _bytes(whole, np.int64), None if present.all() else present.tolist()


def _texts(name: str, values: Iterable[Any]) -> Column:
    from ._numbers import number

    def text(value: Any) -> Optional[str]:
        if value is None or value != value or type(value).__name__ in ("NAType", "NaTType"):
            return None
        return number(value)

    return name, "text", [text(value) for value in values], None


def _pandas(frame: Any) -> "Iterable[Column]":
    import pandas as pd

    names = [str(name) for name in frame.columns]
    index = frame.index
    # A frame that is indexed by time has no other column with it.
    is_time = index.name is not None and str(index.name).split(" [")[0].lower() in _TIMES
    is_clock = isinstance(index, (pd.DatetimeIndex, pd.TimedeltaIndex))
    if (is_time or is_clock) and not any(name.split(" [")[0].lower() in _TIMES for name in names):
        yield _of_series(pd, str(index.name) if is_time else "t", index.to_series())
    for name, at in zip(names, range(len(names))):
        yield _of_series(pd, name, frame.iloc[:, at])


def _of_series(pd: Any, name: str, series: Any) -> Column:
    if isinstance(series.dtype, pd.DatetimeTZDtype):
        series = series.dt.tz_convert("UTC").dt.tz_localize(None)
    if isinstance(series.dtype, np.dtype):
        return column(name, series.to_numpy())
    present = series.notna().to_numpy()
    if pd.api.types.is_bool_dtype(series.dtype) or pd.api.types.is_numeric_dtype(series.dtype):
        dtype = getattr(series.dtype, "numpy_dtype", None)
        if isinstance(dtype, np.dtype) and dtype.kind in "fiub":
            name, kind, data, _ = column(name, series.to_numpy(dtype=dtype, na_value=dtype.type(0)))
            return name, kind, data, None if present.all() else present.tolist()
    return _texts(name, [value if there else None for value, there in zip(series, present)])


def _polars(frame: Any) -> "Iterable[Column]":
    import polars as pl

    for series in frame:
        present = None if series.null_count() == 0 else series.is_not_null().to_list()
        if series.dtype in (pl.Float32, pl.Float64, pl.Boolean) or series.dtype.is_integer():
            filled = series if present is None else series.fill_null(0 if series.dtype != pl.Boolean else False)
            name, kind, data, _ = column(series.name, filled.to_numpy())
            yield name, kind, data, present
        elif series.dtype.is_temporal():
            yield column(series.name, series.to_numpy())
        else:
            yield _texts(series.name, series.to_list())


def choose(frames: Optional[str], given: Any) -> str:
    """The kind of frames that results come in: as asked for, as the record, or what is there."""
    if frames is not None:
        if frames not in ("pandas", "polars", "numpy"):
            raise ValueError(f"frames={frames!r} is not known; use 'pandas', 'polars' or 'numpy'")
        return frames
    kind = kind_of(given)
    if kind in ("pandas", "polars"):
        return kind
    for module in ("pandas", "polars"):
        try:
            __import__(module)
        except ImportError:
            continue
        return module
    return "numpy"


def make(columns: "dict[str, Any]", kind: str, index: Optional[str] = None) -> Any:
    """A frame of these columns; `index` names the one that is the index of a pandas frame."""
    if kind == "numpy":
        return columns
    if kind == "polars":
        import polars as pl

        return pl.DataFrame({name: list(x) if x.dtype == object else x for name, x in columns.items()})
    try:
        import pandas as pd
    except ImportError as error:
        raise ImportError(_MISSING_NAME) from error
    frame = pd.DataFrame(columns)
    return frame if index is None else frame.set_index(index)


def floats(data: bytes) -> np.ndarray:
    """The numbers that the Rust side hands over, as an array that nobody can change."""
    return np.frombuffer(data, dtype=np.float64)


def words(data: "tuple[list[str], bytes]") -> np.ndarray:
    """Texts of which few differ."""
    different, positions = data
    texts = np.array(different, dtype=object)
    return texts[np.frombuffer(positions, dtype=np.uint32)] if different else np.array([], dtype=object)


def bands(columns: "list[tuple[str, bytes, bytes]]") -> "dict[str, np.ndarray]":
    """`name.lo` and `name.hi` for every quantity, as in the program's tables."""
    found = {}
    for name, lo, hi in columns:
        found[f"{name}.lo"] = floats(lo)
        found[f"{name}.hi"] = floats(hi)
    return found
