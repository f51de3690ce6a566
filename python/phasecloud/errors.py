"""The errors that phasecloud raises; each says what was wrong, where, and what would be right."""

from __future__ import annotations


class InputError(ValueError):
    """Something in a file, in keywords or in settings is not allowed.

    `file` is the file, or says in words where the values came from; `line` counts from 1 and is None where there is no file; `key` is the
    key with its table, such as ``orbit.area_to_mass``; `problem` says what is wrong and what would be right.
    """

    def __init__(self, message: str, file: str = "", line: int | None = None, key: str = "", problem: str = "") -> None:
        super().__init__(message)
        self.file, self.line, self.key, self.problem = file, line, key, problem

    def without_line(self) -> InputError:
        """The same error about values that did not stand in a file."""
        message = ": ".join(part for part in (self.file, self.key, self.problem) if part)
        return InputError(message, self.file, None, self.key, self.problem)


class Refused(RuntimeError):
    """A method cannot do what was asked; the message says why, and what can be done instead."""


class LostOrbit(Refused):
    """An orbit left the domain of the equations of motion; the message says which, where it started and when."""


class RunFailed(RuntimeError):
    """The command ended with an error. `code` is its exit code, `said` what it said."""

    def __init__(self, message: str, code: int, said: str) -> None:
        super().__init__(message)
        self.code, self.said = code, said
