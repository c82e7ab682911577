"""The process of the command ``geosurf``, also as ``python -m geosurf``."""

import sys

from geosurf.stopping import end_at_signals


def main() -> int:
    """Run the command of the process; signals end it from here on."""
    end_at_signals()
    from geosurf.cli import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
