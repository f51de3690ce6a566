#!/usr/bin/env python3
"""All tables of docs/performance.md in one sitting: python3 benches/sitting.py [--only NAME ...] [--yardsticks FOLDER] [--to FILE]

Builds the program, runs the command of every table one after the other, and writes what they print to target/sitting.md (or FILE), under a
line that says on which machine. Takes about half an hour; leave the machine alone meanwhile. The load of the machine before each command stands
beside it: above 0.5 something else was running.
"""

import argparse
import datetime
import os
import pathlib
import platform
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXAMPLE = ["cargo", "run", "--release", "--quiet", "-p", "phasecloud-experiments", "--bin"]
COMMANDS = {
    "kernels": ["cargo", "bench", "--quiet", "-p", "phasecloud-density", "--", "--max-time", "2"],
    "peers": ["python3", "benches/peers/compare.py", "--quick", "--repeats", "7"],
    "run": ["python3", "benches/whole_run.py", "launch/scenario-1.toml", "11"],
    "run of the paper": ["python3", "benches/whole_run.py", "launch/paper.toml", "5"],
    "transport": ["cargo", "run", "--release", "--quiet", "-p", "phasecloud-messages", "--example", "latency"],
    "scale": ["python3", "benches/scale.py"],
    "flow maps": [*EXAMPLE, "flow_map_cost", "--", "--samples", "10000000"],
    "long horizons": [*EXAMPLE, "exact_horizons"],
    "uncertain parameter": [*EXAMPLE, "exact_uncertain"],
    "warm service": ["bash", "-c", "cd $(mktemp -d) && time $OLDPWD/target/release/phasecloud serve $OLDPWD/launch/sweep.toml --sweep $OLDPWD/launch/sweeps/initial-e.toml --quiet --out served"],
}


def machine():
    """The processor, the number of cores, the kernel and the compiler."""
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    model = next((line.split(": ")[1] for line in lines if line.startswith("model name")), platform.machine())
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    return f"{model}, {os.cpu_count()} cores, Linux {platform.release()}, rustc {compiler}, {datetime.date.today()}"


def rested():
    """Waits until what ran before has left the load average, at most three minutes, and returns the load of the last minute."""
    for _ in range(18):
        if os.getloadavg()[0] < 0.5:
            break
        time.sleep(10)
    return os.getloadavg()[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=COMMANDS, metavar="NAME", help=f"some of: {', '.join(COMMANDS)}")
    parser.add_argument("--yardsticks", type=pathlib.Path, help="passed on to peers/compare.py")
    parser.add_argument("--to", type=pathlib.Path, default=ROOT / "target" / "sitting.md")
    options = parser.parse_args()
    subprocess.run(["cargo", "build", "--release"], cwd=ROOT, check=True)
    with open(options.to, "w") as file:
        print(f"Machine: {machine()}.", file=file, flush=True)
        for name, command in COMMANDS.items():
            if options.only and name not in options.only:
                continue
            if name == "peers" and options.yardsticks:
                command = [*command, "--yardsticks", str(options.yardsticks.resolve())]
            load = rested()
            print(f"{name} ...", flush=True)
            done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            print(f"\n## {name}\n\n`{' '.join(command)}`, load before {load:.2f}\n\n{done.stdout}", file=file, flush=True)
            if done.returncode != 0:
                print(f"{name}: exit code {done.returncode}", flush=True)
    print(options.to)


if __name__ == "__main__":
    main()
