"""``python -m roughcontact`` is the command line."""

import sys

from roughcontact.cli import main

if __name__ == "__main__":
    sys.exit(main())
