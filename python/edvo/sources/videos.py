# SPDX-License-Identifier: MIT
"""Videos by FFmpeg."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from edvo.errors import Error, missing_extra
from edvo.sources.untrusted import MOST_PIXELS, one_line, reading


@contextmanager
def open_video(file: Path) -> Iterator[Any]:
    """An av.container.InputContainer whose decoders refuse images that are too large. What it raises
    in the block becomes an ``edvo.Error`` that names the file."""
    try:
        import av
    except ImportError:
        raise missing_extra(f"decoding {file.name}", "av", "video") from None
    try:
        video = av.open(str(file))
    except (OSError, ValueError, RuntimeError, av.error.FFmpegError) as error:
        raise Error(f"{file}: cannot be read: {one_line(error)}", code=3) from None
    with reading(file, 3, av.error.FFmpegError), video:
        for stream in video.streams.video:
            # FFmpeg asks for memory for the size in each frame's own header, not only in the first one's.
            if stream.codec_context is not None:
                stream.codec_context.options = {"max_pixels": str(MOST_PIXELS)}
        yield video
