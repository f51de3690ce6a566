"""Time and memory of Monte Carlo by number of samples: python3 benches/scale.py

Runs target/release/phasecloud on scenario 1 and prints wall time, payload and peak memory (anonymous memory of all processes and the machine's
shared memory, looked at every 20 ms). Then, for comparison with the transport, how long a byte takes through a pipe to a sleeping process.
"""

import glob
import os
import pathlib
import re
import statistics
import struct
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
    """MiB of a process of a run, 0 of others."""
    try:
        if b"PHASECLOUD_RUN_ID" not in pathlib.Path(process, "environ").read_bytes():
            return 0
        return int(re.search(r"RssAnon:\s+(\d+)", pathlib.Path(process, "status").read_text())[1]) / 1024
    except (OSError, TypeError):
        return 0  # it has ended


def shared():
    return int(re.search(r"Shmem:\s+(\d+)", pathlib.Path("/proc/meminfo").read_text())[1]) / 1024


def run(samples, end, snapshots):
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "l.toml").write_text(launch.format(samples))
        pathlib.Path(folder, "s.toml").write_text(re.sub(r"(?m)^end = \S+", f"end = {end}", scenario))
        before, begun, peak = shared(), time.perf_counter(), 0
        child = subprocess.Popen([program, "run", "l.toml", "--quiet", "--no-report", "--out", "out"], cwd=folder)
        while child.poll() is None:
            peak = max(peak, sum(map(anonymous, glob.glob("/proc/[0-9]*"))) + shared() - before)
            time.sleep(0.02)
        wall, payload = time.perf_counter() - begun, samples * 16 * snapshots / 2**20
        print(f"{samples:9} samples, {snapshots} snapshots: {wall:6.2f} s, {payload:6.0f} MiB, peak {peak:6.0f} MiB, {peak / payload:.2f}")


def pipe(bytes_sent=300):
    reader, writer = os.pipe()
    if os.fork() == 0:
        for _ in range(bytes_sent):
            time.sleep(0.003)
            os.write(writer, struct.pack("d", time.monotonic_ns()))
        os._exit(0)
    delays = []
    for _ in range(bytes_sent):
        sent = struct.unpack("d", os.read(reader, 8))[0]
        delays.append((time.monotonic_ns() - sent) / 1e3)
    print(f"through a pipe: median {statistics.median(delays):.0f} us")


for case in [(100_000, 2.0, 5), (1_000_000, 2.0, 5), (10_000_000, 2.0, 5), (10_000_000, 3.0, 7)]:
    run(*case)
pipe()
