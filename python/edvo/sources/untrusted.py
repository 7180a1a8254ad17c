# SPDX-License-Identifier: MIT
"""What files from outside may do to a reader: say anything, and ask for any amount of memory."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager

from edvo.errors import Error

MOST_PIXELS = 1 << 24  # of an image that Python decodes, 4096 x 4096
LARGEST_SIDE = 1 << 14  # [px], as in the C++ library
LARGEST_FILE = 1 << 27  # [bytes] that are read at once, 128 MiB
# What Python and its libraries raise for bytes that are not as they should be.
DAMAGE: tuple[type[Exception], ...] = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,
    RecursionError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


@contextmanager
def reading(what: object, code: int = 3, *others: type[Exception]) -> Iterator[None]:
    """Whatever a damaged file makes its reader raise becomes an ``edvo.Error`` that names it.

    ``others``: what a library raises beside that.
    """
    kinds = (*DAMAGE, *others)
    try:
        yield
    except Error as error:
        text = str(error)
        is_whole = str(what) in text or error.code == 2  # how edvo is used is no matter of the file
        raise error if is_whole else Error(f"{what}: {text}", error.code) from None
    except OSError as error:
        raise Error(f"{what}: cannot be read: {error.strerror or one_line(error)}", code) from None
    except kinds as error:
        raise Error(f"{what}: damaged: {one_line(error)}", code) from None


def one_line(error: BaseException) -> str:
    """Its message, cut where libraries quote whole files; its kind where that says more."""
    text = " ".join(str(error).split())[:200]
    is_clear = isinstance(error, (ValueError, RuntimeError)) and text
    return text if is_clear else f"{type(error).__name__} {text}".strip()


def check_pixels(what: object, width: int, height: int) -> None:
    """Before memory is asked for. Raises edvo.Error."""
    sides = width, height
    if min(sides) < 1 or max(sides) > LARGEST_SIDE or width * height > MOST_PIXELS:
        raise Error(
            f"{what}: {width} x {height} pixels; 1 to {LARGEST_SIDE} a side and at most "
            f"{MOST_PIXELS} are read",
            code=3,
        )
