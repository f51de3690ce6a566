"""Where the command `phasecloud` is."""

from __future__ import annotations

import os
import shutil
import sysconfig
from pathlib import Path


def command() -> str:
    """The path of the command `phasecloud` that came with this package.

    The environment variable PHASECLOUD_COMMAND names another one.
    """
    named = os.environ.get("PHASECLOUD_COMMAND")
    if named:
        return named
    schemes = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    for folder in schemes:
        path = Path(folder) / "phasecloud"
        if path.is_file():
            return str(path)
    found = shutil.which("phasecloud")
    if found is None:
        raise FileNotFoundError(f"the command phasecloud is neither in {schemes[0]} nor on PATH; install the package again")
    return found
