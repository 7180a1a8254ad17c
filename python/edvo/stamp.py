# SPDX-License-Identifier: MIT
"""Time stamps as integer nanoseconds: a float loses digits of 1305031102.175304."""

from __future__ import annotations

from decimal import Decimal, InvalidOperation

Seconds = float | int | str | Decimal


LATEST = 9e9  # [s], 285 years


def from_seconds(stamp: float) -> int:
    """[ns], of a number in a file, to the last digit that it has. Raises ValueError for no time."""
    if not abs(stamp) <= LATEST:
        raise ValueError(f"stamp {stamp}: not a number of seconds (up to {LATEST:g})")
    return round(1e9 * stamp)


def nanoseconds(stamp: Seconds) -> tuple[int, int]:
    """A stamp in seconds as nanoseconds and its number of decimals.

    Floats are rounded to microseconds, which is what they can hold; text and decimals are exact.
    """
    if isinstance(stamp, (str, Decimal)):
        try:
            value = Decimal(stamp)
        except InvalidOperation:
            raise ValueError(f"stamp {stamp!r}: not a number of seconds") from None
        if not value.is_finite():
            raise ValueError(f"stamp {stamp!r}: not a finite number of seconds")
        exponent = value.as_tuple().exponent
        decimals = min(max(-exponent if isinstance(exponent, int) else 0, 0), 9)
        return int((value * 1_000_000_000).to_integral_value()), decimals
    if isinstance(stamp, bool) or not isinstance(stamp, (int, float)):
        try:
            stamp = float(stamp)
        except (TypeError, ValueError):
            raise TypeError(f"stamp {stamp!r}: seconds are expected, as a number or text") from None
    if stamp != stamp or abs(stamp) > LATEST:
        raise ValueError(f"stamp {stamp!r}: not a number of seconds (up to {LATEST:g})")
    return round(stamp * 1_000_000) * 1000, 6
