"""``python -m bench.dashboard RING``."""

import sys

from bench.dashboard.process import main

sys.exit(main())
