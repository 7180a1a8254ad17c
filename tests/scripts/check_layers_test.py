#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""check_layers.py finds each kind of violation, and only those."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "check_layers.py"


def check(**files):
    """Runs the check over a tree of {path with __ for /: text}; returns (exit status, output)."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = Path(folder, name.replace("__", "/") + ".cpp")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        run = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
        return run.returncode, run.stdout


class CheckLayers(unittest.TestCase):
    def test_downward_includes_pass(self):
        status, _ = check(src__edvo__align__a='#include "edvo/core/se3.hpp"\n'
                                              '#include "edvo/align/b.hpp"\n#include <vector>\n')
        self.assertEqual(status, 0)

    def test_upward_and_sideways_includes_fail_with_their_line(self):
        status, output = check(src__edvo__core__a='\n#include "edvo/io/x.hpp"\n')
        self.assertEqual(status, 1)
        self.assertIn("src/edvo/core/a.cpp:2: layer 'core' must not include 'io'", output)
        self.assertEqual(check(src__edvo__align__a='#include <edvo/network/x.hpp>\n')[0], 1)

    def test_the_library_does_not_print_or_exit(self):
        for text in ("#include <iostream>", "void f() { std::cerr << 1; }", 'void f() { printf("x"); }',
                     "void f() { std::exit(1); }", 'auto x = getenv("HOME");', 'fmt::print("x");'):
            self.assertEqual(check(src__edvo__odometry__a=text)[0], 1, text)
        self.assertEqual(check(apps__edvo__a='fmt::print("x");')[0], 0)

    def test_only_io_source_and_report_touch_files(self):
        for layer, status in (("core", 1), ("align", 1), ("eval", 1), ("synth", 1), ("run", 1),
                              ("io", 0), ("source", 0), ("report", 0)):
            self.assertEqual(check(**{f"src__edvo__{layer}__a": "#include <fstream>"})[0], status)

    def test_words_in_comments_and_strings_do_not_count(self):
        self.assertEqual(check(src__edvo__core__a='// std::cout << exit(1)\n/* printf("a"); */\n'
                                                  'const char* s = "std::cout // \\" exit(1)";\n'
                                                  "constexpr long n = 1'000'000;\n")[0], 0)

    def test_an_unknown_layer_and_an_empty_tree_fail(self):
        self.assertEqual(check(src__edvo__extra__a="")[0], 1)
        self.assertEqual(check()[0], 1)


if __name__ == "__main__":
    unittest.main()
