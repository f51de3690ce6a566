"""Where the tests find the files of the checkout."""

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SCENARIOS = ROOT / "launch/scenarios"
