"""Time and memory of Monte Carlo by number of samples: python3 benches/scale.py

Runs target/release/phasecloud on scenario 1 and prints wall and CPU time, payload and peak memory (anonymous memory of all processes
and the run's shared memory, read every 20 ms).
"""

import contextlib
import glob
import os
import pathlib
import re
import resource
import subprocess
import tempfile
import time

root = pathlib.Path(__file__).parent.parent
program = root / "target/release/phasecloud"
scenario = (root / "launch/scenarios/scenario-1.toml").read_text()
launch = """name = "scale"
scenarios = ["s.toml"]
reference = "mc"
[[propagator]]
label = "mc"
node = "mc"
samples = {}
"""


def anonymous(process):
    """Anonymous memory of a process [MiB]."""
    try:
        return int(re.search(r"RssAnon:\s+(\d+)", pathlib.Path(f"/proc/{process}/status").read_text())[1]) / 1024
    except (OSError, TypeError):
        return 0  # the process has ended


def shared(process):
    """Shared memory of the run to which a process belongs [MiB]."""
    try:
        variables = pathlib.Path(f"/proc/{process}/environ").read_bytes().split(b"\0")
    except OSError:
        return 0
    prefixes = [v.split(b"=", 1)[1].decode() for v in variables if v.startswith(b"PHASECLOUD_PREFIX=")]
    size = 0
    for file in glob.glob(f"/dev/shm/{prefixes[0]}*") if prefixes else []:
        with contextlib.suppress(OSError):
            size += os.stat(file).st_blocks * 512
    return size / 2**20


def memory(launcher):
    """Memory of launcher and nodes, and the memory that they share [MiB]."""
    with contextlib.suppress(OSError):
        nodes = pathlib.Path(f"/proc/{launcher}/task/{launcher}/children").read_text().split()
        return sum(map(anonymous, [launcher, *nodes])) + max(map(shared, nodes), default=0)
    return 0


def cpu():
    """CPU time of all processes that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(samples, end, snapshots):
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "l.toml").write_text(launch.format(samples))
        pathlib.Path(folder, "s.toml").write_text(re.sub(r"(?m)^end = \S+", f"end = {end}", scenario))
        begun, before, peak = time.perf_counter(), cpu(), 0
        child = subprocess.Popen([program, "run", "l.toml", "--quiet", "--no-report", "--out", "out"], cwd=folder)
        while child.poll() is None:
            peak = max(peak, memory(child.pid))
            time.sleep(0.02)
        wall, payload = time.perf_counter() - begun, samples * 16 * snapshots / 2**20
        print(f"{samples:9} samples, {snapshots} snapshots: {wall:6.2f} s, CPU {cpu() - before:6.2f} s, {payload:6.0f} MiB, peak {peak:6.0f} MiB, {peak / payload:.2f}")


for case in [(100_000, 2.0, 5), (1_000_000, 2.0, 5), (10_000_000, 2.0, 5), (10_000_000, 3.0, 7)]:
    run(*case)
