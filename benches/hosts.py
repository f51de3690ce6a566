"""Monte Carlo over one, two and three hosts that share this machine: wall time, CPU time, bytes moved, link utilisation.

    cargo build --release --features hosts && python3 benches/hosts.py [SAMPLES ...]

Each host is a domain of its own; they meet over loopback. With `--rate RATE` (as root; for example `1gbit`) worker hosts lie in network
namespaces behind cables of that rate instead, and the share of the rate that transfers used is printed as well.
"""

import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

PROGRAM = pathlib.Path(__file__).parent.parent / "target/release/phasecloud"
SCENARIO = pathlib.Path(__file__).parent.parent / "launch/scenarios/scenario-1.toml"
PORT = 17447


def ip(*words):
    subprocess.run(["ip", *words], check=True)


class Cables:
    """One namespace per host, joined by a bridge at home; cables carry `rate`."""

    def __init__(self, rate, workers):
        self.names = [f"pcbench{index}" for index in range(workers + 1)]
        home = self.names[0]
        for name in self.names:
            ip("netns", "add", name)
            ip("-n", name, "link", "set", "lo", "up")
        ip("-n", home, "link", "add", "hub", "type", "bridge")
        ip("-n", home, "addr", "add", "10.98.0.1/24", "dev", "hub")
        ip("-n", home, "link", "set", "hub", "up")
        for index, name in enumerate(self.names[1:], start=1):
            near = f"cable{index}"
            ip("link", "add", near, "netns", home, "type", "veth", "peer", "name", "cable", "netns", name)
            ip("-n", home, "link", "set", near, "master", "hub", "up")
            ip("-n", name, "addr", "add", f"10.98.0.{index + 1}/24", "dev", "cable")
            ip("-n", name, "link", "set", "cable", "up")
            limit = ["tbf", "rate", rate, "burst", "256kb", "latency", "50ms"]
            subprocess.run(["tc", "-n", name, "qdisc", "add", "dev", "cable", "root", *limit], check=True)

    def inside(self, index):
        return ["ip", "netns", "exec", self.names[index]]

    def remove(self):
        for name in self.names:
            subprocess.run(["ip", "netns", "del", name], check=False)


def launch_file(folder, samples, hosts, address, reduce):
    """Monte Carlo alone, one shard per host."""
    names = ["home"] + [f"worker-{index}" for index in range(1, hosts)]
    text = f'name = "hosts"\nscenarios = ["{SCENARIO}"]\nreference = "mc"\naccuracy = 1e-9\n'
    if hosts > 1:
        text += f'[hosts]\nnames = {json.dumps(names[1:])}\nlisten = "tcp/{address}:{PORT}"\n'
    text += f'[[propagator]]\nlabel = "mc"\nnode = "mc"\nsamples = {samples}\nshards = {hosts}\n'
    text += f"hosts = {json.dumps(names)}\n" if hosts > 1 else ""
    text += "reduce = true\n" if reduce else ""
    path = folder / "launch.toml"
    path.write_text(text)
    return path


def run(samples, hosts, cables, reduce):
    """Wall and CPU seconds, bytes brought home, bytes per second while something was carried."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        address = "10.98.0.1" if cables else "127.0.0.1"
        inside = cables.inside if cables else lambda _: []
        workers = []
        for index in range(1, hosts):
            command = [PROGRAM, "join", "--connect", f"tcp/{address}:{PORT}", "--name", f"worker-{index}", "--insecure"]
            environment = {**os.environ, "TMPDIR": str(folder), "PHASECLOUD_LOG": "debug"}
            workers.append(subprocess.Popen([*inside(index), *command, "--quiet"], env=environment, stderr=subprocess.DEVNULL))
        time.sleep(1.0)  # they look for home three times per second
        command = [PROGRAM, "run", launch_file(folder, samples, hosts, address, reduce), "--out", folder / "out"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        begun = time.perf_counter()
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        options = ["--no-report", "--insecure", "--log", "debug"]
        subprocess.run([*inside(0), *command, *options], check=True, **quiet)
        wall = time.perf_counter() - begun
        for worker in workers:
            worker.wait()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        lines = [json.loads(line) for line in (folder / "out/log.jsonl").read_text().splitlines()]
        carried = sum(line["bytes"] for line in lines if line["message"].startswith("brought home"))
        large = [line for line in lines if line["message"].startswith("a message on") and line["bytes"] > 1_000_000]
        seconds = sum(line["milliseconds"] for line in large) / 1000
        rate = sum(line["bytes"] for line in large) / seconds if seconds else float("nan")
        return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, carried, rate


def main():
    words = sys.argv[1:]
    rate = words[words.index("--rate") + 1] if "--rate" in words else None
    sizes = [int(float(word)) for word in words if not word.startswith("--") and word != rate] or [1_000_000, 10_000_000]
    cables = Cables(rate, 2) if rate else None
    try:
        print("| samples | hosts | sent | wall, s | beside one host | CPU, s | MB brought home | MB/s while carrying |")
        print("|---|---|---|---|---|---|---|---|")
        for samples in sizes:
            alone = None
            for hosts, reduce in [(1, False), (2, False), (3, False), (3, True)]:
                results = [run(samples, hosts, cables, reduce) for _ in range(3)]
                wall, cpu, carried, speed = (statistics.median(column) for column in zip(*results))
                alone = alone or wall
                what = "sums" if reduce else "samples"
                row = [f"{samples:.0e}", hosts, what, f"{wall:.2f}", f"{wall / alone:.2f}", f"{cpu:.2f}"]
                print("|", " | ".join(map(str, [*row, f"{carried / 1e6:.2f}", f"{speed / 1e6:.0f}"])), "|", flush=True)
    finally:
        if cables:
            cables.remove()


main()
