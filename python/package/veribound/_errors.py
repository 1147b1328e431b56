"""What is raised, and what ends a run early."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional


class Problem(NamedTuple):
    """One problem: what is wrong, where, and one thing to do."""

    code: str
    """Stable code, for instance ``"E0213"``; ``veribound explain E0213`` tells more."""
    message: str
    """What is wrong, in one sentence, in the user's names."""
    file: Optional[str]
    """Path or name of the text it is in; None for problems without a place."""
    line: Optional[int]
    """Line of that text; the first is 1. In a frame line 1 is the header, line 2 the first row."""
    text: Optional[str]
    """That line."""
    label: str
    """What is said of the place."""
    help: str
    """One thing to do."""


class Error(ValueError):
    """Wrong input: a model, a record or an option that cannot be used.

    The text is the program's own: message, file, line, the text with a caret, and one thing to do. Failure
    to prove something is no error; it is a verdict.
    """

    def __init__(self, text: str, problems: "list[dict[str, Any]]") -> None:
        super().__init__(text)
        self.problems: "list[Problem]" = [Problem(**problem) for problem in problems]
        """All problems, in the order of the text."""

    @property
    def codes(self) -> "list[str]":
        """The codes of all problems."""
        return [problem.code for problem in self.problems]

    def __reduce__(self) -> Any:
        return (type(self), (str(self), [problem._asdict() for problem in self.problems]))


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a run. What was proved until then is kept in `result`."""

    def __init__(self, result: Any) -> None:
        super().__init__("interrupted; what was proved until then is in `result` of this exception")
        self.result = result
        """The result of the run so far; None for a simulation, which has none before its end."""
