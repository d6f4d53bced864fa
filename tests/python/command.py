"""The command ``rustchain`` in this process."""

from typing import Any

from click.testing import Result
from typer.testing import CliRunner

from rustchain.cli.app import app


def rustchain(*arguments: object, **keywords: Any) -> Result:
    """Return the outcome of the command with these arguments."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments], **keywords)
