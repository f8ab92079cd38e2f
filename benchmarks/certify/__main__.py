"""`python -m benchmarks.certify`: the same as `surefoot bench certify`."""

from __future__ import annotations

import sys

from surefoot.app.cli.main import main

if __name__ == "__main__":
    sys.exit(main(["bench", "certify", *sys.argv[1:]]))
