# SPDX-License-Identifier: MIT
"""The table of what is fuzzed."""

from __future__ import annotations

import bag_targets
import file_targets
import folder_targets
import recording_targets
from target import Target

TARGETS: dict[str, Target] = {
    **bag_targets.TARGETS,
    **file_targets.TARGETS,
    **folder_targets.TARGETS,
    **recording_targets.TARGETS,
}
