"""The command ``plan2scene``: Ctrl+C during the imports also ends in one line, no traceback."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line."""
    try:
        from plan2scene_app.cli import main as command_line

        command_line()
    except KeyboardInterrupt:
        sys.stderr.write("ERROR ended by SIGINT\n")
        raise SystemExit(130) from None
