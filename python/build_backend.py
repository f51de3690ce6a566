"""How the wheel is built: by maturin, with the command `phasecloud` among its scripts.

maturin builds an extension module or programs, not both. The launcher of a run starts its own executable again for every process, so the command
has to be a program and not a script of Python: cargo builds it first, into the folder whose files maturin takes over as scripts.
"""

import json
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import maturin
from maturin import (  # noqa: F401, the functions of a build backend
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = ROOT / "python/phasecloud.data/scripts"

# maturin wants the folder to be there, also where nothing is taken from it.
SCRIPTS.mkdir(parents=True, exist_ok=True)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """A wheel with module and command."""
    with _command_among_scripts():
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """A wheel that leads to the sources in Python, for `pip install -e .`"""
    with _command_among_scripts():
        return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


@contextmanager
def _command_among_scripts():
    command = SCRIPTS / "phasecloud"
    try:
        shutil.copy(_build_command(), command)
        yield
    finally:
        command.unlink(missing_ok=True)


def _build_command():
    # Both packages are named so that their libraries are those of the extension module, and are built once.
    packages = ["--package", "phasecloud", "--package", "phasecloud-python"]
    words = ["cargo", "build", "--release", "--locked", *packages, "--bin", "phasecloud"]
    said = subprocess.run([*words, "--message-format=json-render-diagnostics"], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    for line in said.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["name"] == "phasecloud":
            return message["executable"]
    sys.exit("cargo has built no program phasecloud")
