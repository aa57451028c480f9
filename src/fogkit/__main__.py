"""``python -m fogkit``: the command line."""

import sys

from fogkit.cli.entry import main

if __name__ == "__main__":
    sys.exit(main())
