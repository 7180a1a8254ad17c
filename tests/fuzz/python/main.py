# SPDX-License-Identifier: MIT
"""Runs one fuzzer: main.py NAME CORPUS FINDINGS [FLAG OF LIBFUZZER...]. It goes on after a finding and
keeps the first input of each kind. --list prints the names, and --only NAME FILE... tries files again
without Atheris."""

from __future__ import annotations

import os
import resource
import shutil
import sys
import tempfile
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

# One thread each: several fuzzers run at a time.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[name] = "1"
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[2] / "python/tests")]
ADDRESS_SPACE = 16 << 30  # [bytes]; what asks for more gets MemoryError, on each machine alike

if TYPE_CHECKING:
    from target import Target


class Scratch:
    """A folder for each input, in one that nothing else may be written to."""

    def __init__(self) -> None:
        self.root = Path(tempfile.mkdtemp(prefix="edvo-fuzz-"))
        self.work = self.root / "here/work"
        self.temporary = self.root / "temporary"  # of the readers
        self.clear()
        tempfile.tempdir = os.environ["TMPDIR"] = str(self.temporary)
        os.environ["XDG_CACHE_HOME"] = str(self.work / "cache")

    def clear(self) -> None:
        for folder in (self.work.parent, self.temporary):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
        self.work.mkdir()

    def run(self, target: Target, data: bytes) -> None:
        from checks import require, watched

        try:
            with watched():
                target.test(data, self.work)
            places = (self.root, self.work.parent, self.temporary)
            found = {str(path.relative_to(self.root)) for place in places for path in place.iterdir()}
            require(found == {"here", "here/work", "temporary"}, f"left or written: {sorted(found)}")
        finally:
            self.clear()


class Findings:
    """Files of what is found, one of each kind: of an exception and the line that raised it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.kinds: set[str] = set()

    def add(self, error: BaseException, data: bytes) -> None:
        calls = traceback.extract_tb(error.__traceback__)
        own = [call for call in calls if "site-packages/edvo/" in call.filename] or calls
        kind = f"{type(error).__name__} {own[-1].filename}:{own[-1].lineno}"
        if type(error).__name__ == "Broken":
            kind += f" {str(error)[:20]}"
        if kind in self.kinds:
            return
        self.kinds.add(kind)
        traceback.print_exception(error)
        name = f"{type(error).__name__}-{Path(own[-1].filename).stem}-{own[-1].lineno}-{len(self.kinds)}"
        file = self.folder / name
        file.write_bytes(data)
        print(f"FINDING {len(self.kinds)}: {file}", file=sys.stderr, flush=True)


def import_targets(is_fuzzing: bool) -> dict[str, Target]:
    if not is_fuzzing:
        from targets import TARGETS
    else:
        import atheris

        with atheris.instrument_imports(include=["edvo", "rosbags", "mcap"], enable_loader_override=False):
            from targets import TARGETS
    return TARGETS


def main(arguments: list[str]) -> None:
    if arguments == ["--list"]:
        print("\n".join(import_targets(False)))
        return
    is_fuzzing = arguments[0] != "--only"
    name, *rest = arguments if is_fuzzing else arguments[1:]
    target = import_targets(is_fuzzing)[name]
    scratch = Scratch()
    seeds = target.seeds(scratch.work)
    scratch.clear()
    for seed in seeds[:1]:  # imports what it needs: that is nothing that an input takes
        target.test(seed, scratch.work)
        scratch.clear()
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    if is_fuzzing:
        fuzz(target, scratch, seeds, name, *rest)
        return
    for file in rest:
        scratch.run(target, Path(file).read_bytes())
    shutil.rmtree(scratch.root)


def fuzz(target: Target, scratch: Scratch, seeds: list[bytes], name: str, *arguments: str) -> None:
    import atheris

    corpus, place, *flags = arguments
    findings = Findings(Path(place))

    def one_input(data: bytes) -> None:
        try:
            scratch.run(target, data)
        except Exception as error:  # noqa: BLE001: that is what is looked for
            findings.add(error, data)

    for i, seed in enumerate(seeds):
        (Path(corpus) / f"seed-{i}").write_bytes(seed)
    atheris.Setup([name, corpus, *flags], one_input)
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1:])
