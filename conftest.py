"""Tests run against the installed package; the benchmarks, which are not installed, are found here. What compiles
says nothing: stderr is read. Commands compile first: what they tell is compared."""

import os
import sys
from pathlib import Path

os.environ.setdefault("NONSMOOTH_QUIET", "1")
os.environ.setdefault("NONSMOOTH_INTERPRET", "0")
sys.path.append(str(Path(__file__).parent))
