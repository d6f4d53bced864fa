"""The efficiencies of benches/lanes_of_drives.py."""

import numpy as np
import pytest

from lanes_of_drives import EVALUATION, attempts, common_step, own_times


def steps(size, count, evaluations=1.0, rejected=0.0):
    """Return a history of equal steps."""
    table = np.zeros((count, 5))
    table[:, 0] = size * np.arange(count)
    table[:, 1:4] = rejected, evaluations, 1.0
    return table


def test_equal_drives_lose_nothing():
    drives = [steps(5e-6, 100)] * 8
    assert own_times(drives) == pytest.approx(1.0)
    assert common_step(drives) == pytest.approx(1.0)


def test_with_a_common_step_a_drive_of_twice_the_step_size_does_half_of_its_steps_in_vain():
    drives = [steps(5e-6, 100), steps(1e-5, 50)]
    assert common_step(drives) == pytest.approx(0.75)
    assert own_times(drives) == pytest.approx(1.0)


def test_with_times_of_their_own_all_wait_for_a_second_evaluation():
    drives = [steps(5e-6, 100), steps(5e-6, 100, evaluations=2.0)]
    expected = (1.0 + 0.5 * EVALUATION) / (1.0 + EVALUATION)
    assert own_times(drives) == pytest.approx(expected)


def test_a_rejected_attempt_is_one_more():
    assert len(attempts(steps(5e-6, 10, evaluations=2.0, rejected=1.0))) == 20
