"""``python -m bench.dashboard RING``."""

import signal
import sys

from bench.dashboard.process import main

# Ctrl-C reaches every process of the terminal; the run decides when it ends, and closes the ring
signal.signal(signal.SIGINT, signal.SIG_IGN)
sys.exit(main())
