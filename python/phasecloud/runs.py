"""Runs of the command `phasecloud`, with a process for each case."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import _native
from .errors import RunFailed
from .program import command
from .results import Results
from .scenario import Scenario, to_toml


def run(
    launch: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    *,
    scenario: str | os.PathLike[str] | Scenario | None = None,
    out: str | os.PathLike[str] | None = None,
    report: bool = True,
    show: bool = False,
) -> Results:
    """Runs a launch file and returns its results.

    `launch` is a file, or a dictionary with the keys of a launch file (docs/launch-files.md) in which `scenarios` may be Scenario
    objects; without it scenario 1 is run with the paper's four cases and the exact answer. `scenario` is run instead of those that the
    launch file names. `out` is the results folder, new or empty; without it `results/NAME-TIME`. `show` prints what the command says.

    Raises InputError, with file, line and key, before anything is started; RunFailed if nothing was written. A case that fails does not stop
    the others: `Results.notes` names it.
    """
    with tempfile.TemporaryDirectory(prefix="phasecloud-") as folder:
        words = ["run"]
        if launch is not None:
            path = _written(launch, Path(folder)) if isinstance(launch, Mapping) else Path(launch)
            if scenario is None:
                _native.check_launch(os.fspath(path))
            words.append(os.fspath(path))
        if scenario is not None:
            words += ["--scenario", os.fspath(_file_of(scenario, Path(folder)))]
        if out is not None:
            words += ["--out", os.fspath(out)]
        if not report:
            words.append("--no-report")
        code, said = _carried_out([command(), *words], show)
    found = re.search(r"^Results: (.+)$", said, re.MULTILINE)
    if code not in (0, 1) or found is None:
        raise RunFailed(f"phasecloud ended with exit code {code}: {said.strip().splitlines()[-1] if said.strip() else ''}", code, said)
    return Results(found[1])


def _written(launch: Mapping[str, Any], folder: Path) -> Path:
    """A launch file with this table, its scenarios beside it."""
    table = dict(launch)
    scenarios: Sequence[Any] = table.get("scenarios", [])
    table["scenarios"] = [os.fspath(_file_of(scenario, folder).absolute()) for scenario in scenarios]
    path = folder / "launch.toml"
    path.write_text(to_toml(table), encoding="utf-8")
    return path


def _file_of(scenario: Any, folder: Path) -> Path:
    if not isinstance(scenario, Scenario):
        return Path(scenario)
    path = folder / f"{scenario.name}.toml"
    path.write_text(scenario.to_toml(), encoding="utf-8")
    return path


def _carried_out(words: Sequence[str], show: bool) -> tuple[int, str]:
    """The exit code, and what was said on both outputs. Ctrl-C asks the run to end; it then has an exit code of its own."""
    process = subprocess.Popen(
        words,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    said: list[str] = []
    with process:
        try:
            for line in process.stdout or ():
                said.append(line)
                if show:
                    print(line, end="")
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
    return process.returncode, "".join(said)
