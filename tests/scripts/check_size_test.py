#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""check_size.py finds files and functions that are too long, and only those."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "check_size.py"


def check(text):
    """Runs the check over a tree of one file; returns (exit status, output)."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "src/edvo/core/a.cpp")
        path.parent.mkdir(parents=True)
        path.write_text(text)
        run = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
        return run.returncode, run.stdout


def function(lines, head="int f(int a)"):
    """A definition of so many lines, with braces of its own and in a string."""
    body = ["  if (a) {", '    g("}{");', "  }"]
    body += ["  ++a;"] * (lines - len(body) - 2)
    return "\n".join([head + " {"] + body + ["}"]) + "\n"


class CheckSize(unittest.TestCase):
    def test_the_limits_are_400_and_60_lines(self):
        self.assertEqual(check("int a;\n" * 400)[0], 0)
        status, output = check("int a;\n" * 401)
        self.assertEqual(status, 1)
        self.assertIn("src/edvo/core/a.cpp: 401 lines", output)
        self.assertEqual(check(function(60))[0], 0)
        status, output = check("\n" + function(61))
        self.assertEqual(status, 1)
        self.assertIn("src/edvo/core/a.cpp:f: 61 lines, at most 60 (line 2)", output)

    def test_functions_are_found_in_namespaces_and_classes(self):
        for before, after in (("namespace edvo {\nnamespace {\n", "}\n}\n"),
                              ("namespace edvo {\nclass A : public B {\n public:\n", "};\n}\n"),
                              ('extern "C" {\n', "}\n"), ("struct A {\n  int b[2] = {1, 2};\n", "};\n")):
            self.assertEqual(check(before + function(60) + after)[0], 0, before)
            status, output = check(before + function(61) + after)
            self.assertEqual(status, 1, before)
            self.assertEqual(output.count("lines, at most"), 1, output)

    def test_data_namespaces_and_classes_may_be_longer(self):
        values = "  1,\n" * 100
        self.assertEqual(check("namespace a {\nconstexpr int k[] = {\n" + values + "};\n}\n")[0], 0)
        self.assertEqual(check("class A {\n" + function(50) * 4 + "};\n")[0], 0)

    def test_an_empty_tree_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(subprocess.run([sys.executable, SCRIPT, folder],
                                            capture_output=True).returncode, 1)


if __name__ == "__main__":
    unittest.main()
