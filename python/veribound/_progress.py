"""Progress bars, where tqdm is there and somebody watches."""

from __future__ import annotations

import sys
from typing import Any, Callable, Optional

#: Shorter runs show no bar.
_PATIENCE = 0.5


class _Bar:
    """Calls tqdm with what the Rust side tells."""

    def __init__(self) -> None:
        import time

        from tqdm.auto import tqdm

        self._tqdm = tqdm
        self._bar: Any = None
        self._what = ""
        self._clock = time.monotonic
        self._begin = time.monotonic()

    def __call__(self, done: int, whole: int, text: str) -> None:
        if self._clock() - self._begin < _PATIENCE or not text:
            return
        what = text if whole else "sets"
        if self._bar is not None and self._what != what:
            self.close()
        if self._bar is None:
            form = None if whole else "{desc}"
            self._bar = self._tqdm(total=whole or None, leave=False, bar_format=form, unit="")
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
