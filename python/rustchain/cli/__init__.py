"""The command `rustchain`."""

import sys

from rustchain.errors import MissingExtra


def main() -> None:
    """Run the command."""
    try:
        from rustchain.cli.app import app
    except MissingExtra as error:
        sys.exit(f"error: {error}")
    app()
