"""Where the tests find the files of the checkout."""

import signal
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
SCENARIOS = ROOT / "launch/scenarios"


@pytest.fixture(autouse=True)
def ctrl_c():
    """Python leaves an interrupt ignored if it was started so, as by a shell in the background; the tests send some."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
