# SPDX-License-Identifier: MIT
"""Waiting for frames of code that may never give one."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterator
from typing import Generic, TypeVar

from edvo.errors import Error

LOOK_UP = 0.05  # [s], after which who waits looks whether it is to stop
SILENCE = 5.0  # [s] without a frame, after which a live source is given up
PATIENCE = 1.0  # [s] that a source which is waiting itself has to end

T = TypeVar("T")


class Asked(Generic[T]):
    """An iterator in a thread of its own, which goes on only when it is asked: what it gave last
    stays as it is until then."""

    def __init__(self, items: Iterator[T]) -> None:
        self._items = items
        self._asked, self.answered = threading.Event(), threading.Event()
        self.answered.set()
        self._closed = False
        self._item: list[T] = []
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, name="edvo source", daemon=True)
        self._thread.start()

    def ask(self) -> None:
        self._item = []
        self.answered.clear()
        self._asked.set()

    def answer(self) -> list[T]:
        """One item, or none at the end; raises what the iterator raised."""
        if self._error is not None:
            error, self._error = self._error, None
            raise error
        return self._item

    def close(self) -> None:
        """Closes the iterator; one that waits for a frame is left to itself after a while."""
        is_waiting = not self.answered.is_set()
        self._closed = True
        self._asked.set()
        self._thread.join(PATIENCE if is_waiting else None)

    def _work(self) -> None:
        while True:
            self._asked.wait()
            if self._closed:
                break
            self._asked.clear()
            try:
                self._item = [next(self._items)]
            except StopIteration:
                pass
            except BaseException as error:  # noqa: BLE001: raised where it was asked for
                self._error = error
            self.answered.set()
        if isinstance(self._items, Generator):
            self._items.close()


def awaited(
    items: Iterator[T], should_stop: Callable[[], bool], name: str, patience: float | None
) -> Iterator[T]:
    """The items; the wait for one ends when ``should_stop`` says so, and with an ``edvo.Error``
    after ``patience`` [s], if there is such a limit."""
    asked = Asked(items)
    try:
        while True:
            asked.ask()
            begun = time.monotonic()
            while not asked.answered.wait(LOOK_UP):
                if should_stop():
                    return
                if patience is not None and time.monotonic() - begun >= patience:
                    raise Error(f"{name}: no frame for {patience:g} s; does the camera still run?", 3)
            answer = asked.answer()
            if not answer:
                return
            yield answer[0]
    finally:
        asked.close()
