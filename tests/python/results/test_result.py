"""What a run hands back: views, errors with a remedy, files, figures."""

import copy
import re
from dataclasses import replace
from types import SimpleNamespace

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import rustchain as rc
import rustchain.simulation.run as sizes
from cores import CoreAround, cores_within
from rustchain.results.channels import VARIABLES
from rustchain.results.values import equal
from rustchain.results.views import Peaks

GROUPS = ("hinges", "teeth", "sprockets", "bodies", "energy")
DURATION, REPORT_STEP = 6e-3, 1e-4
ROWS = 61


@pytest.fixture(scope="module")
def result():
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    return simulation.run(DURATION, REPORT_STEP, record=GROUPS, progress=False)


def test_peaks_are_the_arrays_of_their_names():
    peaks = Peaks(SimpleNamespace(array=lambda name: name))
    names = [name for name, value in vars(Peaks).items() if isinstance(value, property)]
    assert len(names) == 10
    assert [getattr(peaks, name) for name in names] == [f"peak_{name}" for name in names]


@pytest.fixture(scope="module")
def bare():
    """Nothing recorded but time."""
    return rc.Simulation(rc.paper_drive()).run(
        1e-3, record=("energy",), energy=False, progress=False
    )


class BrokenCore(CoreAround):
    """A core that advances a little, then raises."""

    def __init__(self, core, error):
        super().__init__(core)
        self.error, self.calls = error, 0

    def advance(self, wall_budget):
        self.calls += 1
        if self.calls > 1:
            raise self.error
        return self.core.advance(0.0)


def broken(error):
    with cores_within(lambda core: BrokenCore(core, error)):
        return rc.Simulation(rc.paper_drive())


def test_rows_are_at_the_report_times(result):
    np.testing.assert_allclose(result.time, REPORT_STEP * np.arange(ROWS), atol=1e-12)
    assert result.success
    assert result.status == "finished"
    assert result.stats["steps"] > 0


def test_a_second_run_goes_on_where_the_first_ended():
    simulation = rc.Simulation(rc.paper_drive())
    simulation.run(1e-3, progress=False)
    second = simulation.run(1e-3, progress=False)
    np.testing.assert_allclose(second.time[[0, -1]], [1e-3, 2e-3], atol=1e-12)


def test_views_have_one_row_for_each_time(result):
    hinge, bushing, sprocket = result.hinge(6), result.bushing(6), result.sprocket(1)
    for values in (hinge.force, hinge.penetration, bushing.tooth_force, bushing.tooth_penetration):
        assert values.shape == (ROWS,)
    for values in (hinge.force_vector, hinge.eccentricity, sprocket.center):
        assert values.shape == (ROWS, 2)
    for values in (bushing.sprocket, bushing.tooth, bushing.region, sprocket.angle, sprocket.speed):
        assert values.shape == (ROWS,)
    assert sprocket.torque.shape == (ROWS,)
    assert result.strand("upper").tension.shape == result.strand("lower").tension.shape == (ROWS,)
    assert result.energy.residual.shape == result.energy.external_work.shape == (ROWS,)
    assert result.peaks.hinge_force.shape == result.peaks.tooth_impulse.shape == (ROWS, 38)


def test_views_are_columns_of_the_arrays(result):
    np.testing.assert_array_equal(result.hinge(6).force, result.array("hinge_force")[:, 5])
    np.testing.assert_array_equal(result.bushing(38).tooth, result.array("tooth_index")[:, 37])


def test_no_contact_is_sprocket_0_and_tooth_minus_1(result):
    bushing = result.bushing(6)
    none = bushing.sprocket == 0
    assert (bushing.tooth[none] == -1).all()
    assert not bushing.tooth_force[none].any()


def test_the_driver_turns_at_its_speed(result):
    np.testing.assert_allclose(result.sprocket(1).speed, 4 * np.pi, rtol=1e-9)


def test_the_ends_of_the_run_are_kept(result):
    np.testing.assert_array_equal(result.initial_positions, result.array("positions")[0])
    np.testing.assert_allclose(result.final_positions, result.array("positions")[-1], atol=1e-12)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda r: r.hinge(0), "hinges are numbered 1 to 38"),
        (lambda r: r.hinge(39), "hinges are numbered 1 to 38"),
        (lambda r: r.bushing(-1), "bushings are numbered 1 to 38"),
        (lambda r: r.end(1), "end 1: there is none"),
        (lambda r: r.sprocket(3), "sprockets are numbered 1 to 2"),
    ],
)
def test_a_number_out_of_range_is_answered_with_the_range(result, ask, message):
    with pytest.raises(IndexError, match=message):
        ask(result)


def test_an_unknown_strand_is_answered_with_the_nearest(result):
    with pytest.raises(ValueError, match="did you mean 'upper'"):
        result.strand("uper")


@pytest.mark.parametrize(
    ("ask", "remedy"),
    [
        (lambda r: r.hinge(6), "pass record=.*'hinges'"),
        (lambda r: r.strand("upper"), "pass record=.*'hinges'"),
        (lambda r: r.bushing(6), "pass record=.*'teeth'"),
        (lambda r: r.sprocket(1), "pass record=.*'sprockets'"),
        (lambda r: r.peaks.hinge_force, "pass record=.*'hinges'"),
        (lambda r: r.energy, "pass energy=True"),
    ],
)
def test_what_was_not_recorded_is_answered_with_the_remedy(bare, ask, remedy):
    with pytest.raises(rc.NotRecorded, match=remedy):
        ask(bare)


def test_a_time_that_was_not_recorded_is_drawn_at_the_nearer_end_with_a_warning(bare):
    with pytest.warns(UserWarning, match=r"drawn at t = 0 s: .*pass record=.*'bodies'"):
        bare.plot.drive(time=5e-4)


def test_an_unknown_group_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="did you mean 'hinges'"):
        rc.Simulation(rc.paper_drive()).run(1e-3, record=("hinge",), progress=False)


def test_ctrl_c_keeps_what_there_is():
    result = broken(KeyboardInterrupt()).run(2.0, progress=False)
    assert result.status == "interrupted"
    assert not result.success
    assert len(result.time) >= 1


def test_a_run_that_fails_keeps_what_there_is():
    with pytest.raises(rc.SimulationError) as caught:
        broken(rc.SimulationError("step size fell to 3e-16 s")).run(2.0, progress=False)
    kept = caught.value.result
    assert kept.status == "failed"
    assert kept.message == "step size fell to 3e-16 s"
    assert len(kept.time) >= 1


def test_a_file_gives_everything_back(result, tmp_path):
    result.save(tmp_path / "run.nc")
    loaded = rc.load_result(tmp_path / "run.nc")
    assert loaded.arrays.keys() == result.arrays.keys()
    for name, values in result.arrays.items():
        np.testing.assert_array_equal(loaded.arrays[name], values, strict=True)
    for name in ("initial_positions", "initial_velocities", "final_positions", "final_velocities"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(result, name))
    for name in ("drive", "hinge_law", "tooth_law", "solver", "min_impact_velocity", "body_names"):
        assert getattr(loaded, name) == getattr(result, name)
    assert (loaded.status, loaded.message, loaded.stats) == (
        result.status,
        result.message,
        result.stats,
    )


def test_a_long_table_of_speeds_fits_into_a_file(tmp_path):
    times = np.linspace(0.0, 1.0, 5000)
    speed = np.stack([times, 4 * np.pi + 1e-3 * np.sin(times)], axis=1)
    drive = rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 17), links=38, speed=speed)
    rc.Simulation(drive).run(1e-4, record=("energy",), progress=False).save(tmp_path / "run.nc")
    assert rc.load_result(tmp_path / "run.nc").drive == drive


def test_a_file_of_others_is_refused(tmp_path):
    xr = pytest.importorskip("xarray")
    xr.Dataset({"a": 1.0}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(rc.InvalidInput, match="holds no result"):
        rc.load_result(tmp_path / "other.nc")


# Unit by what a name ends in, or is.
UNITS = {
    r".*(force|tension)(_vector)?": "N",
    r".*impulse": "N s",
    r".*(penetration|eccentricity|center)|end_position|position": "m",
    r".*onset_speed|velocity|(end|contact_impact)_velocity": "m/s",
    "acceleration": "m/s^2",
    r"(sprocket_)?angle": "rad",
    "sprocket_speed|angular_velocity": "rad/s",
    "angular_acceleration": "rad/s^2",
    r".*torque": "N m",
    r"energy_.*": "J",
    r".*(index|region|gap|_sprocket|_residual)": "1",
}


def test_quantities_of_one_kind_have_one_unit():
    for name, variable in VARIABLES.items():
        for part, described, _ in variable.parts(name):
            fit = [unit for names, unit in UNITS.items() if re.fullmatch(names, part)]
            expected = ["J"] if name.startswith("energy_") else fit
            assert [described.units] == expected, part


def test_every_variable_of_the_dataset_has_unit_and_name(result):
    dataset = result.to_xarray()
    for variable in dataset.data_vars.values():
        assert variable.attrs["units"]
        assert variable.attrs["long_name"]
    assert dataset["time"].attrs["units"] == "s"
    force = dataset["hinge_force"].sel(hinge=6)
    np.testing.assert_array_equal(force, result.hinge(6).force)
    force = dataset["tooth_force"].sel(bushing=6)
    np.testing.assert_array_equal(force, result.bushing(6).tooth_force)
    np.testing.assert_array_equal(
        dataset["angle"].sel(body="sprocket_1"),
        result.array("positions")[:, 38, 2],
    )


def test_the_table_has_a_column_for_each_number(result):
    table = result.to_pandas()
    assert len(table) == ROWS
    np.testing.assert_array_equal(table["hinge_force_6"], result.hinge(6).force)
    np.testing.assert_array_equal(
        table["hinge_force_vector_6_y"], result.hinge(6).force_vector[:, 1]
    )
    np.testing.assert_array_equal(table["strand_tension_lower"], result.strand("lower").tension)
    np.testing.assert_array_equal(table["energy_residual"], result.energy.residual)


@pytest.mark.parametrize(
    ("draw", "panels"),
    [
        (lambda plot: plot.hinge_force(6, 11), 2),
        (lambda plot: plot.tooth_force(6, 11, start=1e-3), 2),
        (lambda plot: plot.force_penetration(6), 1),
        (lambda plot: plot.force_penetration(6, 8, 10, 12, contact="hinge"), 4),
        (lambda plot: plot.orbit(6), 2),  # with the scale of its colours
        (lambda plot: plot.tension(end=4e-3), 1),
        (lambda plot: plot.energy(), 2),
        (lambda plot: plot.drive(), 1),
        (lambda plot: plot.drive(time=3e-3), 1),
    ],
)
def test_figures_are_drawn(result, draw, panels, tmp_path):
    mpl.use("Agg")
    figure = draw(result.plot)
    figure.savefig(tmp_path / "figure.png")
    assert len(figure.axes) == panels
    plt.close(figure)


def test_a_figure_of_no_rows_says_what_there_is(result):
    with pytest.raises(ValueError, match=r"the result has 0 to 0\.006 s"):
        result.plot.tension(start=1.0)


def test_an_unknown_keyword_of_a_figure_is_answered_with_the_nearest(result):
    with pytest.raises(TypeError, match="did you mean 'start'"):
        result.plot.tension(strat=1.0)


def test_a_loaded_result_draws_itself(result, tmp_path):
    mpl.use("Agg")
    result.save(tmp_path / "run.nc")
    plt.close(rc.load_result(tmp_path / "run.nc").plot.drive(time=3e-3))


@pytest.mark.parametrize("strands", [1, 3])
def test_the_elastic_line_of_a_hinge_belongs_to_all_its_strands(strands):
    """Undamped, points lie on the line of their law, whose length counts every strand."""
    drive = rc.paper_drive()
    drive = replace(drive, chain=replace(drive.chain, strands=strands))
    law = rc.Johnson()  # elastic, and in proportion to the length
    solver = rc.Solver(accuracy=1e-11)  # nothing is lost: at 1e-10 the balance is open
    simulation = rc.Simulation(drive, law, solver=solver)
    result = simulation.run(12e-3, report_step=1e-5, progress=False)
    figure = result.plot.force_penetration(6, contact="hinge")
    dots, line = figure.axes[0].get_lines()
    assert dots.get_xdata().size > 5
    expected = np.interp(dots.get_xdata(), *line.get_data())
    np.testing.assert_allclose(dots.get_ydata(), expected, rtol=0.01, atol=0.02)
    plt.close(figure)


def test_a_file_that_is_no_result_is_told_with_its_name_and_the_remedy(tmp_path, result):
    junk = tmp_path / "junk.npz"
    junk.write_bytes(b"no netCDF")
    whole = tmp_path / "whole.nc"
    result.save(whole)
    cut = tmp_path / "cut.h5"
    cut.write_bytes(whole.read_bytes()[:3000])
    for path in (junk, cut):
        with pytest.raises(rc.InvalidInput, match=rf"{path.name}: is no result.* copy or save"):
            rc.load_result(path)
    with pytest.raises(FileNotFoundError, match=r"path = .*none\.nc: there is no .* Result\.save"):
        rc.load_result(tmp_path / "none.nc")
    with pytest.raises(IsADirectoryError, match=r"path = .* \(Is a dir.*: give .* Result\.save"):
        rc.load_result(tmp_path)


def test_a_file_that_is_damaged_within_is_told(tmp_path, result):
    """The drive's description is text, of which a byte may be another."""
    result.save(tmp_path / "whole.nc")
    whole = (tmp_path / "whole.nc").read_bytes()
    for other in (b'"piiich"', b'"pitch\x00', b'"pitch";'):
        assert whole.count(b'"pitch"') == 1
        path = tmp_path / "other.nc"
        path.write_bytes(whole.replace(b'"pitch": ', other.ljust(9)))
        with pytest.raises(rc.InvalidInput, match=r"path = .*other\.nc: .* is damaged"):
            rc.load_result(path)


def test_a_place_that_cannot_be_written_is_told_with_the_remedy(tmp_path, result):
    with pytest.raises(
        OSError, match=r"path = .*: cannot be written \(Is a dir.*; expected a file"
    ):
        result.save(tmp_path)


@pytest.mark.parametrize("name", ["run.csv", "run.xls", "run.foo", "run.5.NPZ"])
def test_a_name_of_another_kind_of_file_is_refused(tmp_path, result, name):
    simulation = rc.Simulation(rc.paper_drive())
    for field, write in (
        ("path", result.save),
        ("out", lambda path: simulation.run(1e-4, out=path, progress=False)),
    ):
        said = rf"{field} = .*{name}: .* \.nc4, .* take run.*\.nc; result\.to_pandas\(\)\.to_csv"
        with pytest.raises(rc.InvalidInput, match=said):
            write(tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    assert simulation.time == 0.0


def test_a_name_with_a_dot_and_a_number_is_taken(tmp_path, result):
    result.save(tmp_path / "run_25.5")
    np.testing.assert_array_equal(rc.load_result(tmp_path / "run_25.5").time, result.time)


@pytest.mark.filterwarnings("ignore::rustchain.RustchainWarning")  # nothing holds the body
def test_arrays_of_drives_and_mechanisms_are_told_apart(result):
    mechanism = rc.Mechanism(name="ball")
    mechanism.add_body("ball", 1.0, 1e-3)
    ball = rc.Simulation(mechanism).run(1e-3, progress=False)
    with pytest.raises(rc.NotRecorded, match="hinge_force: ball has no hinges; it has recorded"):
        ball.array("hinge_force")
    with pytest.raises(rc.NotRecorded, match="joint_reaction: paper has no joints; it has"):
        result.array("joint_reaction")


def test_an_array_that_there_is_not_is_told_with_the_argument(result):
    for call in (result.array, result.spectrum):
        with pytest.raises(rc.NotRecorded, match="name = '': there is no such array; known: "):
            call("")
        with pytest.raises(rc.NotRecorded, match=r"name = 'hinge_forces': .*mean 'hinge_force'"):
            call("hinge_forces")


def test_more_rows_than_memory_holds_are_refused():
    simulation = rc.Simulation(rc.paper_drive())
    with pytest.raises(rc.InvalidInput, match=r"report_step = 1e-12: gives 1e\+09 rows .* GiB"):
        simulation.run(1e-3, report_step=1e-12)
    assert simulation.time == 0.0


@pytest.mark.parametrize("kind", ["clearance", "rollers", "ideal", "mechanism"])
@pytest.mark.parametrize("record", [("hinges",), ("bodies", "hinges", "teeth", "sprockets")])
def test_the_size_of_a_row_is_what_its_arrays_take(kind, record):
    drive = rc.paper_drive(
        25.0,
        rollers="bodies" if kind == "rollers" else "fixed",
        hinges="ideal" if kind == "ideal" else "clearance",
    )
    scene = drive.to_mechanism() if kind == "mechanism" else drive
    record = ("bodies", "joints", "contacts") if kind == "mechanism" else record
    simulation = rc.Simulation(scene)
    arrays = simulation.run(2e-4, record=record, energy=False, progress=False).arrays
    taken = sum(array[0].nbytes for array in arrays.values())
    assert 8 * sizes.numbers_of_a_row(simulation, record, False) == pytest.approx(taken, rel=0.25)


def test_rows_leave_some_of_the_memory_to_others(monkeypatch):
    simulation = rc.Simulation(rc.paper_drive())
    size = 8 * sizes.numbers_of_a_row(simulation, ["teeth"], False)
    monkeypatch.setattr(sizes, "_memory", lambda: 1e3 * size)
    simulation.run(7.9e-3, 1e-5, record=["teeth"], energy=False, progress=False)
    with pytest.raises(
        rc.InvalidInput, match=r"gives 810 rows .* memory has .* GiB for them: take 1\.0"
    ):
        simulation.run(8.1e-3, 1e-5, record=["teeth"], energy=False, progress=False)


def test_values_are_equal_where_type_and_every_number_are():
    nan = np.array([0.0, np.nan])
    assert equal({"a": (nan, ValueError("b"))}, {"a": (nan.copy(), ValueError("b"))})
    for one, other in (
        (np.zeros(2), np.zeros(2, int)),
        (np.zeros(2), np.array([0.0, 5e-324])),
        (ValueError("a"), ValueError("b")),
        (ValueError("a"), TypeError("a")),
    ):
        assert not equal(one, other)


def test_two_equal_runs_are_equal_whatever_time_they_took():
    one, other = (rc.Simulation(rc.paper_drive()).run(1e-4) for _ in range(2))
    assert one.stats["wall_reports"] != other.stats["wall_reports"]
    assert one == other
    assert one != rc.Simulation(rc.paper_drive()).run(2e-4)
    counted = copy.copy(other)
    counted.__dict__["stats"] = other.stats | {"steps": other.stats["steps"] + 1}
    assert one != counted
