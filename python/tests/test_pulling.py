# SPDX-License-Identifier: MIT
"""Downloads from a local server that misbehaves."""

from __future__ import annotations

import hashlib
import json
import tarfile
import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

import edvo
from edvo import pulling
from edvo.cli import main

BODY = bytes(i * i % 251 for i in range(600_000))
NAME = "tum/fr1/xyz"


class Server(ThreadingHTTPServer):
    """Serves BODY; what it does wrong is in its attributes."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.body = BODY
        self.tag = '"1"'
        self.knows_ranges = True
        self.cuts: list[int] = []  # after so many bytes, one for each answer
        self.statuses: list[int] = []  # instead of the file, one for each answer
        self.stalls = False
        self.sends_length = True
        self.length = ""  # that is said instead of the right one
        self.ranges: list[str | None] = []  # that were asked for

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}/file.tgz"


class Handler(BaseHTTPRequestHandler):
    server: Server

    def log_message(self, *_: object) -> None:
        pass

    def do_GET(self) -> None:
        server, asked = self.server, self.headers.get("Range")
        server.ranges.append(asked)
        if server.statuses:
            self.send_error(server.statuses.pop(0))
            return
        start = 0
        matches = self.headers.get("If-Range") in (None, server.tag)
        if asked and server.knows_ranges and matches:
            start = int(asked.removeprefix("bytes=").removesuffix("-"))
        self.send_response(206 if start else 200)
        if server.tag:
            self.send_header("ETag", server.tag)
        if server.sends_length:
            self.send_header("Content-Length", server.length or str(len(server.body) - start))
        self.end_headers()
        end = start + server.cuts.pop(0) if server.cuts else len(server.body)
        self.wfile.write(server.body[start:end])
        self.wfile.flush()
        if server.stalls:
            time.sleep(3)
        self.close_connection = True


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(pulling, "PAUSE", 0.01)
    with Server() as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def pull(server: Server, name: str = NAME, **options: object) -> Path:
    return pulling.pull(name, url=server.url, quiet=True, **options)  # type: ignore[arg-type]


def folder() -> Path:
    return pulling.known_items()[NAME].file.parent


def leftovers() -> list[str]:
    return sorted(file.name for file in folder().iterdir() if ".part" in file.name)


def test_a_damaged_length_and_notes_of_an_earlier_try_are_no_bug(server: Server) -> None:
    server.length = "many"
    folder().mkdir(parents=True)
    item = pulling.known_items()[NAME]
    item.file.with_name(item.file.name + ".part").write_bytes(b"old")
    item.file.with_name(item.file.name + ".part.tag").write_bytes(b"\xff\xfe\n")
    assert pull(server).read_bytes() == BODY and server.ranges == [None]


def test_a_file_is_fetched_once_and_its_hash_kept(server: Server) -> None:
    file = pull(server)
    assert file.name == "rgbd_dataset_freiburg1_xyz.tgz" and file.read_bytes() == BODY
    note = file.with_name(file.name + ".sha256")
    assert note.read_text().strip() == hashlib.sha256(BODY).hexdigest()
    assert pull(server) == file and server.ranges == [None] and leftovers() == []
    file.write_bytes(b"damaged")
    with pytest.raises(edvo.Error, match="has changed since it was downloaded"):
        pull(server)


def test_a_cut_connection_goes_on_by_itself(server: Server) -> None:
    server.cuts = [6 * pulling.BLOCK, 3 * pulling.BLOCK]
    assert pull(server).read_bytes() == BODY
    assert server.ranges == [None, f"bytes={6 * pulling.BLOCK}-", f"bytes={9 * pulling.BLOCK}-"]


def test_what_is_there_is_kept_for_the_next_time(server: Server) -> None:
    server.cuts = [100_000, 0, 0]
    with pytest.raises(edvo.Error, match="was cut; 0.1 MB are kept, the same command goes on") as e:
        pull(server)
    assert e.value.code == 6
    server.ranges.clear()
    assert pull(server).read_bytes() == BODY
    assert server.ranges == [f"bytes={6 * pulling.BLOCK}-"]


def test_a_server_that_cannot_go_on_sends_all_again(server: Server) -> None:
    server.cuts, server.knows_ranges = [100_000], False
    assert pull(server).read_bytes() == BODY


def test_a_file_that_changed_meanwhile_is_fetched_anew(server: Server) -> None:
    server.cuts = [100_000, 0, 0]
    with pytest.raises(edvo.Error):
        pull(server)
    server.body, server.tag = BODY[::-1], '"2"'
    assert pull(server).read_bytes() == BODY[::-1]


def test_without_a_version_nothing_is_joined(server: Server) -> None:
    server.cuts, server.tag = [100_000], ""
    assert pull(server).read_bytes() == BODY
    assert server.ranges == [None, None]


def test_an_overloaded_server_is_asked_again_and_a_missing_file_is_not(server: Server) -> None:
    server.statuses = [503, 503]
    assert pull(server).read_bytes() == BODY
    server.statuses, server.ranges = [404, 404], []
    with pytest.raises(edvo.Error, match="404 Not Found"):
        pull(server, "tum/fr1/rpy")
    assert len(server.ranges) == 1


def test_a_silent_server_is_not_waited_for(server: Server) -> None:
    server.cuts, server.stalls = [1000] * 9, True
    begun = time.monotonic()
    with pytest.raises(edvo.Error, match="no data for 0.3 s"):
        pull(server, timeout=0.3)
    assert time.monotonic() - begun < 3
    server.cuts, server.stalls = [], False
    assert pull(server).read_bytes() == BODY


def test_no_server_at_all(server: Server) -> None:
    with pytest.raises(edvo.Error, match="cannot be reached"):
        pulling.pull(NAME, url="http://127.0.0.1:1/x.tgz", quiet=True)


def test_another_file_than_dexined_is_not_kept(server: Server) -> None:
    with pytest.raises(edvo.Error, match="600000 bytes instead of 47235563"):
        pull(server, "dexined")
    server.sends_length, server.knows_ranges = False, False
    with pytest.raises(edvo.Error, match="not the file that was expected"):
        pull(server, "dexined")
    models = pulling.known_items()["dexined"].file.parent
    assert [file.name for file in models.iterdir() if file.suffix != ".tag"] == []


def test_a_model_is_imported(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    item = pulling.Item(
        "some", (server.url,), "MIT", hashlib.sha256(BODY).hexdigest(), len(BODY), is_model=True
    )
    monkeypatch.setattr(pulling, "known_items", lambda: {"some": item})
    # The C++ program knows DexiNed only, and says so of what is none.
    with pytest.raises(edvo.Error, match="could not be imported"):
        pull(server, "some")


def test_the_next_address_is_tried(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    item = pulling.Item("some", ("http://127.0.0.1:1/some.tgz", server.url), "MIT")
    monkeypatch.setattr(pulling, "known_items", lambda: {"some": item})
    assert pulling.pull("some", quiet=True).read_bytes() == BODY


def test_a_cache_that_cannot_be_written_is_named(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")
    with pytest.raises(edvo.Error, match="cannot be written") as caught:
        pull(server)
    assert caught.value.code == 7


def test_the_command_lists_explains_and_prints_the_place(
    server: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["pull", NAME, "--url", server.url, "--quiet"]) == 0
    assert capsys.readouterr().out.strip().endswith("sequences/rgbd_dataset_freiburg1_xyz.tgz")
    assert main(["pull", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.split() == [NAME, "there", "CC", "BY", "4.0"] for line in lines)
    assert any(line.startswith("dexined") for line in lines)
    assert main(["pull", "tum/fr1/xzy"]) == 2


def test_the_papers_benchmark_pulls_what_is_missing(
    server: Server,
    sequence: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    manifest = Path(__file__).parents[2] / "benchmarks" / "paper.toml"
    names = [
        line.split('"')[1] for line in manifest.read_text().splitlines() if line.startswith("pull")
    ]
    assert len(names) == 8 and set(names) <= set(pulling.known_items())
    archive = tmp_path / "sequence.tgz"
    with tarfile.open(archive, "w:gz") as out:
        out.add(sequence, "sequence")
    server.body, server.cuts = archive.read_bytes(), [100_000]
    # One is there, as the benchmark's own archives unpack; the others are served.
    data = tmp_path / "data"
    data.mkdir()
    (data / "rgbd_dataset_freiburg1_xyz").symlink_to(sequence)
    monkeypatch.setattr(
        pulling,
        "known_items",
        lambda: {
            name: pulling.Item(name, (f"{server.url}/{name.replace('/', '_')}.tgz",), "-")
            for name in names
        },
    )
    words = ["bench", str(manifest), "--data", str(data), "-o", str(tmp_path / "out")]
    words += ["--max-frames", "6", "--no-report", "--quiet"]
    assert main([*words, "--json"]) == 0
    report = json.loads(capfd.readouterr().out)
    assert ["tum/" + row["name"] for row in report["sequences"]] == names
    assert all(row["paper"] is not None for row in report["sequences"])
    assert all(
        system["state"] == "done" for row in report["sequences"] for system in row["systems"]
    )
    assert len(server.ranges) == 7 + 1  # one of which was cut
    server.ranges.clear()
    assert main(words) == 0 and server.ranges == []


def test_without_python_a_benchmark_says_who_downloads(tmp_path: Path) -> None:
    from edvo import _core

    manifest = tmp_path / "some.toml"
    manifest.write_text(
        'methods = ["canny"]\n[[sequence]]\nname = "a"\npull = "tum/fr1/xyz"\n', encoding="utf-8"
    )
    assert _core.main(["edvo", "bench", str(manifest)]) == 4
