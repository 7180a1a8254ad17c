#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints what pyproject.toml asks for, one requirement a line: to build, to run, and of EXTRA...

    scripts/requirements.py test
"""

import pathlib
import re
import sys

try:
    import tomllib
except ImportError:  # before Python 3.11
    import tomli as tomllib


def requirements(project: dict, extras: list[str]) -> list[str]:
    """Extras that name extras of edvo itself are followed."""
    found = list(project["build-system"]["requires"]) + list(project["project"]["dependencies"])
    left, done = list(extras), set()
    while left:
        extra = left.pop()
        if extra in done:
            continue
        done.add(extra)
        for line in project["project"]["optional-dependencies"][extra]:
            own = re.fullmatch(r"edvo\[(.+)\]", line)
            if own:
                left += own[1].split(",")
            else:
                found.append(line)
    return list(dict.fromkeys(found))


if __name__ == "__main__":
    root = pathlib.Path(__file__).resolve().parent.parent
    text = (root / "pyproject.toml").read_text(encoding="utf-8")
    print("\n".join(requirements(tomllib.loads(text), sys.argv[1:])))
