# SPDX-License-Identifier: MIT
"""The one exception type of edvo."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from edvo.runner import Run


class Error(RuntimeError):
    """Bad input from outside, said as what, where and which value.

    ``code`` is the exit status that the program gives for it (docs/errors.md): 2 usage, 3 input,
    4 configuration, 5 calibration, 6 model, 7 output, 8 evaluation, 9 tracking lost.
    """

    def __init__(self, message: str, code: int = 1) -> None:
        super().__init__(message)
        self.code = code
        self.run: Run | None = None  # of edvo.run: what was done until then

    def __reduce__(self) -> tuple[type[Error], tuple[str, int], dict[str, Run | None]]:
        return Error, (str(self), self.code), {"run": self.run}


# What the program's messages call a flag, and what ``edvo.run`` does. Longer ones first.
FLAGS = {
    "--no-loops": "loops=False",
    "--update-map": "update_map=True",
    "--save-map": "save_map",
    "--force": "force=True",
    "--map": "map",
    "with -o": "by output",
}


def in_python(error: Error) -> Error:
    """The error with the keywords of Python instead of the program's flags."""
    text = str(error)
    for flag, keyword in FLAGS.items():
        text = text.replace(flag, keyword)
    return Error(text, error.code)


def missing_extra(purpose: str, package: str, extra: str) -> Error:
    """What is raised where a part of edvo needs a package that is not installed."""
    return Error(f"{purpose} needs the package {package}: pip install 'edvo[{extra}]'", code=2)
