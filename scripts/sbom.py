#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lists what edvo is made with: packages of scripts/packages.txt and those whose libraries the
program loads, with versions and licences as this system's package database has them.

Usage: scripts/sbom.py [--json] [PROGRAM]      default: a Markdown table, build/bin/edvo

--json prints a CycloneDX 1.5 document. Licences are the short names of the package's copyright file
in Debian's machine-readable format; "see PATH" where it is not in that format.
"""
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def listed_packages():
    lines = (ROOT / "scripts/packages.txt").read_text().splitlines()
    return [line.split("#")[0].strip() for line in lines if line.split("#")[0].strip()]


def loaded_packages(program):
    """Of the libraries that the system would load with the program."""
    names = set()
    for path in re.findall(r"=> (/\S+)", output_of("ldd", str(program))):
        for place in {path, str(Path(path).resolve()), path.removeprefix("/usr")}:
            owner = output_of("dpkg-query", "-S", place).split(": ")[0]
            if owner:
                names.add(owner.split(",")[0].split(":")[0])
                break
    return names


def version_of(package):
    return output_of("dpkg-query", "-W", "-f=${Version}", package) or "not installed"


def licence_of(package):
    path = Path("/usr/share/doc") / package / "copyright"
    if not path.exists():
        return "unknown"
    text = path.read_text(encoding="utf-8", errors="replace")
    if "Format:" not in text.split("\n\n")[0]:
        return f"see {path}"
    names = []
    for name in re.findall(r"^License:[ \t]*(\S[^\n]*)", text, re.MULTILINE):
        if name.strip() not in names:
            names.append(name.strip())
    return ", ".join(names) if names else f"see {path}"


def components(program):
    loaded = loaded_packages(program) if program.exists() else set()
    for package in sorted(set(listed_packages()) | loaded):
        yield {"name": package, "version": version_of(package), "licence": licence_of(package),
               "scope": "in the program" if package in loaded else "to build or test"}


def cyclonedx(rows):
    return {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "metadata": {"component": {"type": "application", "name": "edvo",
                                       "licenses": [{"license": {"id": "MIT"}}]}},
            "components": [{"type": "library", "name": row["name"], "version": row["version"],
                            "scope": "required" if row["scope"] == "in the program" else "excluded",
                            "licenses": [{"license": {"name": row["licence"]}}]} for row in rows]}


def main():
    arguments = [a for a in sys.argv[1:] if a != "--json"]
    rows = list(components(Path(arguments[0]) if arguments else ROOT / "build/bin/edvo"))
    if "--json" in sys.argv[1:]:
        print(json.dumps(cyclonedx(rows), indent=2))
        return 0
    print("| package | version | used | licences in it |\n| --- | --- | --- | --- |")
    for row in rows:
        print(f"| {row['name']} | {row['version']} | {row['scope']} | {row['licence']} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
