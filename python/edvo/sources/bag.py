# SPDX-License-Identifier: MIT
"""RGB-D in ROS 1 and ROS 2 recordings, without ROS; RealSense's own .bag among them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera, read_scaled
from edvo.errors import Error
from edvo.registration import DepthRegistration
from edvo.sources import messages
from edvo.sources.bag_cameras import info_camera
from edvo.sources.bag_reader import open_bag
from edvo.sources.bag_topics import choose_topics, left_out, nearest_info
from edvo.sources.base import Arrays, Frame, Source, require_size
from edvo.sources.depth_cameras import Size, check_size, read_depth_camera
from edvo.sources.pairing import Message, Topics, messages_of, pair, pair_bag, reads
from edvo.sources.references import find_reference
from edvo.sources.transforms import TransformTree
from edvo.sources.untrusted import reading

MOST_DAMAGED = 30  # messages at the start of a topic that may be damaged
IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
TF = "tf2_msgs/msg/TFMessage"


class BagSource(Source):
    """Topics are guessed from types, encodings and names, and can be chosen.

    Depth in metres (32FC1) or millimetres (16-bit) unless ``depth_scale`` says otherwise; depth of
    a camera of its own is registered to colour by TF or the recording's extrinsics.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        camera: Camera | str | Path | None = None,
        camera_size: tuple[int, int] = (0, 0),
        depth_scale: float | None = None,
        colour_topic: str | None = None,
        depth_topic: str | None = None,
        depth_camera: Camera | str | Path | None = None,
        colour_from_depth: NDArray[np.float64] | None = None,
    ) -> None:
        super().__init__()
        self._camera_size = camera_size
        self._depth_camera = depth_camera
        self._given_motion = colour_from_depth
        self._path = Path(path)
        self.name = self._path.stem
        self.units_per_metre = depth_scale  # None: of floats, which are metres
        with reading(path), open_bag(self._path) as reader:
            first = first_messages(reader, IMAGES)
            chosen = choose_topics(reader, first, colour_topic, depth_topic, self._path)
            self._colour, self._depth = chosen
            self._tree = read_tree(reader)
            self._choose_units(reader, first[self._depth])
            self._choose_cameras(reader, camera, first)
            self._find_truth(reader, first[self._colour].header.frame_id)
            topics = Topics(self._colour, self._depth)
            pairing, pairs = pair_bag(reader, topics, self._path)
            self._topics, self.stamps_ns = pairing.topics, pairing.stamps_ns
            self.frames = len(self.stamps_ns)
            self.depth_delay_ns = pairing.depth_delay_ns
        self.origin = f"{path} ({self._colour}, {self._depth})"
        said = f"colour from {self._colour}, depth from {self._depth}"
        self.notes[:0] = [note for note in (said, left_out(first, chosen), pairs) if note]

    def _choose_units(self, reader: Any, message: Any) -> None:
        if self.units_per_metre is not None:
            self.notes.append(f"depth: {self.units_per_metre} units per metre (as given)")
            return
        compressed = getattr(message, "format", "").startswith("32FC1")
        if compressed or getattr(message, "encoding", "") == "32FC1":
            self.notes.append("depth: metres (32FC1)")
            return
        for name, topic in reader.topics.items():
            if "Depth_Units" in name or "Depth Units" in name:
                if topic.msgtype and topic.msgtype.endswith("Float32"):
                    value = float(first_message(reader, name).data)
                    if not 1e-9 < value < 1e9:
                        raise Error(f"{self._path}: {name}: {value} m is no unit; give --depth-scale", 3)
                    self.units_per_metre = float(np.float32(1) / np.float32(value))
                    self.notes.append(f"depth: {self.units_per_metre:g} units per metre ({name})")
                    return
        self.units_per_metre = messages.MILLIMETRES
        self.notes.append("depth: millimetres (16-bit; --depth-scale says otherwise)")

    def _choose_cameras(
        self, reader: Any, camera: Camera | str | Path | None, first: dict[str, Any]
    ) -> None:
        colour = first_decoded(reader, self._colour, messages.decode_colour)
        depth = first_decoded(
            reader, self._depth, lambda message: messages.decode_depth(message, self.units_per_metre)
        )
        info = nearest_info(reader, self._colour)
        size = (colour.shape[1], colour.shape[0])
        if camera is not None:
            self.camera = read_scaled(camera, self._camera_size, size)
            check_size(self.camera, size, "the camera (--camera)")
            if not isinstance(camera, Camera):
                self.camera_origin = f"{camera}, as given"
        elif info is not None:
            message = first_message(reader, info)
            names = (info, self._colour)
            self.camera = info_camera(message, *names, size, self._camera_size, "--camera")
            self.camera_origin = f"CameraInfo of {info}"
        else:
            raise Error(
                f"{self._path}: no CameraInfo beside {self._colour}; give the calibration "
                "with --camera FILE",
                code=5,
            )
        self._registration = self._find_registration(reader, first, (depth.shape[1], depth.shape[0]))

    def _find_registration(
        self, reader: Any, first: dict[str, Any], size: Size
    ) -> DepthRegistration | None:
        """None where depth, of a width and height, is registered already."""
        if self._depth_camera is not None:
            own = read_depth_camera(self._depth_camera, size)
            self.notes.append("depth is registered to colour here, as given")
            return DepthRegistration(own, self.camera, self._given_motion)
        same_size = size == (self.camera.width, self.camera.height)
        if any(word in self._depth for word in ("aligned", "registered")) and same_size:
            self.notes.append("depth is registered to colour (by the name of its topic)")
            return None
        depth_camera = self._own_depth_camera(reader, first, size)
        if depth_camera is None:
            return None
        motion = self._colour_from_depth(reader, first)
        has_same_camera = same_size and np.allclose(
            depth_camera.matrix, self.camera.matrix, atol=0.5
        )
        if has_same_camera and (motion is None or np.allclose(motion, np.eye(4), atol=1e-4)):
            self.notes.append("depth has the camera of colour: it is taken as registered")
            return None
        if motion is None:
            self.warnings.append(
                "depth has another camera than colour, and no transform between them is known: "
                "they are taken as being in one place"
            )
            motion = np.eye(4)
        self.notes.append(
            "depth is registered to colour here: baseline "
            f"{1000 * float(np.linalg.norm(motion[:3, 3])):.1f} mm"
        )
        return DepthRegistration(depth_camera, self.camera, motion)

    def _own_depth_camera(self, reader: Any, first: dict[str, Any], size: Size) -> Camera | None:
        """Of the CameraInfo beside depth; None where it has none and is taken as registered."""
        info = nearest_info(reader, self._depth)
        same_size = size == (self.camera.width, self.camera.height)
        why = f"no CameraInfo beside {self._depth}"
        if info is not None and info != nearest_info(reader, self._colour):
            message = first_message(reader, info)
            names = (info, self._depth)
            try:
                return info_camera(message, *names, size, self._camera_size, "--depth-camera")
            except Error as error:
                why = str(error)
        elif first[self._colour].header.frame_id == first[self._depth].header.frame_id and same_size:
            self.notes.append("depth has the frame of colour: it is taken as registered")
            return None
        if not same_size:
            raise Error(
                f"{self._path}: depth has {size[0]} x {size[1]} pixels, colour {self.camera.width} x "
                f"{self.camera.height}; {why}; --depth-camera FILE and --colour-from-depth FILE say "
                "how they belong together",
                code=5,
            )
        self.warnings.append(f"{why}: depth is taken as registered to colour")
        return None

    def _colour_from_depth(self, reader: Any, first: dict[str, Any]) -> NDArray[np.float64] | None:
        # RealSense's recorder: x_stream = transform * x_reference, one message a stream.
        names = [t.rsplit("/image/", 1)[0] + "/tf/0" for t in (self._colour, self._depth)]
        kinds = [reader.topics[name].msgtype for name in names if name in reader.topics]
        if kinds == ["geometry_msgs/msg/Transform"] * 2:
            colour, depth = (first_message(reader, name) for name in names)
            a = messages.pose_from(colour.translation, colour.rotation)
            b = messages.pose_from(depth.translation, depth.rotation)
            return np.asarray(a @ np.linalg.inv(b))
        return self._tree.between(
            first[self._colour].header.frame_id, first[self._depth].header.frame_id
        )

    def _find_truth(self, reader: Any, camera_frame: str) -> None:
        found = find_reference(reader, self._tree, camera_frame)
        if found is None:
            return
        self.ground_truth, self.ground_truth_origin = found.trajectory, found.origin
        self.is_reference_only = bool(found.flaw)
        self.notes += [note for note in (found.origin, found.note) if note]

    def _pairs(self) -> Iterator[tuple[Message, Message]]:
        with open_bag(self._path) as reader:
            yield from pair(messages_of(reader, self._topics))

    def _frame(self, colour: Message, depth: Message) -> Frame:
        with reading(self._depth):
            metric = messages.decode_depth(depth.read(), self.units_per_metre)
            if self._registration is not None:
                metric = self._registration(metric)
        with reading(self._colour):
            rgb = messages.decode_colour(colour.read())
        topics = f"{self._colour} and {self._depth}"
        return require_size(Frame(colour.stamp_ns, rgb, metric), self.camera, topics)

    def __iter__(self) -> Iterator[Frame]:
        for colour, depth in self._pairs():
            yield self._frame(colour, depth)

    def _pending(self) -> Iterator[tuple[int, int, Callable[[], Arrays]]]:
        for colour, depth in self._pairs():
            read = partial(self._frame, colour, depth)
            yield colour.stamp_ns, 9, self._loader(read)


def first_message(reader: Any, topic: str) -> Any:
    return first_decoded(reader, topic, lambda message: message)


def first_decoded(reader: Any, topic: str, decode: Callable[[Any], Any]) -> Any:
    """Of the first messages, the first that is not damaged."""
    failure = Error(f"{topic}: no message", code=3)
    connections = [c for c in reader.connections if c.topic == topic]
    for connection, _, raw in islice(reader.messages(connections=connections), MOST_DAMAGED):
        try:
            with reading(topic):
                return decode(reads(reader, topic, raw, connection.msgtype)())
        except Error as error:
            failure = error
    raise failure


def first_messages(reader: Any, kinds: tuple[str, ...]) -> dict[str, Any]:
    return {
        name: first_message(reader, name)
        for name, topic in reader.topics.items()
        if topic.msgtype in kinds and topic.msgcount > 0
    }


def read_tree(reader: Any) -> TransformTree:
    tree = TransformTree()
    connections = [c for c in reader.connections if c.msgtype in (TF, "tf/msg/tfMessage")]
    if not connections:
        return tree
    for connection, _, raw in reader.messages(connections=connections):
        try:
            links = reads(reader, connection.topic, raw, connection.msgtype)().transforms
        except Error:
            continue  # a damaged message costs its own transforms only
        for link in links:
            try:
                pose = messages.pose_from(link.transform.translation, link.transform.rotation)
            except Error:
                continue
            tree.add(link.header.frame_id, link.child_frame_id, messages.stamp_ns(link), pose)
    return tree
