# SPDX-License-Identifier: MIT
"""Edge-direct visual odometry for RGB-D cameras.

    run = edvo.run("recording.bag")  # a folder, an archive, a bag, a phone's recording
    run.trajectory.poses  # N x 4 x 4, world_from_camera

    odometry = edvo.Odometry(edvo.Camera(525, 525, 319.5, 239.5, 640, 480))
    result = odometry.process(stamp, rgb, depth)  # seconds, H x W x 3 uint8, H x W float32 [m]
    result.pose  # 4 x 4, world_from_camera
"""

from edvo import _core
from edvo.camera import Camera
from edvo.detector import EdgeDetector
from edvo.doctor import Finding, diagnose
from edvo.errors import Error
from edvo.evaluation import Evaluation, Statistics, evaluate
from edvo.observer import Image, Keyframe, KeyframePose, Observer, SourceInfo
from edvo.odometry import FrameResult, LevelStats, Link, Odometry, Options, Slam
from edvo.registration import DepthRegistration, register_depth
from edvo.runner import Run, run
from edvo.sources import Frame, Source, open_source
from edvo.trajectory import Trajectory

__version__: str = _core.version

__all__ = [
    "Camera",
    "DepthRegistration",
    "EdgeDetector",
    "Error",
    "Evaluation",
    "Finding",
    "Frame",
    "FrameResult",
    "Image",
    "Keyframe",
    "KeyframePose",
    "LevelStats",
    "Link",
    "Observer",
    "Odometry",
    "Options",
    "Run",
    "Slam",
    "Source",
    "SourceInfo",
    "Statistics",
    "Trajectory",
    "diagnose",
    "evaluate",
    "open_source",
    "register_depth",
    "run",
]
