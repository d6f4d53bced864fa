"""What benches/practical.py measures and writes."""

import json

import practical


def test_the_page_of_practical_scenes_has_the_numbers_beside_it():
    page = practical.PAGE.read_text(encoding="utf-8")
    assert practical.with_table(page, json.loads(practical.NUMBERS.read_text("utf-8"))) == page


def test_a_scene_that_fails_keeps_its_message_and_the_others_their_times(monkeypatch):
    broken = practical.Practical("broken", practical.five_bar, 2e9)  # longer than a run may be
    good = practical.Practical("good", practical.five_bar, 1e-4)
    monkeypatch.setattr(practical, "scenes", lambda: [broken, good])
    rows = practical.all_scenes()
    assert [bool(row["message"]) for row in rows] == [True, True, False, False]
    assert all(row["time"] > 0.0 for row in rows if not row["message"])
    assert len(practical.cells_of(rows[0])) == len(practical.COLUMNS)
