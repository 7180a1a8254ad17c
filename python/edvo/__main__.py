# SPDX-License-Identifier: MIT
import sys

from edvo.cli import main

sys.exit(main())
