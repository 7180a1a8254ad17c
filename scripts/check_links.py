#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the relative links of all Markdown pages: the file exists, and the page has the heading.

Usage: scripts/check_links.py [ROOT]; exits with 1 and one line per broken link. Links to other
hosts are not followed.
"""
import re
import sys
from pathlib import Path
from urllib.parse import unquote

SKIPPED = {"node_modules", "site-packages"}  # and every folder whose name begins with a dot or "build"

LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
DEFINITION = re.compile(r"^ {0,3}\[[^\]]+\]:\s*(\S+)", re.M)
HEADING = re.compile(r"^ {0,3}#{1,6}\s+(.*?)\s*#*\s*$", re.M)
FENCE = re.compile(r"^ {0,3}(```+|~~~+).*?(?:^ {0,3}\1[`~]*\s*$|\Z)", re.M | re.S)
CODE = re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.S)
ELSEWHERE = re.compile(r"[a-zA-Z][a-zA-Z0-9+.-]*:|//")


def blanked(match):
    """As many lines as there were, without their text."""
    return re.sub(r"[^\n]", " ", match.group(0))


def anchors_of(text):
    """The anchors that GitHub gives to the headings of a page."""
    anchors, counts = set(), {}
    for heading in HEADING.findall(FENCE.sub(blanked, text)):
        words = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", words.replace("`", "")).replace(" ", "-")
        count = counts.get(anchor, 0)
        counts[anchor] = count + 1
        anchors.add(f"{anchor}-{count}" if count else anchor)
    anchors.update(re.findall(r"<a\s+(?:id|name)=\"([^\"]+)\"", text))
    return anchors


def links_of(text):
    """Yields (line, target) of every link outside of code."""
    prose = CODE.sub(blanked, FENCE.sub(blanked, text))
    for pattern in (LINK, DEFINITION):
        for match in pattern.finditer(prose):
            yield prose.count("\n", 0, match.start()) + 1, match.group(1)


def pages_of(root):
    def is_ours(path):
        folders = path.relative_to(root).parts[:-1]
        return not any(f in SKIPPED or f.startswith((".", "build")) for f in folders)

    return sorted(p for p in root.rglob("*.md") if is_ours(p))


def problem_of(page, target, root):
    """What is wrong with a link of a page; None if nothing is."""
    name, _, anchor = unquote(target).partition("#")
    to = (root / name.lstrip("/") if name.startswith("/") else page.parent / name) if name else page
    if not to.exists():
        return "no such file"
    if root not in to.resolve().parents and to.resolve() != root:
        return "leads out of the repository"
    if anchor and to.suffix == ".md" and anchor not in anchors_of(to.read_text(encoding="utf-8")):
        return "no such heading"
    return None


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    pages, links, problems = pages_of(root), 0, []
    for page in pages:
        for line, target in links_of(page.read_text(encoding="utf-8")):
            if ELSEWHERE.match(target):
                continue
            links += 1
            if problem := problem_of(page, target, root):
                problems.append(f"{page.relative_to(root).as_posix()}:{line}: {target}: {problem}")
    print("\n".join(problems) if problems else f"links: {len(pages)} pages, {links} links, none broken")
    return 1 if problems or not pages else 0


if __name__ == "__main__":
    sys.exit(main())
