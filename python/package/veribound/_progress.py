"""Progress bars, where tqdm is there and somebody watches."""

from __future__ import annotations

import sys
import time
import warnings
from typing import Any, Callable, Optional

#: Shorter runs show no bar, in seconds.
_PATIENCE = 0.5

#: Seconds between two changes of a bar.
_PAUSE = 0.2


class _Bar:
    """Calls tqdm with what the Rust side tells."""

    def __init__(self) -> None:
        with warnings.catch_warnings():
            # Without ipywidgets tqdm draws bars of text.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm

        self._tqdm = tqdm
        self._bar: Any = None
        self._what = ""
        self._begin = time.monotonic()
        self._drawn = self._begin

    def __call__(self, done: int, whole: int, text: str) -> None:
        now = time.monotonic()
        if now - self._begin < _PATIENCE or now - self._drawn < _PAUSE or not text:
            return
        self._drawn = now
        what = text if whole else "sets"
        if self._bar is not None and self._what != what:
            self.close()
        if self._bar is None:
            form = None if whole else "{desc}"
            self._bar = self._tqdm(desc=text, total=whole or None, leave=False, bar_format=form, unit="")
            self._what = what
        self._bar.set_description(text, refresh=not whole)
        if whole:
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def bar(progress: Any) -> "Optional[Callable[[int, int, str], None]]":
    """What the Rust side calls about twenty times a second: a bar, the user's own function, or nothing."""
    if callable(progress):
        return progress
    if progress is False:
        return None
    watched = "ipykernel" in sys.modules or sys.stderr is not None and sys.stderr.isatty()
    if progress is None and not watched:
        return None
    try:
        return _Bar()
    except ImportError:
        return None


def close(bar: Any) -> None:
    """Takes a bar away."""
    if isinstance(bar, _Bar):
        bar.close()
