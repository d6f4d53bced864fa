"""Operations that are interrupted again and again end in the bits of undisturbed ones."""

import random
import signal
import time

import numpy as np
import pytest

import rustchain as rc

END = 0.05  # [s]


def state_of(simulation):
    return simulation.positions.tobytes() + simulation.velocities.tobytes()


class Stepped:
    """A simulation that steps to a time."""

    def __init__(self, folder):
        self.simulation = rc.Simulation(rc.paper_drive())

    def attempt(self):
        self.simulation.step_to(END)

    def found(self):
        return state_of(self.simulation)


class Run(Stepped):
    """A run, which continues where an interrupt has ended it."""

    def attempt(self):
        begin = self.simulation.time
        if begin < END:
            keywords = {"record": ("teeth",), "progress": False}
            result = self.simulation.run(END - begin, 1e-4, **keywords)
            # All rows up to there: the last is less than a report step, or a step, old.
            assert np.allclose(np.diff(result.time[:-1]), 1e-4, rtol=0.0, atol=1e-9)
            assert len(result.array("tooth_force")) == len(result.time)
            assert result.time[0] == begin
            assert result.time[-1] > self.simulation.time - 2e-4
            if result.status == "interrupted":
                raise KeyboardInterrupt


class Streamed(Stepped):
    """A run whose rows go to a file, a new one after each interrupt."""

    def __init__(self, folder):
        super().__init__(folder)
        self.path = folder / "run.nc"

    def attempt(self):
        begin = self.simulation.time
        if begin < END:
            keywords = {"out": self.path, "memory": "20 MB", "progress": False}
            result = self.simulation.run(END - begin, 1e-4, **keywords)
            if not len(result.time):
                assert result.status == "interrupted"
                with pytest.raises(rc.InvalidInput, match="no row has been written yet"):
                    rc.load_result(self.path)
                raise KeyboardInterrupt
            rows = rc.load_result(self.path)
            assert rows.status == result.status
            assert np.array_equal(rows.time, result.time)
            assert rows.time[-1] > self.simulation.time - 2e-4
            if result.status == "interrupted":
                raise KeyboardInterrupt


class Started:
    """Searches for an initial configuration and for a static equilibrium."""

    def __init__(self, folder):
        self.simulation = None

    def attempt(self):
        self.simulation = rc.Simulation(rc.two_sprocket_drive(links=400), start="static")

    def found(self):
        return state_of(self.simulation)


class Files:
    """A result and a state, which are written over older ones and read."""

    def __init__(self, folder):
        self.result, self.state = folder / "run.nc", folder / "state.npz"
        self.simulation = rc.Simulation(rc.paper_drive())
        self.run = self.simulation.run(1e-3, progress=False)
        self.simulation.save_state(self.state)
        self.run.save(self.result)

    def attempt(self):
        self.run.save(self.result)
        self.simulation.save_state(self.state)
        self.found()

    def found(self):
        assert sorted(path.name for path in self.result.parent.iterdir()) == ["run.nc", "state.npz"]
        rows = rc.load_result(self.result)
        return rows.final_positions.tobytes() + state_of(rc.Simulation.load_state(self.state))


class Swept:
    """A sweep that keeps its cases in a folder."""

    def __init__(self, folder):
        self.folder, self.result = folder, None

    def attempt(self):
        cases = [{"duration": duration} for duration in (1e-3, 2e-3, 3e-3, 4e-3)]
        keywords = {"store": self.folder, "report_step": 1e-3, "progress": False}
        self.result = rc.sweep(rc.paper_drive(), cases, **keywords)
        if self.result.status == "interrupted":
            raise KeyboardInterrupt

    def found(self):
        return b"".join(run.final_positions.tobytes() for run in self.result.results)


class Studied:
    """A study that keeps its runs in a folder."""

    def __init__(self, folder):
        self.folder, self.result = folder, None

    def attempt(self):
        times = {"duration": 2e-3, "burn_in": 1e-3, "report_step": 1e-3}
        keywords = {"runs": 4, "store": self.folder, "progress": False}
        self.result = rc.study(rc.paper_drive(), **times, **keywords)
        if self.result.sweep.status == "interrupted":
            raise KeyboardInterrupt

    def found(self):
        samples = self.result.samples.data_vars
        assert len(samples) > 1
        return b"".join(values.to_numpy().tobytes() for values in samples.values())


# A run that is interrupted early has dissipated little beside its residual.
@pytest.mark.filterwarnings("ignore::rustchain.EnergyWarning")
# A file that is opened while the signal comes is closed by the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.skipif(not hasattr(signal, "SIGPROF"), reason="no timer of processor time here")
@pytest.mark.parametrize("operation", [Stepped, Run, Streamed, Started, Files, Swept, Studied])
def test_interrupts_at_random_moments_lose_nothing_and_change_no_bit(operation, tmp_path):
    """Interrupted again and again, each operation ends in the bits of an undisturbed one."""

    def press(number, frame):
        raise KeyboardInterrupt

    (tmp_path / "calm").mkdir()
    calm = operation(tmp_path / "calm")
    begin = time.process_time()
    calm.attempt()
    takes = time.process_time() - begin  # [s]
    draw = random.Random(1)
    heard = 0
    before = signal.signal(signal.SIGPROF, press)
    try:
        for number in range(40):
            if heard >= 4:
                break
            folder = tmp_path / str(number)
            folder.mkdir()
            disturbed = operation(folder)
            done = False
            while not done:
                try:
                    # The longest waits let it end.
                    signal.setitimer(signal.ITIMER_PROF, draw.uniform(1e-4, 2.0 * takes))
                    try:
                        disturbed.attempt()
                        done = True
                    finally:
                        signal.setitimer(signal.ITIMER_PROF, 0.0)
                except KeyboardInterrupt:
                    heard += 1
            assert disturbed.found() == calm.found()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    assert heard >= 4
