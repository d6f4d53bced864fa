"""FMUs of a drive with all kinds of inputs."""

from __future__ import annotations

import pytest

import rustchain as rc
from rustchain.fmi import export


@pytest.fixture(scope="session", autouse=True)
def library():
    """Skip where the library was not built, as `make test-python` does first."""
    try:
        return export.library_path()
    except rc.MissingExtra as error:
        pytest.skip(str(error))


@pytest.fixture(params=("2.0", "3.0"))
def version(request):
    return request.param


@pytest.fixture(scope="session")
def drive():
    """Return a drive with an input of each kind: speed, torque and force of the tensioner."""
    return rc.two_sprocket_drive(
        "ANSI 40", teeth=(17, 25), links=60, speed=12.566, torque=-2.0, pretension=40.0
    )


@pytest.fixture(scope="session")
def fmus(drive, tmp_path_factory):
    """Return an FMU of the drive by version."""
    folder = tmp_path_factory.mktemp("fmus")
    paths = {version: folder / f"drive {version[0]}.fmu" for version in ("2.0", "3.0")}
    for version, path in paths.items():
        rc.export_fmu(drive, path, version=version)
    return paths


@pytest.fixture
def fmu(fmus, version):
    return fmus[version]
