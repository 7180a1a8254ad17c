#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that no source file has more than 400 lines and no function more than 60.

Usage: scripts/check_size.py [--list] [SOURCE_ROOT]; exits with 1 and one line per violation.
--list prints the longest instead. What may be longer stands in EXCEPTIONS, with its reason in
docs/adr/.
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from check_layers import without_comments_and_strings

LONGEST_FILE = 400      # lines
LONGEST_FUNCTION = 60   # lines, from its head to its last brace
SHOWN = 20              # by --list

# "file" or "file:function" -> the ADR that says why.
EXCEPTIONS = {
    "src/edvo/image/depth_registration.cpp:find_footprints": "0005-vectors-by-the-compiler.md",
    "src/edvo/window/pair_linearization.cpp:add_block": "0005-vectors-by-the-compiler.md",
    "src/edvo/window/pair_linearization.cpp:add_pair": "0005-vectors-by-the-compiler.md",
}

SCOPE = re.compile(r"\b(namespace|class|struct|union)\b|\bextern\b")
LABEL = re.compile(r"\s*(?:(?:public|private|protected)\s*:\s*)*")
NAME = re.compile(r"([~\w:<>]+|operator\s*\S+)\s*\(")


def functions_in(text):
    """Yields (name, first line, last line) of every function, lambdas inside of it included."""
    scopes = []       # of the braces around: True where functions may be defined
    head_from = 0     # where the words before the next brace begin
    begun = None      # (name, line, depth) of the function that is being read
    for at, c in enumerate(text):
        if c in ";":
            head_from = at + 1
        elif c == "{":
            head_from += len(LABEL.match(text[head_from:at]).group(0))
            head = text[head_from:at]
            outside = all(scopes)
            is_scope = outside and bool(SCOPE.search(head)) and "(" not in head
            if outside and not is_scope and "(" in head and begun is None:
                name = NAME.search(head)
                first = text.count("\n", 0, head_from) + 1
                begun = (name.group(1) if name else "?", first, len(scopes))
            scopes.append(is_scope)
            head_from = at + 1
        elif c == "}" and scopes:
            scopes.pop()
            if begun and len(scopes) == begun[2]:
                yield begun[0], begun[1], text.count("\n", 0, at) + 1
                begun = None
            head_from = at + 1


def sizes_in(path, root):
    """Yields (what, line, lines, limit) of a file and its functions."""
    where = path.relative_to(root).as_posix()
    text = path.read_text(encoding="utf-8")
    yield where, 1, text.count("\n"), LONGEST_FILE
    # Strings keep their lines; preprocessor lines could hold braces of their own.
    code = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", "", without_comments_and_strings(text), flags=re.M)
    code = code if code.count("\n") == text.count("\n") else without_comments_and_strings(text)
    for name, first, last in functions_in(code):
        yield f"{where}:{name}", first, last - first + 1, LONGEST_FUNCTION


def main():
    arguments = [a for a in sys.argv[1:] if a != "--list"]
    root = Path(arguments[0] if arguments else Path(__file__).parent.parent).resolve()
    files = sorted(f for folder in (root / "src", root / "apps")
                   for f in folder.rglob("*") if f.suffix in (".hpp", ".cpp", ".inl"))
    sizes = [size for f in files for size in sizes_in(f, root)]
    if "--list" in sys.argv:
        for what, line, lines, limit in sorted(sizes, key=lambda s: -s[2] / s[3])[:SHOWN]:
            print(f"{lines:5} lines of {limit}  {what} (line {line})")
        return 0
    problems = [f"{what}: {lines} lines, at most {limit} (line {line})"
                for what, line, lines, limit in sizes if lines > limit and what not in EXCEPTIONS]
    problems += [f"{what}: no exception is needed any more, see scripts/check_size.py"
                 for what in EXCEPTIONS
                 if (root / what.split(":")[0]).exists() and not any(s[0] == what and s[2] > s[3] for s in sizes)]
    counted = sum(1 for s in sizes if s[3] == LONGEST_FUNCTION)
    print("\n".join(problems) if problems
          else f"sizes: {len(files)} files, {counted} functions, no violation")
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
