"""Tests run against the installed package; the benchmarks, which are not installed, are found here."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
