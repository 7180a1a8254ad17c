# SPDX-License-Identifier: MIT
"""Cameras: a source whose frames do not wait."""

from __future__ import annotations

import contextlib
import threading
import time
from abc import abstractmethod
from collections.abc import Iterator
from pathlib import Path

from edvo.camera import Camera, read_scaled
from edvo.errors import Error
from edvo.sources.base import Frame, Source
from edvo.sources.waiting import SILENCE

WAIT = 0.2  # [s], after which a source that is to stop is asked again


class LiveSource(Source):
    """Subclasses start the driver in ``_start``, which sets ``camera``, and read it in ``_read``.

    The camera runs from the beginning, so that its intrinsics are known, to the end of the iteration.
    """

    is_live = True
    kind = "camera"  # as messages name it

    def __init__(self, camera: Camera | str | Path | None = None) -> None:
        super().__init__()
        self._given = camera
        self._stopped = threading.Event()
        self._begin()

    @abstractmethod
    def _start(self) -> None:
        """Starts the device and sets ``camera``."""

    @abstractmethod
    def _read(self, seconds: float) -> Frame | None:
        """The next frame; None if there is none within so many seconds, or it is incomplete."""

    @abstractmethod
    def _end(self) -> None:
        """Stops the device."""

    def stop(self) -> None:
        self._stopped.set()

    def _patience(self) -> float:
        return 2 * SILENCE  # _frames() gives up before, and says more; a driver may hang inside

    def _begin(self) -> None:
        self.notes.clear()
        self.warnings.clear()
        with self._driver():
            self._start()
        self._is_running = True
        self.camera_origin = "as the device has it"
        if self._given is not None:
            size = (self.camera.width, self.camera.height)
            self.camera = read_scaled(self._given, (0, 0), size)
            self.camera_origin = "as given"

    @contextlib.contextmanager
    def _driver(self) -> Iterator[None]:
        """Whatever a driver raises, as an error of the input."""
        try:
            yield
        except Error:
            raise
        except Exception as error:
            raise Error(f"{self.kind}: {str(error).strip() or type(error).__name__}", code=3) from error

    def __iter__(self) -> Iterator[Frame]:
        if not self._is_running:
            self._begin()
        self._stopped.clear()
        try:
            yield from self._frames()
        finally:
            self._is_running = False
            with contextlib.suppress(Exception):  # an unplugged camera cannot be stopped
                self._end()

    def _frames(self) -> Iterator[Frame]:
        heard, last = time.monotonic(), -1
        while not self._stopped.is_set():
            with self._driver():
                frame = self._read(WAIT)
            if frame is None or frame.stamp_ns <= last:  # drivers repeat frames at times
                if time.monotonic() - heard >= SILENCE:
                    raise Error(
                        f"{self.kind}: no frame for {SILENCE:g} s; was it unplugged, or does another "
                        "program use it?",
                        code=3,
                    )
                continue
            heard, last = time.monotonic(), frame.stamp_ns
            yield frame
