"""A chain over two wheels, and random mechanisms, beside an independent code: exudyn."""

import numpy as np
import pytest

import exudyn_mechanisms
import ideal_drive_peer as scene
import mechanism_peers
import rustchain as rc

SPAN = 2e-3


def by_tolerance(tolerance):
    return rc.Solver(method="pece", rtol=tolerance, atol=tolerance, max_step=1e-3)


def test_contacts_press_and_answers_converge():
    """The scene is one of contact: without forces on rollers the links would fall freely."""
    reference, _, _ = scene.by_rustchain(None, SPAN, by_tolerance(1e-11))
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        found, _, _ = scene.by_rustchain(None, SPAN, by_tolerance(tolerance))
        errors.append(np.max(np.abs(found - reference)))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-11
    for accuracy in (1e-4, 1e-6, 1e-8, 1e-10):
        found, _, _ = scene.by_rustchain(accuracy, SPAN)
        error = np.max(np.abs(found - reference))
        assert error < 20 * accuracy  # measured: 0.4, 1.3, 1.4, 11
    fallen = reference[:, 1] - scene.link_places()[:, 1] + 0.5 * scene.GRAVITY * SPAN**2
    assert np.abs(fallen).max() > 1e-5


def test_no_roller_comes_to_a_tip_where_the_codes_are_different_models():
    simulation = scene.simulated(1e-4)
    for t in np.linspace(0.0, scene.SPAN, 11):
        simulation.step_to(t)
        places = simulation.positions
        assert scene.near_tips(places[: scene.LINKS], places[scene.LINKS :]) > 1.1


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # names that older versions need
def test_exudyn_comes_to_the_same_answer_as_its_steps_grow_smaller():
    """Its method is of order two, so that a third of the step leaves a ninth of the error."""
    pytest.importorskip("exudyn")
    reference, _, _ = scene.by_rustchain(1e-10, SPAN)
    errors = []
    for steps in (100, 300, 900):
        found, _ = scene.by_exudyn(steps, SPAN)
        errors.append(np.max(np.abs(found - reference)))
    moved = np.max(np.abs(reference - scene.link_places()[:, :2]))
    # Onsets of contact cost some of the order.
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[1] / 4
    assert errors[2] < 1e-4 * moved


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_falling_chain_of_benches_mechanism_peers_is_the_same_in_both_codes():
    pytest.importorskip("exudyn")
    reference, _, _ = mechanism_peers.by_rustchain(3, 1e-10)
    errors = [
        np.max(np.abs(mechanism_peers.by_exudyn(3, steps)[0] - reference)) for steps in (100, 300)
    ]
    assert errors[1] < errors[0] / 4
    assert errors[1] < 1e-3 * mechanism_peers.LENGTH


# Of 100 that `tests/stress/exudyn_mechanisms.py` compares: trees, closed loops, drivers, gears, and
# bodies on springs alone.
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::rustchain.RustchainWarning")
@pytest.mark.parametrize("seed", [0, 1, 3, 4, 9, 10])
def test_random_mechanisms_move_as_those_of_exudyn(seed):
    pytest.importorskip("exudyn")
    compared = exudyn_mechanisms.compare(seed)
    assert compared.agrees, compared
    assert compared.moved > 1e3 * compared.extrapolated
