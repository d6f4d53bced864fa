"""Paths that users give: checked before a file is read, and files written whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from rustchain.arguments import PATH_WORDS, shown
from rustchain.errors import InvalidInput

_LONGEST = 300  # characters of a path in a message; the longest name of one file is 255
_KINDS = (
    (stat.S_ISDIR, "directory"),
    (stat.S_ISFIFO, "FIFO"),
    (stat.S_ISSOCK, "socket"),
    (stat.S_ISCHR, "device"),
    (stat.S_ISBLK, "device"),
)


def path_of(path: object, field: str = "path") -> Path:
    """Return a path, or raise `InvalidInput` where `path` cannot name a file."""
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"{field}: got {shown(path)}; expected {PATH_WORDS}")
    name = os.fsdecode(path)
    if not name:
        msg = f"{field} = '': is empty; expected a file name"
        raise InvalidInput(msg)
    if "\0" in name:
        msg = f"{field} = {shown_path(name)}: has a NUL character; expected a file name without one"
        raise InvalidInput(msg)
    try:
        os.fsencode(name)
    except UnicodeEncodeError as error:
        encoding = sys.getfilesystemencoding()
        words = f"expected characters that {encoding} can encode"
        msg = f"{field} = {shown_path(name)}: is no file name; {words}"
        raise InvalidInput(msg) from error
    return Path(name)


def path_with_ending(
    path: object, field: str, endings: Sequence[str], what: str, more: str = ""
) -> Path:
    """Return the path of a file, or refuse the name of another kind of file.

    `what` is the kind of the files in words, `more` a second remedy. A number behind a dot is no
    ending: ``run_25.5``.
    """
    where = path_of(path, field)
    if re.match(r"\.\D", where.suffix) and where.suffix.lower() not in endings:
        msg = (
            f"{field} = {shown_path(where)}: ends in {where.suffix!r}; {what}: expected "
            f"{', '.join(endings)} or no ending; take "
            f"{shown_path(where.with_suffix(endings[0]).name)}{more}"
        )
        raise InvalidInput(msg)
    return where


def shown_path(path: object) -> str:
    """Return a path for a message: on one line, and not longer than a line or two."""
    name = str(path)
    name = name if name.isprintable() else repr(name)
    half = _LONGEST // 2
    return name if len(name) <= _LONGEST else f"{name[:half]}...{name[-half:]}"


def check_regular(path: Path) -> None:
    """Raise `OSError` where `path` is no regular file.

    Opening a FIFO waits for its other end, some devices have no end, and a rename onto a device
    replaces it.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        kind = next((kind for is_kind, kind in _KINDS if is_kind(mode)), "special file")
        number = errno.EISDIR if kind == "directory" else errno.EINVAL
        raise OSError(number, f"Is a {kind}; expected a regular file")


def check_there(path: object, writer: str) -> Path:
    """Return the path of a file that `writer` could have written, or raise where there is none."""
    where = path_of(path)
    remedy = f"give a file that {writer} wrote"
    try:
        check_regular(where)
        if not os.access(where, os.R_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    except FileNotFoundError as error:
        msg = f"path = {shown_path(where)}: there is no such file: {remedy}"
        raise FileNotFoundError(msg) from error
    except OSError as error:
        msg = f"path = {shown_path(where)}: cannot be read ({reason(error)}): {remedy}"
        raise type(error)(msg) from error
    return where


def check_writable(path: object, field: str = "path") -> None:
    """Raise where `write_whole` could not write to `path`; nothing is left there."""
    import tempfile  # takes longer than the package's own modules

    try:
        with tempfile.TemporaryFile(dir=_target(path, field).parent):
            pass
    except OSError as error:
        raise unwritable(path, field, error) from error


def write_whole(path: object, content: bytes | memoryview, field: str = "path") -> None:
    """Write a file that is there whole or not at all, whatever interrupts.

    The content is written beside the file and renamed when it is on the disc. The new file has the
    permissions of the one that it replaces; the target of a symbolic link is replaced, not the
    link.

    Raises
    ------
    InvalidInput
        `path` is no path, or has a NUL character.
    OSError
        The file cannot be written, or is a directory, a device or a FIFO.
    """
    with new_file(path, field) as (part, _), part.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def new_file(path: object, field: str = "path") -> Iterator[tuple[Path, Path]]:
    """Give the path to write a file to, and the one that it then takes; as `write_whole`."""
    try:
        target = _target(path, field)
        # A name of its own length, since one derived from a long name is too long.
        part = target.with_name(f".{os.urandom(8).hex()}.part")
        try:
            yield part, target
            _hand_on_permissions(target, part)
            part.replace(target)
        except BaseException:
            with suppress(OSError):
                part.unlink()
            raise
    except OSError as error:
        raise unwritable(path, field, error) from error


def _target(path: object, field: str) -> Path:
    """Return the file itself that is to be written, which is regular or not there yet."""
    target = Path(os.path.realpath(path_of(path, field)))
    with suppress(FileNotFoundError):
        check_regular(target)
        if not os.access(target, os.W_OK):  # a rename asks for the directory only
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return target


def _hand_on_permissions(old: Path, new: Path) -> None:
    """Give a file the owner and the mode of the one that it replaces, if there is one."""
    with suppress(FileNotFoundError):
        status = old.stat()
        with suppress(AttributeError, PermissionError):  # no owners on Windows; another's file
            os.chown(new, status.st_uid, status.st_gid)
        new.chmod(stat.S_IMODE(status.st_mode))


def unwritable(path: object, field: str, error: OSError) -> OSError:
    """Return the error with the reason why a file cannot be written."""
    return type(error)(
        f"{field} = {shown_path(path)}: cannot be written ({reason(error)}); expected a file in an "
        "existing directory with space and permission to write"
    )


def reason(error: OSError) -> str:
    """Return why the operating system refused."""
    return error.strerror or str(error)
