# SPDX-License-Identifier: MIT
"""Fetches the free images that free_images.csv lists, with git, into one folder.

python3 training/fetch_free.py FOLDER
"""
import csv
import subprocess
import sys
import tempfile
from itertools import groupby
from pathlib import Path


def listed():
    """Rows of free_images.csv: repository, commit, licence, author, path."""
    with open(Path(__file__).with_name("free_images.csv"), newline="", encoding="utf-8") as rows:
        return list(csv.DictReader(rows))


def name_of(row):
    """The file's name in the folder, one for each row."""
    repository = row["repository"].split("/")[1]
    return f"{repository}_{row['path']}".replace("/", "_").replace(" ", "_")


def git(folder, *arguments):
    return subprocess.run(["git", "-C", folder, *arguments], check=True,
                          stdout=subprocess.PIPE).stdout


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for (repository, commit), rows in groupby(listed(), lambda r: (r["repository"], r["commit"])):
        with tempfile.TemporaryDirectory() as clone:
            git(clone, "init", "--quiet")
            git(clone, "fetch", "--quiet", "--depth=1", f"https://github.com/{repository}", commit)
            for row in rows:
                (folder / name_of(row)).write_bytes(git(clone, "show", f"{commit}:{row['path']}"))
        print(repository, flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
