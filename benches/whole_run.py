"""Where the time of a whole run goes: python3 benches/whole_run.py [LAUNCH_FILE] [RUNS]

Runs target/release/phasecloud several times and prints the median wall and CPU time from start to results folder, and the medians of when
each stage ended, read from log.jsonl. Needs nothing but Python.
"""

import json
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from datetime import datetime

launch = sys.argv[1] if len(sys.argv) > 1 else "launch/scenario-1.toml"
runs = int(sys.argv[2]) if len(sys.argv) > 2 else 15
program = pathlib.Path(__file__).parent.parent / "target/release/phasecloud"
services = {"launcher", "scenario", "estimator", "comparator", "recorder"}


def moment(line):
    return datetime.fromisoformat(line["time"].replace("Z", "+00:00")).timestamp()


def one_run(folder):
    cpu = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun, clock = time.time(), time.perf_counter()
    subprocess.run([program, "run", launch, "--quiet", "--out", folder], check=True)
    wall = time.perf_counter() - clock
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines = [json.loads(line) for line in open(folder / "log.jsonl")]
    ends = lambda nodes, words: max(moment(l) - begun for l in lines if nodes(l["node"]) and words in l["message"])
    return {
        "processes started": ends(lambda n: n == "launcher", "started"),
        "all ready": ends(lambda n: n not in ("launcher",), "ready"),
        "propagators done": ends(lambda n: n not in services, "done"),
        "compared": ends(lambda n: n == "comparator", "done"),
        "recorded": ends(lambda n: n == "recorder", "done"),
        "results folder there (report included)": wall,
        "CPU time of all processes": used.ru_utime + used.ru_stime - cpu.ru_utime - cpu.ru_stime,
    }


with tempfile.TemporaryDirectory() as temporary:
    figures = [one_run(pathlib.Path(temporary) / str(k)) for k in range(runs)]
print(f"{launch}, medians of {runs} runs [s]")
for name in figures[0]:
    values = [figure[name] for figure in figures]
    print(f"  {name:40} {statistics.median(values):7.3f}   ({min(values):.3f} to {max(values):.3f})")
