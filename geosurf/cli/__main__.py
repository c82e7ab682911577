"""``python -m geosurf.cli`` is the command ``geosurf``."""

import sys

from geosurf.cli import main

sys.exit(main())
