"""The command `rustchain`."""

import signal
import sys
import threading

from rustchain.errors import MissingExtra


def main() -> None:
    """Run the command."""
    # Ended by a scheduler or a supervisor, a command keeps what is there as after Ctrl-C.
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        from rustchain.cli.app import app

        app()
    except MissingExtra as error:
        sys.exit(f"error: {error}")
    except OSError as error:  # of the help, which no command prints
        from rustchain.cli.common import unwritten

        sys.exit(f"error: {unwritten(error)}")
    except KeyboardInterrupt:
        sys.exit(130)  # INTERRUPTED of common, whose import may be what was ended
