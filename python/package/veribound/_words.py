"""Options of a call as words of the program's command line: `input_error={"u": "10%"}` is `--input-error=u=10%`."""

from __future__ import annotations

import os
from typing import Any, Mapping

from ._numbers import number

#: Options whose lists are given in one word with commas; others are given once for each entry.
_WITH_COMMAS = {"windows", "figures", "plane"}

#: Options of simulations, where a dictionary is one list.
_ASSIGNMENTS = {"params", "start", "disturbance"}

#: What a call says to the package alone; everything else is an option of the program under the same name.
OWN = {"self", "model", "record", "records", "inputs", "output", "exact", "frames", "progress"}


def _text(value: Any) -> str:
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    return number(value)


def place(name: str) -> str:
    """A path or name that cannot be taken for an option."""
    return f"./{name}" if name.startswith("-") else name


def words(options: "Mapping[str, Any]") -> "list[str]":
    """The words of the options among the arguments of a call; those that are None or False are left out."""
    given = []
    for name, value in options.items():
        flag = "--" + name.strip("_").replace("_", "-")
        if name in OWN or value is None or value is False:
            continue
        if value is True:
            given.append(flag)
        elif isinstance(value, Mapping):
            pairs = [f"{key}={_text(entry)}" for key, entry in value.items()]
            given += [f"{flag}={pair}" for pair in ([",".join(pairs)] if name in _ASSIGNMENTS else pairs) if pair]
        elif isinstance(value, (list, tuple)):
            entries = [_text(entry) for entry in value]
            given += [f"{flag}={entry}" for entry in ([",".join(entries)] if name in _WITH_COMMAS else entries)]
        else:
            given.append(f"{flag}={_text(value)}")
    return given
