# SPDX-License-Identifier: MIT
"""Layouts met in the wild, each a small sample made here."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import edvo
from edvo.sources import FolderSource, read_by_core

cv2 = pytest.importorskip("cv2")

WIDTH, HEIGHT = 64, 48
DEPTH = np.linspace(1, 3, WIDTH * HEIGHT, dtype=np.float32).reshape(HEIGHT, WIDTH)


def colour_image(value: int, size: tuple[int, int] = (WIDTH, HEIGHT)) -> np.ndarray:
    image = np.zeros((size[1], size[0], 3), np.uint8)
    image[:, :, 2] = value  # OpenCV's red
    image[:, ::2, 1] = 200
    return image


def units(per_metre: float) -> np.ndarray:
    return np.round(DEPTH * per_metre).astype(np.uint16)


def write(file: Path, image: np.ndarray) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(file), image)


def matrix(x: float) -> str:
    return f"1 0 0 {x}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


def check(path: Path, count: int, poses: int = 0, **options: object) -> edvo.Source:
    source = edvo.open_source(path, **options)  # type: ignore[arg-type]
    frames = list(source)
    assert len(frames) == count == source.frames
    for i, frame in enumerate(frames):
        assert abs(int(frame.rgb[0, 1, 0]) - 10 * (i + 1)) <= 6 and frame.rgb[0, 1, 2] <= 20
        assert np.nanmax(np.abs(frame.depth - DEPTH)) < 0.001
    assert (0 if source.ground_truth is None else len(source.ground_truth)) == poses
    return source


def test_seven_scenes(tmp_path: Path) -> None:
    for i in range(3):
        base = tmp_path / f"frame-{i:06}"
        write(base.with_suffix(".color.png"), colour_image(10 * (i + 1)))
        write(base.with_suffix(".depth.png"), units(1000))
        base.with_suffix(".pose.txt").write_text(matrix(i))
    (tmp_path / "intrinsics.txt").write_text("58.5 58.5 32 24")
    source = check(tmp_path, 3, poses=3)
    assert source.ground_truth is not None
    assert np.allclose(source.ground_truth.positions[:, 0], [0, 1, 2])


def test_replica(tmp_path: Path) -> None:
    for i in range(3):
        write(tmp_path / f"results/frame{i:06}.png", colour_image(10 * (i + 1)))
        write(tmp_path / f"results/depth{i:06}.png", units(6553.5))
    lines = [matrix(i).replace("\n", " ") for i in range(3)]
    (tmp_path / "traj.txt").write_text("\n".join(lines))
    (tmp_path / "camera.toml").write_text("fx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n")
    check(tmp_path, 3, poses=3, camera=tmp_path / "camera.toml")


def test_scannet(tmp_path: Path) -> None:
    """Colour of twice the size is shrunk to that of depth, whose camera then holds."""
    for i in range(3):
        write(tmp_path / f"color/{i}.jpg", colour_image(10 * (i + 1), (2 * WIDTH, 2 * HEIGHT)))
        write(tmp_path / f"depth/{i}.png", units(1000))
        (tmp_path / "pose").mkdir(exist_ok=True)
        (tmp_path / f"pose/{i}.txt").write_text(matrix(i))
    (tmp_path / "intrinsic").mkdir()
    for name, f in (("color", 120), ("depth", 60)):
        text = f"{f} 0 {f / 2} 0\n0 {f} {f / 2} 0\n0 0 1 0\n0 0 0 1\n"
        (tmp_path / f"intrinsic/intrinsic_{name}.txt").write_text(text)
    source = edvo.open_source(tmp_path)
    frames = list(source)
    assert len(frames) == 3 and source.camera.fx == 60 and frames[0].rgb.shape == (HEIGHT, WIDTH, 3)
    assert source.ground_truth is not None and len(source.ground_truth) == 3


def test_bundlefusion(tmp_path: Path) -> None:
    for i in range(3):
        base = tmp_path / f"frame-{i:06}"
        write(base.with_suffix(".color.jpg"), colour_image(10 * (i + 1)))
        write(base.with_suffix(".depth.png"), units(1000))
        base.with_suffix(".pose.txt").write_text(matrix(i))
    (tmp_path / "camera.toml").write_text("fx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n")
    frames = list(edvo.open_source(tmp_path))
    assert len(frames) == 3 and np.nanmax(np.abs(frames[0].depth - DEPTH)) < 0.001


def tum_lists(folder: Path, name: str) -> Path:
    path = folder / name
    for i in range(2):
        write(path / f"rgb/{i}.png", colour_image(10 * (i + 1)))
        write(path / f"depth/{i}.png", units(5000))
    for kind in ("rgb", "depth"):
        lines = [f"{1.0 + 0.1 * i:.6f} {kind}/{i}.png" for i in range(2)]
        (path / f"{kind}.txt").write_text("\n".join(lines) + "\n")
    (path / "groundtruth.txt").write_text("1.0 0 0 0 0 0 0 1\n1.1 1 0 0 0 0 0 1\n")
    (path / "camera.toml").write_text("fx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n")
    return path


def test_bonn_is_tums_layout(tmp_path: Path) -> None:
    check(tum_lists(tmp_path, "rgbd_bonn_balloon"), 2, poses=2)


def test_icl_nuim_takes_a_negative_fy(tmp_path: Path) -> None:
    path = tum_lists(tmp_path, "living_room_traj1_frei_png")
    (path / "camera.toml").write_text("fx = 60\nfy = -60\ncx = 31.5\ncy = 23.5\n")
    assert check(path, 2, poses=2, depth_scale=5000).camera.fy == -60


def test_redwood(tmp_path: Path) -> None:
    for i in range(2):
        write(tmp_path / f"image/{i:06}.jpg", colour_image(10 * (i + 1)))
        write(tmp_path / f"depth/{i:06}.png", units(1000))
    k = [60, 0, 0, 0, 61, 0, 31.5, 23.5, 1]
    camera = {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": k}
    (tmp_path / "camera_primesense.json").write_text(json.dumps(camera))
    source = edvo.open_source(tmp_path)
    assert source.camera.fy == 61 and len(list(source)) == 2


def test_open3d_recorder(tmp_path: Path) -> None:
    for i in range(2):
        write(tmp_path / f"color/{i:06}.png", colour_image(10 * (i + 1)))
        write(tmp_path / f"depth/{i:06}.png", units(1000))
    k = [60, 0, 0, 0, 61, 0, 31.5, 23.5, 1]
    camera = {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": k}
    (tmp_path / "camera_intrinsic.json").write_text(json.dumps(camera))
    assert check(tmp_path, 2).camera.fy == 61


def test_eth3d(tmp_path: Path) -> None:
    for name, image in (("rgb", colour_image(10)), ("depth", units(5000))):
        write(tmp_path / f"{name}/1.5.png", image)
        (tmp_path / f"{name}.txt").write_text(f"1.5 {name}/1.5.png\n")
    (tmp_path / "calibration.txt").write_text("72 73 31 24\n")
    (tmp_path / "groundtruth.txt").write_text("1.4 0 0 0 0 0 0 1\n1.5 1 0 0 0 0 0 1\n")
    assert check(tmp_path, 1, poses=2).camera.fx == 72


def write_exr(file: Path, depth: np.ndarray) -> None:
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    file.parent.mkdir(parents=True, exist_ok=True)
    OpenEXR.File(header, {"R": np.ascontiguousarray(depth)}).write(str(file))


@pytest.mark.parametrize("suffix", [".tiff", ".exr", ".npy", ".pgm"])
def test_other_depth_formats(suffix: str, tmp_path: Path) -> None:
    for i in range(2):
        write(tmp_path / f"rgb/{i}.ppm", colour_image(10 * (i + 1)))
        file = tmp_path / f"depth/{i}{suffix}"
        file.parent.mkdir(exist_ok=True)
        if suffix == ".npy":
            np.save(file, DEPTH)
        elif suffix == ".pgm":
            write(file, units(1000))
        elif suffix == ".exr":
            write_exr(file, DEPTH)
        else:
            write(file, DEPTH)
    (tmp_path / "camera.toml").write_text("fx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n")
    assert not read_by_core(tmp_path)
    check(tmp_path, 2)


CAMERA = "fx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n"


def test_depth_scale_of_the_camera_file_holds_for_other_formats(tmp_path: Path) -> None:
    for i in range(2):
        write(tmp_path / f"rgb/{i}.png", colour_image(10 * (i + 1)))
        write(tmp_path / f"depth/{i}.tiff", units(5000))
    (tmp_path / "camera.toml").write_text(CAMERA + "depth_scale = 5000\n")
    source = check(tmp_path, 2)
    assert "depth in 5000 units per metre (depth_scale in camera.toml)" in source.notes
    for i in range(2):
        write(tmp_path / f"depth/{i}.tiff", DEPTH)  # floats are metres
    check(tmp_path, 2)


@pytest.mark.parametrize(("unit", "factor"), [("ms", 10**6), ("us", 10**3), ("ns", 1)])
def test_names_that_are_stamps_are_paired_by_time(unit: str, factor: int, tmp_path: Path) -> None:
    start, period = 1_700_000_000_000_000_000, 33_000_000
    for i in range(3):
        write(tmp_path / f"rgb/{(start + i * period) // factor}.png", colour_image(10 * (i + 1)))
        write(tmp_path / f"depth/{(start + i * period + 4_000_000) // factor}.png", units(1000))
    write(tmp_path / f"rgb/{(start + 9 * period) // factor}.png", colour_image(200))
    (tmp_path / "camera.toml").write_text(CAMERA)
    (tmp_path / "groundtruth.txt").write_text("1700000000.0 0 0 0 0 0 0 1\n")
    source = check(tmp_path, 3, poses=1)
    assert [frame.stamp_ns for frame in source] == [start + i * period for i in range(3)]
    assert source.notes[0].startswith("3 pairs of 4 colour and 3 depth images, depth +4 ms")


def test_stamps_without_a_common_time_are_named(tmp_path: Path) -> None:
    write(tmp_path / "rgb/1700000000000000000.png", colour_image(10))
    write(tmp_path / "depth/1700000100000000000.png", units(1000))
    (tmp_path / "camera.toml").write_text(CAMERA)
    with pytest.raises(edvo.Error, match=r"\+100\.000 s from colour"):
        edvo.open_source(tmp_path)


@pytest.mark.parametrize(("colour", "depth"), [("RGB", "Depth"), ("images", "depth_images")])
def test_other_names_of_folders(colour: str, depth: str, tmp_path: Path) -> None:
    for i in range(2):
        write(tmp_path / f"{colour}/{i}.png", colour_image(10 * (i + 1)))
        write(tmp_path / f"{depth}/{i}.png", units(1000))
    (tmp_path / "camera.toml").write_text(CAMERA)
    check(tmp_path, 2)


def test_depth_as_jpeg_is_refused(tmp_path: Path) -> None:
    for kind in ("rgb", "depth"):
        write(tmp_path / f"{kind}/0.jpg", colour_image(10))
    with pytest.raises(edvo.Error, match="depth as JPEG, a picture of depth"):
        edvo.open_source(tmp_path)


def test_a_depth_camera_of_another_size_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "rgb/0.png", colour_image(10))
    write(tmp_path / "depth/0.png", np.full((24, 32), 2000, np.uint16))
    (tmp_path / "depth.txt.cal").write_text("60 60 31.5 23.5\n")
    camera = edvo.Camera(60, 60, 31.5, 23.5, WIDTH, HEIGHT)
    for wrong in (camera, tmp_path / "depth.txt.cal"):
        with pytest.raises(edvo.Error, match="--depth-camera.* for (about )?64 x 48 px"):
            edvo.open_source(tmp_path, camera=camera, depth_camera=wrong)


def test_depth_of_a_camera_of_its_own(tmp_path: Path) -> None:
    write(tmp_path / "rgb/0.png", colour_image(10))
    write(tmp_path / "depth/0.png", np.full((24, 32), 2000, np.uint16))
    camera = edvo.Camera(60, 60, 31.5, 23.5, WIDTH, HEIGHT)
    with pytest.raises(edvo.Error, match="64 x 48"):
        edvo.open_source(tmp_path, camera=camera)
    source = edvo.open_source(
        tmp_path, camera=camera, depth_camera=edvo.Camera(30, 30, 15.5, 11.5, 32, 24)
    )
    depth = next(iter(source)).depth
    assert np.isfinite(depth[1:-1, 1:-1]).all() and np.nanmax(np.abs(depth - 2)) < 1e-5


def test_depth_of_a_camera_of_its_own_keeps_stamps_and_poses(tmp_path: Path) -> None:
    """Of colour's size: the layouts that the C++ library reads, here 7-Scenes'."""
    for i in range(2):
        write(tmp_path / f"frame-{i:06}.color.png", colour_image(10))
        write(tmp_path / f"frame-{i:06}.depth.png", np.full((HEIGHT, WIDTH), 2000, np.uint16))
        np.savetxt(tmp_path / f"frame-{i:06}.pose.txt", np.eye(4))
    camera = edvo.Camera(60, 60, 31.5, 23.5, WIDTH, HEIGHT)
    wide = edvo.Camera(30, 30, 31.5, 23.5, WIDTH, HEIGHT)
    moved = np.eye(4)
    moved[2, 3] = 0.5
    source = edvo.open_source(
        tmp_path, camera=camera, depth_camera=wide, colour_from_depth=moved
    )
    assert source.ground_truth is not None and len(source.ground_truth) == 2
    assert "depth is registered to colour here" in source.notes
    depths = [frame.depth for frame in source]
    assert len(depths) == 2 and np.nanmax(np.abs(depths[1] - 2.5)) < 1e-5
    assert np.isfinite(depths[1]).mean() > 0.9


def test_smaller_depth_of_a_camera_of_its_own_keeps_stamps(tmp_path: Path) -> None:
    """Of a list with stamps, as exports of phones are converted to."""
    for kind, image in (("rgb", colour_image(10)), ("depth", np.full((24, 32), 2000, np.uint16))):
        write(tmp_path / f"{kind}/0.png", image)
        (tmp_path / f"{kind}.txt").write_text(f"12.250000 {kind}/0.png\n")
    source = edvo.open_source(
        tmp_path,
        camera=edvo.Camera(60, 60, 31.5, 23.5, WIDTH, HEIGHT),
        depth_scale=1000,
        depth_camera=edvo.Camera(30, 30, 15.5, 11.5, 32, 24),
    )
    frame = next(iter(source))
    assert frame.stamp_ns == 12_250_000_000 and frame.rgb.shape[:2] == frame.depth.shape
    assert np.nanmax(np.abs(frame.depth[1:-1, 1:-1] - 2)) < 1e-5


def test_a_damaged_image_costs_its_own_frame_only_with_a_depth_camera_too(tmp_path: Path) -> None:
    for i in range(3):
        write(tmp_path / f"rgb/{i}.png", colour_image(10))
        write(tmp_path / f"depth/{i}.png", np.full((HEIGHT, WIDTH), 2000, np.uint16))
    file = tmp_path / "depth/1.png"
    file.write_bytes(file.read_bytes()[:60])
    camera = edvo.Camera(60, 60, 31.5, 23.5, WIDTH, HEIGHT)
    source = edvo.open_source(tmp_path, camera=camera, depth_scale=1000, depth_camera=camera)
    with pytest.raises(edvo.Error, match="of 3 frames .* 1 skipped"):
        edvo.run(source)


def record3d(folder: Path) -> Path:
    lzfse = pytest.importorskip("liblzfse")
    k = [60, 0, 0, 0, 60, 0, 31.5, 23.5, 1]
    meta = {"w": WIDTH, "h": HEIGHT, "dw": 32, "dh": 24, "fps": 30, "K": k}
    meta["poses"] = [[0, 0, 0, 1, i, 0, 0] for i in range(2)]
    meta["frameTimestamps"] = [5.0, 5.1]
    file = folder / "phone.r3d"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("metadata", json.dumps(meta))
        for i in range(2):
            jpeg = cv2.imencode(".jpg", np.full((HEIGHT, WIDTH, 3), 80, np.uint8))[1]
            archive.writestr(f"rgbd/{i}.jpg", jpeg.tobytes())
            depth = np.full((24, 32), 1.25, np.float32)
            archive.writestr(f"rgbd/{i}.depth", lzfse.compress(depth.tobytes()))
    return file


def test_record3d(tmp_path: Path) -> None:
    source = edvo.open_source(record3d(tmp_path))
    frames = list(source)
    assert [frame.stamp_ns for frame in frames] == [5_000_000_000, 5_100_000_000]
    assert np.nanmedian(frames[0].depth) == pytest.approx(1.25)
    assert source.ground_truth is not None
    # ARKit's camera looks along its -z axis.
    assert np.allclose(source.ground_truth.poses[1][:3, 2], [0, 0, -1], atol=1e-9)


def test_record3d_exported_with_exr(tmp_path: Path) -> None:
    """As the app writes it: depth of half precision; an image may be missing."""
    k = [60, 0, 0, 0, 60, 0, 31.5, 23.5, 1]
    poses = [[0, 0, 0, 1, 0.1 * i, 0, 0] for i in range(3)]
    meta = {"w": WIDTH, "h": HEIGHT, "dw": 32, "dh": 24, "K": k, "fps": 60, "poses": poses}
    (tmp_path / "metadata.json").write_text(json.dumps({**meta, "frameTimestamps": [5.0, 5.1, 5.2]}))
    for i in (0, 2):
        write(tmp_path / f"rgb/{i}.jpg", colour_image(40 * i))
        write_exr(tmp_path / f"depth/{i}.exr", np.full((24, 32), 0.25, np.float16))
    source = edvo.open_source(tmp_path)
    frames = list(source)
    assert [frame.stamp_ns for frame in frames] == [5_000_000_000, 5_200_000_000]
    assert frames[0].rgb.shape == (HEIGHT, WIDTH, 3)
    assert np.nanmedian(frames[1].depth) == pytest.approx(0.25)
    assert source.ground_truth is not None
    assert np.allclose(source.ground_truth.positions[1], [0.2, 0, 0], atol=1e-9)
    (tmp_path / "depth/0.exr").write_bytes(b"v/1")
    with pytest.raises(edvo.Error, match="0.exr: cannot be decoded"):
        list(edvo.open_source(tmp_path))


def test_stray_scanner(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    with av.open(str(tmp_path / "rgb.mp4"), "w") as video:
        stream = video.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for value in (60, 120):
            picture = np.full((HEIGHT, WIDTH, 3), value, np.uint8)
            video.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        video.mux(stream.encode())
    for i in range(2):
        write(tmp_path / f"depth/{i:06}.png", np.full((24, 32), 1500, np.uint16))
    (tmp_path / "camera_matrix.csv").write_text("60,0,31.5\n0,60,23.5\n0,0,1\n")
    (tmp_path / "odometry.csv").write_text(
        "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
        "1.0, 0, 0, 0, 0, 0, 0, 0, 1\n1.1, 1, 0.5, 0, 0, 0, 0, 0, 1\n"
    )
    source = edvo.open_source(tmp_path)
    frames = list(source)
    assert [frame.stamp_ns for frame in frames] == [1_000_000_000, 1_100_000_000]
    assert [int(np.median(f.rgb)) // 10 for f in frames] in ([6, 12], [5, 11], [6, 11], [5, 12])
    assert np.nanmedian(frames[1].depth) == pytest.approx(1.5)


def zipped(folder: Path, file: Path) -> Path:
    with zipfile.ZipFile(file, "w") as archive:
        for name in sorted(folder.rglob("*")):
            archive.write(name, Path("my recording") / name.relative_to(folder))
        archive.writestr("__MACOSX/._rgb", "x")
    return file


def test_zips_of_what_only_python_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "images"
    for i in range(2):
        write(folder / f"rgb/{i}.png", colour_image(10 * (i + 1)))
        write(folder / f"depth/{i}.tiff", DEPTH)
    (folder / "camera.toml").write_text("fx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n")
    file = zipped(folder, tmp_path / "walk.zip")
    assert not read_by_core(file)
    for _ in range(2):  # unpacked once
        source = check(file, 2)
        assert source.name == "walk" and f"unpacked from {file}" in source.notes
    assert len(list((tmp_path / "cache/edvo").iterdir())) == 1


def test_zips_that_cannot_be_unpacked_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    file = tmp_path / "walk.zip"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("walk/depth/0.npy", "x" * 1000)
    whole = file.read_bytes()
    file.write_bytes(whole.replace(b"xxx", b"xyx", 1))
    with pytest.raises(edvo.Error, match="walk.zip: damaged"):
        edvo.open_source(file)
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr("../depth/0.npy", "x")
    with pytest.raises(edvo.Error, match="would be written outside"):
        edvo.open_source(file)
    assert list((tmp_path / "cache/edvo").iterdir()) == []


def test_zips_of_folders_that_the_program_reads_are_left_to_it(tmp_path: Path) -> None:
    folder = tum_lists(tmp_path, "sequence")
    assert read_by_core(zipped(folder, tmp_path / "sequence.zip"))
    (tmp_path / "broken.zip").write_bytes(b"PK")
    assert read_by_core(tmp_path / "broken.zip")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: (p / "x.mkv").write_bytes(b"") or p / "x.mkv", "x.mkv: cannot be read"),
        (lambda p: (p / "d-1.5-2.pgm").write_bytes(b"P5") and p, "NYU's raw recordings"),
        (lambda p: p, "no RGB-D sequence here"),
        (lambda p: p / "missing", "no such folder"),
    ],
)
def test_what_is_not_read_is_said_in_one_sentence(make, words: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(edvo.Error, match=words) as caught:
        edvo.open_source(make(tmp_path))
    assert "\n" not in str(caught.value)


def test_folders_of_the_program_are_left_to_it(sequence: Path) -> None:
    assert read_by_core(sequence)
    source = FolderSource(sequence)
    assert source.frames == 64 and source.ground_truth is not None


@pytest.mark.parametrize(
    ("lines", "first"),
    [
        ("0 1758743290.320641\n1 1758743290.5\n2 1758743291.25\n", 1_758_743_290_320_641_000),
        ("# index, time\n2,1758743291.25\n0,1758743290.320641\n1,1758743290.5\n", 1_758_743_290_320_641_000),
        ("0 1758743290.3\n1 1758743290.5\n", 0),  # of one image there is none
        ("0 1758743290.3\n1 1758743290.5\n2 1758743290.5\n", 0),
    ],
)  # fmt: skip
def test_stamps_that_a_recorder_wrote_beside_numbered_images(
    lines: str, first: int, tmp_path: Path
) -> None:
    for i in range(3):
        write(tmp_path / f"color/{i}.png", colour_image(10 * (i + 1)))
        write(tmp_path / f"depth/{i}.tiff", units(1000))
    (tmp_path / "intrinsic").mkdir()
    (tmp_path / "intrinsic/camera.txt").write_text("58.5 58.5 32 24")
    (tmp_path / "timestamps.txt").write_text(lines)
    source = check(tmp_path, 3)
    assert next(iter(source)).stamp_ns == first and source.camera.fx == 58.5
    assert any(("timestamps.txt" if first else "no time stamps") in note for note in source.notes)
