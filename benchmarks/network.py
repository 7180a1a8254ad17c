#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Canny's edges and the network's on conditions in which a network should pay, and what the best
possible edges would give: renders the sequences of network.toml, and beside each one the same
frames without faults, follows each with edges of many kinds (edge_ceiling.cpp), and prints the
geometric means of the errors against Canny's, for the hard and the easy half.

    python benchmarks/network.py DATA --build build/bin [--seeds 3] [--fr1 FOLDER ...] [--kt3 FOLDER]
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import re
import subprocess
import sys
import tomllib

import sensors

# Of a rendering's flags, those that make faults; --sensor becomes clean.
FAULTS = r"--(light|shot-noise|exposure-time|shadows|lamp-swing) \S+ ?"


def clean_flags(flags):
    return re.sub(r"--sensor \S+", "--sensor clean", re.sub(FAULTS, "", flags)).strip()


def with_seed(sequence, number):
    """The same conditions with another room, motion and noise."""
    flags = re.sub(r"--seed (\d+)", lambda m: f"--seed {int(m[1]) + 1000 * number}",
                   sequence["flags"])
    return {**sequence, "name": f"{sequence['name']}-{number}", "flags": flags}


def measure(options, sequence):
    """Kind of edges -> ate, rpe, lost."""
    if "folder" in sequence:
        return measure_recorded(options, sequence)
    edvo = options.build / "edvo"
    taken = sensors.render(edvo, options.data, sequence)
    clean = sensors.render(edvo, options.data, {"name": sequence["name"] + "-clean",
                                                "flags": clean_flags(sequence["flags"])})
    command = [options.build / "edge_ceiling", taken, clean, *options.set,
               *options.models]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return {row.pop("edges"): row for row in map(json.loads, printed.splitlines())}


def measure_recorded(options, sequence):
    results = {}
    for kind, arguments in (("canny", ["--method", "canny+corner"]),
                            ("network", ["--method", "cnn+corner"]),
                            *((m, ["--method", "cnn+corner", "--model", m])
                              for m in options.models)):
        out = options.data / "runs" / sequence["name"] / re.sub(r"\W", "_", str(kind))
        command = [options.build / "edvo", "run", sequence["folder"], *arguments,
                   *sequence["arguments"], *(f"--set={o}" for o in options.set), "-o", out, "--force", "--no-report", "--quiet"]
        subprocess.run(command, check=True, capture_output=True, text=True)
        errors = json.loads((out / "summary.json").read_text())["evaluation"]["final"]
        results[str(kind)] = {"ate": errors["ate_rmse_m"],
                              "rpe": errors["rpe_translation_rmse_m_per_s"], "lost": 0}
    return results


def ratio(row, kind, error):
    """Against Canny's; where one of both has no result, none."""
    own, canny = row["edges"].get(kind, {}).get(error), row["edges"]["canny"][error]
    return own / canny if own and canny else math.nan


def geometric_mean(ratios):
    logarithms = [math.log(r) for r in ratios if math.isfinite(r)]
    if not logarithms:
        return math.nan, math.nan
    mean = sum(logarithms) / len(logarithms)
    spread = math.sqrt(sum((l - mean) ** 2 for l in logarithms) / max(1, len(logarithms) - 1))
    return math.exp(mean), math.exp(mean) * spread / math.sqrt(len(logarithms))


def kinds_in(rows):
    return list(dict.fromkeys(kind for row in rows for kind in row["edges"]))


def print_sequences(rows):
    kinds = ("canny", "network", "clean canny")
    print("| sequence | sensor | half | set | " + " | ".join(kinds) + " |")
    print("|" + " --- |" * (4 + len(kinds)))
    for row in rows:
        cells = [row["name"], row["sensor"], row["half"], row["set"]]
        for kind in kinds:
            result = row["edges"].get(kind)
            lost = f" ({result['lost']} lost)" if result and result["lost"] else ""
            has_errors = result and result["ate"] is not None
            cells.append(f"{result['ate']:.5f} / {result['rpe']:.5f}{lost}" if has_errors else "-")
        print("| " + " | ".join(cells) + " |")


def print_means(rows):
    groups = list(dict.fromkeys((row["half"], row["set"]) for row in rows))
    print("\nATE, RPE as shares of Canny's: geometric mean, +- its standard error; frames lost\n")
    print("| edges | " + " | ".join(f"{half}, {of_set}" for half, of_set in groups) + " |")
    print("|" + " --- |" * (1 + len(groups)))
    for kind in kinds_in(rows):
        cells = [kind]
        for group in groups:
            members = [row for row in rows
                       if (row["half"], row["set"]) == group and kind in row["edges"]]
            if not members:
                cells.append("-")
                continue
            means = [geometric_mean([ratio(row, kind, e) for row in members])
                     for e in ("ate", "rpe")]
            lost = sum(row["edges"][kind]["lost"] for row in members)
            cells.append(", ".join(f"{m:.3f} +- {s:.3f}" for m, s in means) + f"; {lost}")
        print("| " + " | ".join(cells) + " |")


def recorded(options):
    for folder in options.fr1:
        yield {"name": folder.name, "sensor": "Kinect", "half": "fr1", "set": "recorded",
               "folder": folder, "arguments": []}
    if options.kt3:
        yield {"name": "icl_kt3", "sensor": "ICL", "half": "kt3", "set": "recorded",
               "folder": options.kt3, "arguments": ["--depth-scale", "5000"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path, help="folder of the rendered sequences")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/bin"),
                        help="folder of the programs edvo and edge_ceiling")
    parser.add_argument("--manifest", type=pathlib.Path,
                        default=pathlib.Path(__file__).parent / "network.toml")
    parser.add_argument("--seeds", type=int, default=1, help="renderings of each condition")
    parser.add_argument("--models", nargs="*", default=[], help="descriptions of other networks")
    parser.add_argument("--set", nargs="*", default=[], help="options: GROUP.FIELD=VALUE")
    parser.add_argument("--fr1", nargs="*", default=[], type=pathlib.Path, help="TUM sequences")
    parser.add_argument("--kt3", type=pathlib.Path, help="ICL-NUIM office kt3")
    parser.add_argument("--only", default="", help="sequences whose name has this in it")
    parser.add_argument("--jobs", type=int, default=2, help="sequences at a time")
    parser.add_argument("--json", type=pathlib.Path, help="write all results there")
    options = parser.parse_args()
    sequences = [with_seed(s, number)
                 for s in tomllib.loads(options.manifest.read_text()).get("sequence", [])
                 for number in range(options.seeds)]
    sequences = [s for s in (*sequences, *recorded(options)) if options.only in s["name"]]
    options.data.mkdir(parents=True, exist_ok=True)
    rows = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for sequence, edges in zip(sequences, pool.map(lambda s: measure(options, s), sequences)):
            print(f"{sequence['name']}: done", file=sys.stderr)
            rows.append({**{k: str(v) for k, v in sequence.items()}, "edges": edges})
            if options.json:
                options.json.write_text(json.dumps(rows, indent=1))
    print_sequences(rows)
    print_means(rows)


if __name__ == "__main__":
    main()
