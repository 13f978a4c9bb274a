"""What can go wrong in a way that a user can understand and mend.

Every error that the package raises on purpose is a `MissionError`; the command line prints its words and returns
its `exit_code`. Rooms derive their own beside the code that raises them.
"""

from importlib import import_module
from typing import Any


class MissionError(Exception):
    """The job could not be done (exit code 1). `hint`, where there is one, says what to try.

    `known` is what is known all the same, for machines: it stands beside the error.
    """

    exit_code = 1

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.hint = hint
        self.known: dict[str, object] = {}


class BadInput(MissionError):
    """What the user gave is wrong (exit code 2); the message begins with the place and says what was expected."""

    exit_code = 2


def imported(module: str, needed: str, extra: str, wrong: type[MissionError] = MissionError) -> Any:
    """A library that only those have who installed the package with this extra.

    Raises:
        MissionError: it is not installed; `needed` says for what it is, `wrong` is the error's class.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise wrong(needed, hint=f"pip install 'ipoa-mission[{extra}]'") from error
