"""Tests run against the installed package; the benchmarks, which are not installed, are found here. What compiles
says nothing: stderr is read. Commands compile first: what they tell is compared. A shell that starts a job in the
background has it ignore SIGINT, and so would the programs that tests send it to: it is heard, however tests are
started."""

import os
import signal
import sys
from pathlib import Path

os.environ.setdefault("NONSMOOTH_QUIET", "1")
os.environ.setdefault("NONSMOOTH_INTERPRET", "0")
sys.path.append(str(Path(__file__).parent))
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
