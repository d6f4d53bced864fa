"""Drive files of tests: the example, as it is or with a change."""

from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "three_shafts.toml"


def written(tmp_path, text):
    path = tmp_path / "drive.toml"
    path.write_text(text, encoding="utf-8")
    return path


def changed(tmp_path, old, new):
    """Return the example with a change, beside its table."""
    text = EXAMPLE.read_text(encoding="utf-8")
    assert text.count(old) == 1
    (tmp_path / "machine.csv").write_text((EXAMPLE.parent / "machine.csv").read_text())
    return written(tmp_path, text.replace(old, new))
