#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""check_links.py finds each kind of broken link, and only those."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "check_links.py"


def check(files):
    """Runs the check over a tree of {path: text}; returns (exit status, output)."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        run = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
        return run.returncode, run.stdout


class CheckLinks(unittest.TestCase):
    def test_links_to_files_folders_and_headings_pass(self):
        status, output = check({
            "README.md": "# Top\n[a](docs/a.md) [b](docs/a.md#speed-accuracy-1) [c](docs/) [d](#top)\n",
            "docs/a.md": "## Speed & accuracy\n## Speed, accuracy\n![x](../README.md)\n"
                         "## Speed accuracy\n## Speed accuracy\n"})
        self.assertEqual(status, 0, output)

    def test_a_missing_file_fails_with_its_line(self):
        status, output = check({"docs/a.md": "text\n\n[b](b.md)\n"})
        self.assertEqual(status, 1)
        self.assertIn("docs/a.md:3: b.md: no such file", output)

    def test_a_missing_heading_fails(self):
        files = {"a.md": "[b](b.md#there) [c](#here)\n", "b.md": "# Other\n"}
        status, output = check(files)
        self.assertEqual(status, 1)
        self.assertIn("a.md:1: b.md#there: no such heading", output)
        self.assertIn("a.md:1: #here: no such heading", output)

    def test_a_heading_in_code_is_no_heading(self):
        self.assertEqual(check({"a.md": "[b](#b)\n```sh\n# b\n```\n"})[0], 1)

    def test_a_link_out_of_the_repository_fails(self):
        status, output = check({"a.md": "[up](../)\n"})
        self.assertEqual(status, 1)
        self.assertIn("leads out of the repository", output)

    def test_code_and_other_hosts_are_not_followed(self):
        status, output = check({"a.md": "`[a](b.md)`\n```\n[c](d.md)\n```\n[e](https://example.org/f.md)\n"})
        self.assertEqual(status, 0, output)

    def test_pages_in_build_folders_are_left_out(self):
        status, output = check({"a.md": "text\n", "build/b.md": "[c](c.md)\n"})
        self.assertEqual(status, 0, output)


if __name__ == "__main__":
    unittest.main()
