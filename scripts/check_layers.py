#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the layers of the source tree: includes point downwards only, and the library is silent.

Usage: scripts/check_layers.py [SOURCE_ROOT]; exits with 1 and one line per violation.
"""
import re
import sys
from pathlib import Path

# Higher may include lower. A folder may include itself, not a neighbour of its own height.
HEIGHT = {
    "apps": 12, "python": 12, "benchmarks": 12, "examples": 12,
    "report": 11,
    "run": 10, "saved_map": 10,
    "slam": 9, "synth": 9, "eval": 9,
    "odometry": 8,
    "map": 7,
    "window": 6,
    "align": 5, "network": 5,
    "features": 4, "source": 4, "surface": 4,
    "image": 3, "io": 3,
    "core": 2,
    "simd": 1,
}
# Never print, never exit.
SILENT = {"simd", "core", "io", "image", "features", "network", "align", "window", "map", "odometry",
          "slam", "source", "surface", "saved_map", "run"}
MAY_TOUCH_FILES = {"io", "source", "saved_map", "report"}

INCLUDE = re.compile(r'^\s*#\s*include\s*["<](edvo/)?([^">]+)[">]')
PRINTS = re.compile(r"<iostream>|<print>|\bspdlog\b|\bstd::(cout|cerr|clog)\b"
                    r"|\b(printf|fprintf|puts|putchar)\s*\(|\bfmt::print\b")
EXITS = re.compile(r"(?<![\w.>])(?:std::)?(exit|_Exit|quick_exit|abort)\s*\(")
READS_ENVIRONMENT = re.compile(r"(?<![\w.>])(?:std::)?(getenv|secure_getenv|setenv)\s*\(")
FILES = re.compile(r"<fstream>|<cstdio>|<filesystem>|\bstd::filesystem\b|(?<![\w.>])(?:std::)?fopen\s*\(")


def without_comments_and_strings(text):
    """Blanks comments and literals (keeping include lines), so that words in them do not count."""
    def blank(match):
        token = match.group(0)
        if token.lstrip().startswith("#"):
            return token
        return re.sub(r"[^\n]", " ", token)
    pattern = re.compile(
        r'^[ \t]*#[ \t]*include[^\n]*|//[^\n]*|/\*.*?\*/|R"([^(\s]*)\(.*?\)\1"'
        r'|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'',
        re.DOTALL | re.MULTILINE)
    return pattern.sub(blank, text)


def layer_of(path, root):
    parts = path.relative_to(root).parts
    return parts[2] if parts[:2] == ("src", "edvo") else parts[0]


def problems_in(path, root):
    layer = layer_of(path, root)
    where = path.relative_to(root)
    if layer not in HEIGHT:
        yield f"{where}:1: unknown layer '{layer}', add it to scripts/check_layers.py"
        return
    in_library = where.parts[0] == "src"
    for number, line in enumerate(
            without_comments_and_strings(path.read_text(encoding="utf-8")).splitlines(), 1):
        include = INCLUDE.match(line)
        if include and include.group(1):
            other = include.group(2).split("/")[0]
            if other not in HEIGHT:
                yield f"{where}:{number}: includes unknown layer '{other}'"
            elif other != layer and HEIGHT[other] >= HEIGHT[layer]:
                yield f"{where}:{number}: layer '{layer}' must not include '{other}'"
        if not in_library:
            continue
        if layer in SILENT and PRINTS.search(line):
            yield f"{where}:{number}: '{layer}' must not print or log"
        if layer in SILENT and EXITS.search(line):
            yield f"{where}:{number}: '{layer}' must not end the program"
        if layer not in MAY_TOUCH_FILES and READS_ENVIRONMENT.search(line):
            yield f"{where}:{number}: '{layer}' must not read the environment (io, source and report may)"
        if layer not in MAY_TOUCH_FILES and FILES.search(line):
            yield f"{where}:{number}: '{layer}' must not touch the file system (io, source and report may)"


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    folders = [root / "src" / "edvo"] + [root / f for f in ("apps", "python", "benchmarks", "examples")]
    files = sorted(f for folder in folders if folder.is_dir()
                   for f in folder.rglob("*") if f.suffix in (".hpp", ".cpp", ".h", ".inl"))
    problems = [p for f in files for p in problems_in(f, root)]
    print("\n".join(problems) if problems else f"layers: {len(files)} files, no violation")
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
