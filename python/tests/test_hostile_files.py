# SPDX-License-Identifier: MIT
"""Files that a fuzzer damaged: whatever their bytes, an edvo.Error names them."""

from __future__ import annotations

import json
import os
import struct
import time
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import edvo
from edvo import pulling
from edvo.sources.image_files import read_colour, read_depth
from edvo.sources.image_size import said_size
from edvo.sources.image_stamps import unit_of
from edvo.sources.untrusted import reading

cv2 = pytest.importorskip("cv2")
K = [15, 0, 0, 0, 15, 0, 7.5, 5.5, 1]
META = {"w": 16, "h": 12, "dw": 16, "dh": 12, "fps": 30, "K": K}
LENS = "fx = 15\nfy = 15\ncx = 7.5\ncy = 5.5\n"


def encoded(suffix: str, image: np.ndarray) -> bytes:
    return bytes(cv2.imencode(suffix, image)[1])


def huge_png(side: int = 12000) -> bytes:
    """Few bytes that say to be many."""
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", side, side, 16, 0, 0, 0, 0)
    data = chunk(b"IDAT", zlib.compress(bytes(9000)))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + data + chunk(b"IEND", b"")


COLOUR = np.full((12, 16, 3), 90, np.uint8)
DEPTH = np.full((12, 16), 1.5, np.float32)


def phone(file: Path, changes: dict[str, bytes]) -> Path:
    lzfse = pytest.importorskip("liblzfse")
    files = {
        "metadata": json.dumps(META).encode(),
        "rgbd/0.jpg": encoded(".jpg", COLOUR),
        "rgbd/0.depth": lzfse.compress(DEPTH.tobytes()),
    }
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in {**files, **changes}.items():
            archive.writestr(name, data)
    return file


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"metadata": b"{"}, "phone.r3d: damaged"),
        ({"metadata": b"[" * 100_000}, "phone.r3d: damaged"),
        ({"metadata": b"{}"}, "phone.r3d: damaged: KeyError 'K'"),
        ({"metadata": json.dumps({**META, "w": 10**9}).encode()}, "r3d: 1000000000 x 12 pixels"),
        ({"metadata": json.dumps({**META, "frameTimestamps": [1e300]}).encode()}, "stamp 1e.300"),
        ({"rgbd/0.jpg": huge_png()}, "0.jpg: 12000 x 12000 pixels"),
        ({"rgbd/0.jpg": encoded(".jpg", COLOUR[:8])}, "frame 0: image of 16 x 8 px"),
        ({"rgbd/0.depth": b""}, "0.depth: data compressed as LZFSE: damaged"),
        ({"rgbd/0.depth": b"bvx-\xff\xff\xff\x7f"}, "0.depth: data compressed as LZFSE: damaged"),
        ({"rgbd/0.depth": b"bvxn\xff\xff\xff\x7f\0\0\0\0bvx$"}, "LZFSE: 2147483647 bytes, at most"),
        ({"rgbd/0.depth": b"bvx-\4\0\0\0\0\0\0\0bvx$"}, "0.depth: damaged: cannot reshape"),
    ],
)
def test_record3d(changes: dict[str, bytes], words: str, tmp_path: Path) -> None:
    with pytest.raises(edvo.Error, match=words):
        list(edvo.open_source(phone(tmp_path / "phone.r3d", changes)))


def test_record3d_that_is_no_archive_or_has_a_damaged_one(tmp_path: Path) -> None:
    file = phone(tmp_path / "phone.r3d", {})
    assert len(list(edvo.open_source(file))) == 1
    file.write_bytes(file.read_bytes()[:-30])
    with pytest.raises(edvo.Error, match="phone.r3d: damaged: BadZipFile"):
        edvo.open_source(file)


def test_poses_of_a_phone_that_are_none_are_left_out(tmp_path: Path) -> None:
    meta = {**META, "poses": [[0, 0, 0, 1, float("nan"), 0, 0]]}
    source = edvo.open_source(phone(tmp_path / "a.r3d", {"metadata": json.dumps(meta).encode()}))
    assert source.ground_truth is None and "ARKit's poses in its metadata are left out" in source.warnings[0]


def npy_of_shape(shape: str) -> bytes:
    head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}\n".encode()
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("0.npy", npy_of_shape("(4000, 4000)")),  # that it does not have
        ("0.npy", npy_of_shape("(4, 0)")),
        ("0.npy", npy_of_shape("(" * 500)),
        ("0.npy", b"PK\3\4"),
        ("0.pgm", b"P5 99999 99999 65535\n"),
        ("0.pgm", b"P5 -1 1 65535\n1234"),
        ("0.tiff", huge_png()),
        ("0.tiff", encoded(".tiff", np.zeros((4, 4), np.float32))[:40]),
        ("0.tiff", b"GIF89a"),
        ("0.exr", b"v/1\1\2\0\0\0"),
    ],
)
def test_depth_images(name: str, data: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(edvo.Error, match=name) as caught:
        read_depth(tmp_path / name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "data"),
    [("0.ppm", b"P6 0 4 255\n"), ("0.tif", encoded(".tiff", DEPTH)), ("0.bmp", huge_png())],
)
def test_colour_images(name: str, data: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(edvo.Error, match=name):
        read_colour(tmp_path / name)


def test_the_size_of_an_image_is_known_before_it_is_decoded() -> None:
    for suffix in (".png", ".jpg", ".bmp", ".tiff"):
        data = encoded(suffix, COLOUR)
        assert said_size(data) == (16, 12)
        for length in range(20):
            said_size(data[:length])
    with_profile = b"\xff\xd8\xff\xe2\0\x06abcd\xff" + encoded(".jpg", COLOUR)[2:]
    assert said_size(with_profile) == (16, 12)
    assert said_size(b"GIF89a") is None


def test_what_a_message_says_of_itself_is_quoted_in_one_line() -> None:
    from types import SimpleNamespace

    from edvo.sources import messages

    data = np.zeros(40, np.uint8)
    for text in ("16UC1; compressedDepth\r\n png", "32FC1; compressedDepth rvl\u2028", "\njpeg"):
        message = SimpleNamespace(format=text, data=data)
        for decode in (messages.decode_colour, lambda m: messages.decode_depth(m, None)):
            with pytest.raises(edvo.Error) as caught:
                decode(message)
            assert len(str(caught.value).splitlines()) == 1


def test_a_camera_has_no_more_pixels_than_numbers_hold() -> None:
    with pytest.raises(edvo.Error, match="width 4.29497e.09: more pixels than an image has"):
        edvo.Camera(15, 15, 7.5, 5.5, 2**32 - 1, 12)


def test_a_rotation_that_is_no_number_is_refused() -> None:
    lens, motion = edvo.Camera(15, 15, 7.5, 5.5, 16, 12), np.eye(4)
    for place in ((0, 1), (0, 3)):
        moved = motion.copy()
        moved[place] = np.nan
        with pytest.raises(ValueError, match="colour_from_depth: not all of its numbers are finite"):
            edvo.DepthRegistration(lens, lens, moved)


def test_a_chunk_that_says_to_be_longer_than_its_png_takes_no_memory(tmp_path: Path) -> None:
    data = encoded(".png", COLOUR)
    begin = time.monotonic()
    for kind in (b"IHDR", b"IDAT", b"IEND"):
        place = data.index(kind)
        (tmp_path / "0.tif").write_bytes(data[: place - 4] + b"\xf7\0\0\0" + data[place:])
        with pytest.raises(edvo.Error, match="0.tif: .* cannot be decoded"):
            read_colour(tmp_path / "0.tif")
    assert time.monotonic() - begin < 1


def test_a_folder_that_is_named_like_an_image_is_none(tmp_path: Path) -> None:
    for suffix in (".pgm", ".tiff", ".npy", ".exr", ".png"):
        (tmp_path / f"0{suffix}").mkdir()
        with pytest.raises(edvo.Error, match=f"0{suffix}"):
            read_depth(tmp_path / f"0{suffix}")


def test_a_compressed_message_takes_no_memory_for_what_it_only_says_to_have() -> None:
    from types import SimpleNamespace

    from edvo.sources import messages

    rvl = bytes(12) + struct.pack("<IIII", 16000, 16000, 0xFFFFFFF0, 0)
    for text, data in (("16UC1; compressedDepth png", bytes(12) + huge_png()), ("compressedDepth rvl", rvl)):
        message = SimpleNamespace(format=text, data=np.frombuffer(data, np.uint8))
        tracemalloc.start()
        with pytest.raises(edvo.Error, match="pixels"):
            messages.decode_depth(message, None)
        assert tracemalloc.get_traced_memory()[1] < 1e6
        tracemalloc.stop()


def lists(folder: Path, changes: dict[str, bytes]) -> Path:
    """Two folders of images, as only Python reads them."""
    files = {
        "rgb/0.ppm": encoded(".ppm", COLOUR),
        "depth/0.tiff": encoded(".tiff", np.full((12, 16), 1500, np.uint16)),
        "camera.toml": LENS.encode(),
    }
    for name, data in {**files, **changes}.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"camera.toml": LENS.encode() + b"#\nDepthMapFactor: 1e999\n"}, "camera.toml"),
        ({"camera.toml": LENS.encode() + b"depth_scale = 1e\n"}, "camera.toml"),
        ({"groundtruth.txt": b"1.0 \xff 0 0 0 0 0 1\n"}, r"groundtruth.txt:1.*xff"),
    ],
)
def test_folders_of_images(changes: dict[str, bytes], words: str, tmp_path: Path) -> None:
    with pytest.raises(edvo.Error, match=words):
        list(edvo.open_source(lists(tmp_path, changes)))


def test_an_image_of_another_size_costs_its_own_frame_only(tmp_path: Path) -> None:
    changes = {"rgb/1.ppm": encoded(".ppm", COLOUR[:8]), "depth/1.tiff": encoded(".tiff", DEPTH)}
    source = edvo.open_source(lists(tmp_path, changes))
    with pytest.raises(edvo.Error, match="frame 1: image of 16 x 8 px, but the camera has 16 x 12"):
        list(source)
    with pytest.raises(edvo.Error, match="of 2 frames .* 1 skipped"):
        edvo.run(source)


def test_bytes_that_are_no_utf8_are_shown_as_numbers(tmp_path: Path) -> None:
    file = tmp_path / "camera.toml"
    file.write_bytes(b"\xeb\xf7\n")
    with pytest.raises(edvo.Error, match="camera.toml"):
        edvo.Camera.read(file)


def test_stamps_in_names_that_no_clock_has_are_none() -> None:
    assert unit_of(["1305031102.175304"]) == "s"
    assert unit_of(["9999999999.5"]) is None


def test_zips_whose_names_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    file = tmp_path / "walk.zip"
    for names in (("a/0.npy", "a/0.npy/1"), ("a/" + 300 * "x" + ".npy",)):
        with zipfile.ZipFile(file, "w") as archive:
            for name in names:
                archive.writestr(name, "x")
        with pytest.raises(edvo.Error, match="walk.zip: an entry cannot be written"):
            edvo.open_source(file)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a/0.npy", bytes(80_000_000))
    with pytest.raises(edvo.Error, match="walk.zip: unpacks to more than 100 times its size"):
        edvo.open_source(file)
    needs_newer = file.read_bytes().replace(b"PK\1\2\x14\x03\x14", b"PK\1\2\x14\x03\xff")
    file.write_bytes(needs_newer)
    with pytest.raises(edvo.Error):
        edvo.open_source(file)
    assert list((tmp_path / "cache/edvo").iterdir()) == []


def test_a_finished_run_is_shown_or_its_damaged_file_is_named(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from edvo.view import show_run

    (tmp_path / "trajectory.tum").write_text("1.0 0 0 0 0 0 0 1\n")
    frames = tmp_path / "frames.jsonl"
    for line in ("{", "[]", '{"stamp": "1e300"}', '{"stamp": 1, "status": "tracked", "keyframe_reason": ""}'):
        frames.write_text(line + "\n")
        with pytest.raises(edvo.Error, match="frames.jsonl:1: damaged"):
            show_run(tmp_path, tmp_path / "run.rrd")
    frames.write_text("")
    for text in ("{", "[]", '{"evaluation": 1}'):
        (tmp_path / "summary.json").write_text(text)
        with pytest.raises(edvo.Error, match="summary.json: damaged"):
            show_run(tmp_path, tmp_path / "run.rrd")


def test_a_damaged_note_beside_a_download_is_no_bug(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    item = pulling.known_items()["tum/fr1/xyz"]
    item.file.parent.mkdir(parents=True)
    item.file.write_bytes(b"x")
    pulling.hash_file(item).write_bytes(b"\xff\xfe")
    with pytest.raises(edvo.Error, match="has changed since it was downloaded"):
        pulling.pull("tum/fr1/xyz")


@pytest.mark.parametrize(
    "fail",
    [
        lambda: struct.unpack("<I", b""),
        lambda: json.loads("[" * 100_000),
        lambda: b"\xff".decode(),
        lambda: zlib.decompress(b"x"),
        lambda: {}["K"],
        lambda: np.zeros(1 << 60),
        lambda: Path("/").read_bytes(),
    ],
)
def test_whatever_damage_raises_names_the_file_in_one_line(fail: Callable[[], object]) -> None:
    with pytest.raises(edvo.Error, match="^walk.bag: ") as caught, reading("walk.bag"):
        fail()
    assert len(str(caught.value).splitlines()) == 1 and caught.value.code == 3


def test_bugs_stay_bugs() -> None:
    with pytest.raises(AssertionError), reading("walk.bag"):
        raise AssertionError


def test_paths_may_have_any_bytes(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    from edvo.cli import main

    bag = Path(os.fsdecode(bytes(tmp_path) + b"/bad\xff.bag"))
    bag.write_bytes(b"no bag")
    folder = Path(os.fsdecode(bytes(tmp_path) + b"/dir\xff"))
    folder.mkdir()
    for path in (bag, folder / "none"):
        with pytest.raises(edvo.Error, match="bad|dir"):
            edvo.run(path)
        assert main(["run", str(path)]) == 3
        assert "edvo: " in capfd.readouterr().err
    assert len(list(edvo.open_source(lists(folder, {})))) == 1


def test_videos_that_ffmpeg_does_not_decode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    av = pytest.importorskip("av")
    from edvo.sources.videos import open_video

    file = tmp_path / "walk.mkv"
    file.write_bytes(b"\x1a\x45\xdf\xa3" * 9)
    with pytest.raises(edvo.Error, match="walk.mkv: cannot be read"), open_video(file):
        pass

    def refuse(file: str) -> None:
        raise av.error.PatchWelcomeError(1163346256, "not yet implemented", file)

    monkeypatch.setattr(av, "open", refuse)  # by no name of an error that Python knows
    with pytest.raises(edvo.Error, match="walk.mkv: cannot be read: .*not yet implemented"), open_video(file):
        pass
