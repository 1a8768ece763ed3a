"""`python -m studio` is the command `tgpo-studio`."""

import sys

from studio.cli import main

sys.exit(main())
