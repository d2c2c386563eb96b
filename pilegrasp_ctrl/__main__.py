"""`python -m pilegrasp_ctrl`, the same as `pilegrasp`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
