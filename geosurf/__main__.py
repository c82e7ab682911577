"""``python -m geosurf`` is the command ``geosurf``, where its folder is not in the path."""

import sys

from geosurf.cli import main

if __name__ == "__main__":
    sys.exit(main())
