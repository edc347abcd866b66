"""``python -m roughcontact`` is the command line."""

import sys

from roughcontact.cli.app import main

if __name__ == "__main__":
    sys.exit(main())
