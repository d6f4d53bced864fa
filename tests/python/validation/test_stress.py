"""The random and extreme scenes of tests/stress: their bounds, classes of outcomes, shrinking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import bounds
import extremes
import outcomes
import reliability
import rustchain as rc
import shrink
import studies
import tree
from given_jobs import BRIEF, Given, Hanging
from outcomes import Outcome, outcome_of, table
from scenes import KINDS, Seeded
from workers import outcomes_of


def test_a_seed_alone_decides_its_scene():
    first, again = (outcome_of(Seeded(5, BRIEF)) for _ in range(2))
    assert first == again
    assert {Seeded(seed).kind for seed in range(200)} == set(KINDS)


def test_scenes_that_end_and_scenes_that_are_slow_are_told_apart():
    jobs = [job for k in range(100) if (job := Seeded(k, BRIEF)).kind in ("bouncing", "gears")]
    for outcome in outcomes_of(jobs[:4]):
        assert outcome.outcome == "finished", str(outcome)
    # A limit of processor time that no run can keep: the interrupt is obeyed, the process goes on.
    slow, after = outcomes_of([Given(rc.Scene(rc.paper_drive()), 10.0), jobs[0]], limit=0.5)
    assert slow.outcome == "slow"
    assert not slow.failed
    assert "steps" in slow.message
    assert after.outcome == "finished"


def test_what_obeys_no_interrupt_hangs_and_the_next_scene_has_a_process_again():
    hung, after = outcomes_of([Hanging(rc.Scene(rc.paper_drive())), Seeded(0, BRIEF)], limit=0.3)
    assert hung.outcome == "hang"
    assert hung.failed
    assert "| given | 1 | 0 | 1 |" in table([hung, after])


@pytest.mark.parametrize(
    ("residual", "dissipated", "exchanged", "silent"),
    [(4e-3, 0.1, 1.0, False), (6e-3, 0.1, 1.0, True), (6e-4, 0.0, 1.0, True)],
)
def test_more_than_the_bound_may_not_be_missing_in_silence(residual, dissipated, exchanged, silent):
    energy = {
        "residual": residual,
        "dissipated": dissipated,
        "exchanged": exchanged,
        "stored": 1.0,
        "kinetic": 1.0,
        "at rest": 0.1,
    }
    assert (bounds.balance(energy) > 1.0) is silent
    assert bounds.balance({**energy, "at rest": 1.0}) == 0.0


@pytest.fixture
def result():
    drive = rc.two_sprocket_drive("ANSI 40", (11, 11), links=30, pretension=50.0)
    groups = ("hinges", "teeth", "sprockets", "bodies", "energy")
    return rc.Simulation(drive).run(BRIEF, progress=False, record=groups)


def worst(result):
    found = {}
    for figure in bounds.figures(result):  # one for each wheel
        found[figure.name] = max(figure.value, found.get(figure.name, -np.inf))
    return found


def test_a_result_that_breaks_a_bound_is_seen(result):
    fine = worst(result)
    assert max(fine.values()) < 0.01
    # Seated bushings are at the outline: their centres are a radius away from it.
    assert abs(fine["bushing's centre in a tooth"]) < 0.01
    arrays = {name: np.array(values) for name, values in result.arrays.items()}
    broken = replace(result, arrays=arrays)
    arrays["hinge_penetration"][3, 2] = 0.01
    assert worst(broken)["penetration of a hinge over the radius"] > 1.0
    arrays["velocities"][1, 0, 0] = np.nan
    assert np.isinf(worst(broken)["numbers that are not finite, velocities"])
    # A link moved to the middle of a wheel: its hinge is within the teeth.
    arrays["positions"][2, 0, :2] = arrays["sprocket_center"][2, 0]
    assert worst(broken)["bushing's centre in a tooth"] > 1.0


def test_soft_contacts_and_forces_far_above_the_strength_may_be_penetrated():
    drive = rc.two_sprocket_drive("ANSI 40", (11, 11), links=30, torque=-0.5)
    for stiffness, has_bound in ((0.1, False), (1e8, True)):
        for part in ("hinge", "tooth"):
            laws = {f"{part}_law": rc.Linear(stiffness=stiffness)}
            found, _ = outcomes.run(Given(rc.Scene(drive, **laws)).trial())
            assert (f"penetration of a {part} over the radius" in worst(found)) is has_bound
    for gravity, has_bound in ((-9.81, True), (-9.81e9, False)):
        mechanism = replace(extremes.slider_crank().system, gravity=(0.0, gravity))
        outcome = outcome_of(Given(rc.Scene(mechanism), 4e-3))
        assert not outcome.failed
        assert ("penetration of a contact over the radius" in outcome.worst) is has_bound


def test_outcomes_of_several_files_join_and_failures_run_again(tmp_path):
    first, second, third = (Outcome(str(seed), Seeded(seed).kind, "finished") for seed in range(3))
    broken = replace(second, outcome="drift")
    for name, outcome in (("random_a", first), ("random_b", broken), ("other", third)):
        outcomes.write(outcome, tmp_path / f"{name}.jsonl")
    jobs = [Seeded(seed, BRIEF) for seed in range(2)]
    found = reliability.kept_or_run(jobs, 20.0, tmp_path, "random")
    assert found[0] == first
    assert [outcome.name for outcome in found] == ["0", "1"]
    assert found[1].steps or found[1].message  # it ran
    again = reliability.kept_or_run(jobs, 20.0, tmp_path, "random")
    assert sorted(again, key=lambda outcome: outcome.name) == found
    assert len(outcomes.read(tmp_path / "random.jsonl")) == 1
    assert len((tmp_path / "random.jsonl").read_text().splitlines()) == 1


def test_an_imbalance_in_silence_fails_and_one_with_a_warning_does_not():
    scene = rc.Scene(rc.paper_drive(), solver=rc.Solver("newton", accuracy=1e-7))
    told = outcome_of(Given(scene, 0.02))
    assert told.warned == ["EnergyWarning"]
    assert told.worst["residual, with a warning"] > 1.0
    assert not told.failed
    found = Outcome("", "", "finished")
    with pytest.warns(rc.EnergyWarning):
        result, same = outcomes.run(Given(scene, 0.02).trial())
    outcomes.classify(found, result, same, warned=set())
    assert found.outcome == "silent imbalance"


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("make", extremes.RICH, ids=lambda make: make.__name__)
def test_the_rich_scenes_themselves_hold_every_bound(make):
    outcome = outcome_of(Given(make(), restart=True))
    assert outcome.outcome == "finished", str(outcome)
    assert max(outcome.worst.values()) < 0.5


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_few_random_scenes_hold_every_bound():
    found = list(outcomes_of([Seeded(seed, BRIEF) for seed in range(2000, 2030)]))
    assert not [str(outcome) for outcome in found if outcome.failed]
    assert sum(outcome.outcome == "finished" for outcome in found) > 15


@pytest.mark.parametrize("seed", [81592, 81594, 81814])
def test_static_starts_of_ideal_hinges_shorten_moves_that_do_not_close(seed):
    """With an indefinite matrix the projections of a long move diverge."""
    scene = replace(Seeded(seed).trial().scene, start="static")
    assert scene.drive.hinges == "ideal"
    rest = rc.Simulation(scene).rest
    assert rest["residual"] < 1e-6 * rest["largest_force"]


def test_a_number_of_a_rich_scene_is_multiplied():
    path = ("system", "chain", "material", "elastic_modulus")
    job = extremes.Extreme("published", path, 1e-3)
    assert job in extremes.jobs()
    material = extremes.published().drive.chain.material
    modulus = 1e-3 * material.elastic_modulus
    assert job.trial().scene.drive.chain.material.elastic_modulus == modulus
    path = ("system", "chain", "hinge", "bore_radius")
    (refused,) = outcomes_of([extremes.Extreme("published", path, 1e-9)])
    assert refused.outcome == "refused"


def test_a_failing_scene_becomes_a_small_file(tmp_path, monkeypatch):
    # Stands for a defect: whatever has rollers fails.
    def fails(jobs, limit):
        for job in jobs:
            try:
                failing = job.trial().scene.drive.chain.roller is not None
            except rc.InvalidInput:
                failing = False
            yield Outcome(job.name, job.kind, "panic" if failing else "finished")

    monkeypatch.setattr(shrink, "outcomes_of", fails)
    job = Given(extremes.rollers(), restart=True)
    simpler = shrink.simplified(job, Outcome("", "", "panic"), 1.0, seconds=20.0)
    scene = simpler.trial().scene
    assert scene.drive.chain.roller is not None
    assert scene.tooth_law is None
    assert scene.law_of_teeth.friction is None
    assert scene.drive.chain.carried == ()
    assert scene.drive.sprockets[0].eccentricity == 0.0
    assert not simpler.restart
    assert len(list(tree.numbers(tree.tree_of(scene)))) < 45
    shrink.to_file(job, Outcome("", "", "panic"), tmp_path, 1.0)
    assert rc.load_scene(tmp_path / "given.toml").drive.chain.roller is not None


def test_a_promise_counts_what_broke_it_and_names_the_worst_figure():
    name = "residual, without a warning"
    held = Outcome("1", "", "finished", worst={name: 0.4}, features=["restart"])
    broken = Outcome("2", "", "silent imbalance", worst={name: 3.0})
    refused = Outcome("3", "", "refused", "a cause")
    rows = reliability.rows_of_scenes("random", "test", [held, broken, refused])
    balance = rows[0]
    assert (balance.cases, balance.failures, balance.worst) == (2, 1, "3 of the bound")
    restart = next(row for row in rows if "restart" in row.promise)
    assert (restart.cases, restart.failures) == (1, 0)
    assert sum(row.failures for row in rows) == 1
    assert set(outcomes.FAILURES) == {
        name for _, names, _ in reliability.OF_SCENES for name in names
    }


def test_the_tests_of_every_promise_are_there():
    for _, paths, _ in reliability.OF_PYTEST:
        for path in paths:
            assert (reliability.ROOT / "tests" / "python" / path).is_file(), path


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_studies_have_both_ends_of_every_range():
    values = {run.kind: [] for run in studies.runs()}
    for run in studies.runs():
        values[run.kind].append(run.value)
    assert max(values["mass ratio of rods"]) == 1e6
    assert min(values["minimum impact velocity"]) == 1e-7
    assert max(values["links"]) == 10_000
    (found,) = studies.all_outcomes(studies.runs("mass ratio")[-1:])
    assert studies.share(found) < 1e-8
