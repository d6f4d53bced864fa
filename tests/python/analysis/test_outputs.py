"""Outputs by hand-made histories: each number against what the history was made to hold."""

from dataclasses import replace

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.integrate import trapezoid

import rustchain as rc
from rustchain._rustchain import tooth_radii
from rustchain.analysis import rainflow
from rustchain.analysis.circuit import Belt, Circuit
from rustchain.analysis.loads import nearest_contact
from rustchain.analysis.pressure import half_width, line_pressure, surface_curvature

GROUPS = ("hinges", "teeth", "sprockets", "bodies", "energy")
EQUAL = rc.two_sprocket_drive(teeth=(17, 17), links=60, torque=-1.0, pretension=25.0)
UNEQUAL = rc.two_sprocket_drive(teeth=(17, 25), links=60, torque=-1.0)
THREE = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(12.566)),
        rc.Sprocket(25, (0.35, -0.05), rc.AppliedTorque(-2.0)),
        rc.Sprocket(13, (0.18, -0.005), side="outside"),
    ],
)
BACKWARD = rc.two_sprocket_drive(teeth=(25, 17), links=60, speed=-12.0)


@pytest.fixture(scope="module")
def run():
    return rc.Simulation(EQUAL).run(0.12, record=GROUPS, progress=False)


@pytest.fixture(scope="module")
def three():
    return rc.Simulation(THREE).run(0.05, record=GROUPS, progress=False)


def counted_from_elsewhere(drive):
    """Return its scene with other numbers for the same links, and sprockets turned by teeth."""
    generated = rc.Simulation(drive)
    positions, velocities = generated.positions.copy(), generated.velocities.copy()
    links = drive.chain.links
    for rows in (positions, velocities):
        rows[:links] = np.roll(rows[:links], -2 * (links // 5), axis=0)
    for k, teeth in enumerate((17, -9, 13)[: len(drive.sprockets)]):
        positions[links + k, 2] += 2 * np.pi * teeth / drive.sprockets[k].teeth
    return rc.Scene(drive, positions=positions, velocities=velocities)


@pytest.mark.parametrize("scene", [rc.Scene, counted_from_elsewhere])
@pytest.mark.parametrize("drive", [EQUAL, UNEQUAL, THREE, BACKWARD])
def test_seated_hinges_are_where_the_way_says(drive, scene):
    """Over a while, each hinge of a wrap's middle stands at its place's angle and radius."""
    result = rc.Simulation(scene(drive)).run(
        0.02, record=("sprockets", "bodies", "energy"), progress=False
    )
    circuit, report = Circuit.of(drive), drive.check()
    row = len(result.time) - 1
    places = circuit.positions(result)[row]
    poses = result.array("positions")[row]
    pitch = drive.chain.pitch
    seen = 0
    for section in circuit.sections:
        if section.sprocket is None or section.end - section.begin < 3.0:
            continue
        k = section.sprocket - 1
        center = result.array("sprocket_center")[row, k]
        belt = Belt.around(drive, result.array("sprocket_center")[row:])
        entry = belt.meeting[0, report.order.index(k + 1)]
        along = np.mod(places - section.begin, circuit.links)
        for hinge in np.flatnonzero((along > 1.0) & (along < section.end - section.begin - 1.0)):
            x, y, angle = poses[hinge]
            front = np.array([x, y]) + 0.5 * pitch * np.array([np.cos(angle), np.sin(angle)])
            offset = front - center
            turn = entry + along[hinge] * 2 * np.pi / drive.sprockets[k].teeth
            expected = report.pitch_radius[k] * np.array([np.cos(turn), np.sin(turn)])
            # Play in the seats and hinges, and the slack of the start.
            assert np.hypot(*(offset - expected)) < 0.1 * pitch
            seen += 1
    assert seen > 10


def test_motion_of_a_strand_does_not_depend_on_how_turns_are_counted():
    groups = ("hinges", "teeth", "sprockets", "bodies", "energy")
    here, there = (
        rc.Simulation(scene(UNEQUAL)).run(4e-3, record=groups, progress=False)
        for scene in (rc.Scene, counted_from_elsewhere)
    )
    for name in ("upper", "lower"):
        expected = here.strand_motion(name)
        np.testing.assert_allclose(there.strand_motion(name), expected, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("turns", [-2, 2, -50])
def test_whole_turns_of_a_given_sprocket_change_no_strand_and_no_load(turns):
    """They are more pitches than half of the chain, whose hinges count modulo its links."""
    drive = rc.paper_drive(25.0)
    generated = rc.Simulation(drive)

    def run(turned):
        positions = generated.positions.copy()
        positions[drive.chain.links, 2] += 2 * np.pi * turned
        scene = rc.Scene(drive, positions=positions, velocities=generated.velocities)
        groups = ("hinges", "sprockets", "bodies")
        return rc.Simulation(scene).run(2e-3, record=groups, progress=False)

    here, there = run(0), run(turns)
    expected = here.strand_motion("upper")
    np.testing.assert_allclose(there.strand_motion("upper"), expected, rtol=0.0, atol=1e-7)
    expected = here.hinge_loads()
    for name, values in there.hinge_loads().items():
        np.testing.assert_allclose(values, expected[name], rtol=1e-3, atol=1e-3)


def test_sections_meet_and_go_once_round():
    for drive in (EQUAL, UNEQUAL, THREE, BACKWARD):
        sections = Circuit.of(drive).sections
        ends = [section.end for section in sections]
        begins = [section.begin for section in sections]
        np.testing.assert_allclose(begins[1:], ends[:-1])
        assert ends[-1] - begins[0] == pytest.approx(drive.chain.links)
        # Strands are as long as the tangents between the pitch circles.
        centers = np.array([[sprocket.center for sprocket in drive.sprockets]])
        belt = Belt.around(drive, centers)
        for place, strand in enumerate(sections[1::2]):
            begin, end = belt.strand(place)
            length = np.hypot(*(end - begin)[0]) / drive.chain.pitch
            assert strand.end - strand.begin == pytest.approx(length, abs=1.3)


def test_means_over_the_way_add_up_to_all_impulses(run):
    loads = run.hinge_loads()
    total = run.peaks.hinge_impulse.sum() / np.ptp(run.time)
    assert float(loads["hinge_mean"].sum()) == pytest.approx(total, rel=1e-12)
    # Every place of the way sees one hinge a pitch; bins empty as yet have no mean.
    teeth = sum(float(run.tooth_loads(k)["tooth_mean"].sum()) for k in (1, 2))
    # A bushing that was hit between two reports, and found in contact at none, belongs to no gap.
    assert teeth == pytest.approx(run.peaks.tooth_impulse.sum() / np.ptp(run.time), rel=5e-3)


def test_a_load_that_follows_the_place_is_found_at_its_place(run):
    """Forces replaced by a function of the place: mean, quantiles and largest are that function."""
    circuit = Circuit.of(run.drive)
    made = 10.0 + 5.0 * np.sin(2 * np.pi * circuit.positions(run) / circuit.links)
    steps = np.diff(run.time, prepend=run.time[0])[:, None]
    arrays = run.arrays | {
        "hinge_force": made,
        "peak_hinge_force": made,
        "peak_hinge_impulse": made * steps,
    }
    loads = replace(run, arrays=arrays).hinge_loads()
    place = loads["position"].to_numpy()
    expected = 10.0 + 5.0 * np.sin(2 * np.pi * place / circuit.links)
    for found in (loads["mean"], loads["largest"], *loads["quantiles"].T):
        # Within a bin of a quarter pitch the function moves by less than 0.14 N.
        np.testing.assert_allclose(found, expected, atol=0.14, equal_nan=False)


def test_an_impact_between_rows_belongs_to_the_contact_nearest_in_time():
    """A bushing leaves sprocket 1, and touches sprocket 2 between two rows before it is seated."""

    class History:
        def array(self, name):
            assert name == "tooth_sprocket"
            return np.array([[1, 1, 0, 0, 0, 0, 0, 2, 2, 0], [0] * 10, [0] * 5 + [1] + [0] * 4]).T

    first, never, once = nearest_contact(History()).T.tolist()
    assert first == [0, 1, 1, 1, 1, 7, 7, 7, 8, 8]
    assert never == list(range(10))
    assert once == [5] * 10


def test_tension_is_the_force_along_the_chain_in_the_strands(run):
    pull = run.link_tension(start=0.1)
    circuit = Circuit.of(run.drive)
    section = circuit.section("strand upper")
    inside = circuit.positions(run)[-1]
    hinges = (inside > section.begin + 1) & (inside < section.end - 1)
    last = pull.isel(time=-1).to_numpy()[hinges]
    np.testing.assert_allclose(last, run.array("hinge_force")[-1, hinges], rtol=0.02)
    assert last.mean() == pytest.approx(run.strand("upper").tension[-1], rel=0.02)


@pytest.mark.parametrize("order", [3, 17])
def test_an_error_of_one_order_is_found_at_that_order(run, order):
    time = np.linspace(0.0, 1.0, 4001)
    driver = 2 * np.pi * 4.0 * time
    angles = np.stack([driver, driver + 1e-3 * np.sin(order * driver) + 0.2], axis=-1)
    arrays = {
        "time": time,
        "sprocket_angle": angles,
        "sprocket_speed": np.gradient(angles, time, axis=0),
    }
    made = replace(run, arrays=arrays)
    error = made.transmission_error()
    assert error.attrs["peak_to_peak"] == pytest.approx(2e-3, rel=1e-3)
    assert abs(float(error["error"].mean())) < 1e-9
    strongest = int(error["amplitude"].to_numpy().argmax())
    assert float(error["order"][strongest]) == pytest.approx(order, rel=1e-3)
    assert float(error["amplitude"][strongest]) == pytest.approx(1e-3, rel=0.01)
    ripple = made.speed_ripple()
    strongest = int(ripple["amplitude"].to_numpy().argmax())
    assert float(ripple["order"][strongest]) == pytest.approx(order, rel=1e-3)
    assert float(ripple["amplitude"][strongest]) == pytest.approx(1e-3 * order, rel=0.01)


def test_an_outside_sprocket_turns_the_other_way(three):
    """The mean ratio has the sign of the side: the error of the idler stays within its play."""
    error = three.transmission_error(driven=3)
    assert error.attrs["ratio"] == pytest.approx(-17 / 13)
    assert error.attrs["peak_to_peak_length"] < 0.3 * THREE.chain.pitch


def test_powers_balance_and_named_channels_are_taken_as_they_come(run):
    power = run.power_balance()
    put_in, lost = float(power["shaft_power"].sum()), float(power["loss"].sum())
    grown, missing = float(power["stored"].sum()), float(power["residual"])
    assert put_in - lost - grown + missing == pytest.approx(0.0, abs=1e-9 * abs(put_in))
    load = -trapezoid(run.sprocket(2).torque * run.sprocket(2).speed, run.time) / np.ptp(run.time)
    assert -float(power["shaft_power"].sel(sprocket=2)) == pytest.approx(load)
    assert float(power["efficiency"]) == pytest.approx(load / (load + lost))

    places = ["hinge_contact", "tooth_contact", "hinge_friction", "tooth_friction"]
    assert list(power["channel"].to_numpy()) == ["dashpots", *places]
    for place in places:
        grown = np.ptp(run.array(f"energy_{place}"))
        found = float(power["loss"].sel(channel=place))
        assert found == pytest.approx(grown / np.ptp(run.time))
    assert float(power["loss"].sel(channel=places[2:]).sum()) == 0.0  # no friction
    assert float(power["loss"].sel(channel=places[:2]).sum()) > 0.0

    dissipated = run.array("energy_dissipated")
    arrays = {name: value for name, value in run.arrays.items() if name[7:] not in places}
    arrays |= {"energy_hinge_friction": 0.25 * dissipated}
    named = replace(run, arrays=arrays).power_balance()["loss"]
    assert list(named["channel"].to_numpy()) == ["contacts and dashpot", "hinge_friction"]
    np.testing.assert_allclose(named, [0.75 * lost, 0.25 * lost])
    arrays |= {"energy_tooth_contact": 0.5 * dissipated}
    named = replace(run, arrays=arrays).power_balance()["loss"]
    assert float(named.sel(channel="dashpots")) == pytest.approx(0.25 * lost)


def test_power_of_the_only_motor_is_that_of_its_sampled_torque_on_average():
    """Without impacts between the rows, both ways to the motor's power agree."""
    drive = rc.two_sprocket_drive(teeth=(17, 17), links=60, torque=-3.0, pretension=100.0)
    result = rc.Simulation(drive).run(0.3, report_step=2e-5, progress=False)
    power = result.power_balance(start=0.15)
    late = result.time >= 0.15
    motor = result.sprocket(1)
    sampled = trapezoid((motor.torque * motor.speed)[late], result.time[late]) / 0.15
    assert float(power["shaft_power"].sel(sprocket=1)) == pytest.approx(sampled, rel=0.02)


@pytest.mark.parametrize("force", [1.0, 200.0])
@pytest.mark.parametrize("radius", [4e-3, 50e-3])
def test_line_contact_carries_its_force(force, radius):
    """The half ellipse of pressure over the width holds the force: pi/2 p b L = F."""
    length, modulus = 7e-3, 1.137e11
    pressure = line_pressure(np.array(force), 1.0 / radius, length, modulus)
    width = half_width(np.array(force), 1.0 / radius, length, modulus)
    assert 0.5 * np.pi * pressure * width * length == pytest.approx(force)
    # Johnson, Contact Mechanics, 4.2c: b^2 = 4 F R / (pi L E*).
    assert width == pytest.approx(np.sqrt(4 * force * radius / (np.pi * length * modulus)))


def test_curvatures_are_those_of_the_standard_tooth():
    """ANSI B29.1: R = 0.5025 Dr + 0.0015 in, E = 1.3025 Dr + 0.0015 in, then the flat, then F."""
    drive = rc.paper_drive()
    roller, inch = 7.9375e-3, 0.0254
    seat, working, flat, topping = tooth_radii(drive.sprockets[0], drive.chain)
    assert seat == pytest.approx(0.5025 * roller + 0.0015 * inch)
    assert working == pytest.approx(1.3025 * roller + 0.0015 * inch)
    assert flat == np.inf
    a, b, n = np.radians([17.0, 18.0]).tolist() + [17]
    angles = np.cos(np.radians(18.0 - 56.0 / n)), np.cos(np.radians(17.0 - 64.0 / n))
    assert a < b
    expected = roller * (0.8 * angles[0] + 1.4 * angles[1] - 1.3025) - 0.0015 * inch
    assert -topping == pytest.approx(expected)
    curvature = surface_curvature(drive, 1)
    assert curvature[0] == pytest.approx(2 / roller - 1 / seat)
    assert curvature[2] == pytest.approx(2 / roller)
    assert curvature[3] == pytest.approx(2 / roller + 1 / expected)


def test_pressures_follow_the_forces_and_the_surfaces(run):
    chain = run.drive.chain
    found = run.contact_pressure("hinge")
    reduced = 1 / (1 / chain.hinge.pin_radius - 1 / chain.hinge.bore_radius)
    modulus = 2.07e11 / (2 * (1 - 0.3**2))
    expected = np.sqrt(run.array("hinge_force") * modulus / (np.pi * chain.hinge.length * reduced))
    np.testing.assert_allclose(found["pressure"], expected)
    teeth = run.contact_pressure("tooth")
    touching = run.array("tooth_sprocket") > 0
    region = np.abs(run.array("tooth_region") - 4)[touching]
    curvature = surface_curvature(run.drive, 1)[region]
    force = run.array("tooth_force")[touching]
    length = chain.tooth_contact_length
    np.testing.assert_allclose(
        teeth["pressure"].to_numpy()[touching],
        np.sqrt(force * modulus * curvature / (np.pi * length)),
    )
    assert (teeth["peak_pressure"] >= teeth["pressure"]).all()


def test_three_strands_share_the_force():
    drive = rc.paper_drive()
    wide = replace(drive, chain=replace(drive.chain, strands=3))
    runs = [rc.Simulation(d).run(6e-3, progress=False) for d in (drive, wide)]
    length = [float(r.contact_pressure("tooth").attrs["length"]) for r in runs]
    assert length[1] == pytest.approx(3 * length[0])


def test_rainflow_counts_the_example_of_the_standard():
    """ASTM E1049-85, Figure 6: the history A to I and its cycles."""
    history = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
    ranges, cycles = rainflow.count(history)
    found = {float(r): float(cycles[ranges == r].sum()) for r in np.unique(ranges)}
    assert found == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


@pytest.mark.parametrize("seed", range(5))
def test_rainflow_forgets_small_swings_alone(seed):
    """Points between reversals do not count; a gate takes small swings and leaves large ones."""
    rng = np.random.default_rng(seed)
    turns = rng.uniform(10.0, 20.0, 40) * np.resize([1.0, -1.0], 40)
    fine = np.interp(np.linspace(0, 39, 39 * 8 + 1), np.arange(40), turns)
    for one, other in zip(rainflow.count(turns), rainflow.count(fine), strict=True):
        np.testing.assert_allclose(one, other)
    noisy = fine + np.resize([0.0, 0.4], fine.size) * np.resize([1.0, 1.0, -1.0, -1.0], fine.size)
    gated = rainflow.count(noisy, gate=2.0)
    assert gated[1].sum() == rainflow.count(turns)[1].sum()


def test_pressure_cycles_of_a_steady_beat_are_counted_per_revolution(run):
    """A hinge that is pressed once a row and let go: a cycle a row, whatever the part looked at."""
    rows = len(run.time)
    force = np.zeros_like(run.array("hinge_force"))
    peak = np.full_like(force, 50.0)
    made = replace(run, arrays=run.arrays | {"hinge_force": force, "peak_hinge_force": peak})
    cycles = made.pressure_cycles("hinge", bins=4)
    turns = cycles.attrs["revolutions"]
    np.testing.assert_allclose(cycles["cycles"].sum("range") * turns, rows - 1)
    assert float(cycles["cycles"].isel(range=slice(0, 3)).sum()) == 0.0


def test_strand_motion_begins_with_the_sag_of_the_layout(three):
    """Gravity down: the slack of the long strand hangs outward; the others are straight."""
    report = THREE.check()
    middle = {name: three.strand_motion(name, stations=(0.5,)) for name in three.strand_names}
    for name, sag in zip(report.strands, report.sag, strict=True):
        # The sag counts from the seated ends, which are within a pitch of the tangent points.
        assert float(middle[name][0, 0]) == pytest.approx(sag, abs=1e-3)
    assert max(report.sag) > 5e-3
    assert middle["1-2"].attrs["length"] == pytest.approx(report.strand_span[0], rel=0.05)


def test_engagements_are_the_visits_of_the_bushings(run):
    found = run.engagements()
    assert len(found) > 6
    speed = 12.566 * 17 / (2 * np.pi)  # [pitches/s]
    for number in (1, 2):
        times = found[found["sprocket"] == number]["time"].to_numpy()
        # A bushing a pitch comes into each sprocket, give or take those that bounce out again.
        assert len(times) >= 0.8 * speed * 0.1
    assert (found["largest_force"] >= found["force"] - 1e-12).all()
    assert (found["force"] > 0.0).all()
    assert found["time"].is_monotonic_increasing
    one = found.iloc[len(found) // 2]
    row = int(np.flatnonzero(run.time == one["time"])[0])
    bushing = run.bushing(int(one["bushing"]))
    row += int(np.argmax(bushing.sprocket[row:] > 0))  # an impact may be over before its row
    assert (bushing.sprocket[row], bushing.tooth[row]) == (one["sprocket"], one["tooth"])


def test_a_part_of_a_result_is_a_result(run, tmp_path):
    part = run.between(0.05, 0.1)
    assert part.time[0] == pytest.approx(0.05)
    assert part.time[-1] == pytest.approx(0.1)
    np.testing.assert_array_equal(part.initial_positions, run.array("positions")[500])
    assert part.transmission_error().attrs == run.transmission_error(start=0.05, end=0.1).attrs
    part.save(tmp_path / "part.nc")
    assert len(rc.load_result(tmp_path / "part.nc").time) == len(part.time)
    bare = (
        rc.Simulation(EQUAL).run(2e-3, record=("sprockets", "energy"), progress=False).between(1e-3)
    )
    assert np.isnan(bare.initial_positions).all()
    assert np.isfinite(bare.final_positions).all()


def test_summary_takes_what_is_there(run):
    late = run.time >= 0.05
    mean = trapezoid(run.strand("upper").tension[late], run.time[late]) / np.ptp(run.time[late])
    assert run.summary(start=0.05)["tension_upper"] == pytest.approx(mean)
    bare = rc.Simulation(EQUAL).run(2e-3, record=("hinges", "energy"), energy=False, progress=False)
    assert {name.split("_")[0] for name in bare.summary()} == {"tension", "hinge"}


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda r: r.wrap_loads(3), "1 to 2"),
        (lambda r: r.contact_pressure("tooht"), "did you mean 'tooth'"),
        (lambda r: r.pressure_cycles("hinge", 1), "only teeth"),
        (lambda r: r.strand_motion("uper"), "did you mean 'upper'"),
        (lambda r: r.strand_motion("upper", stations=(0.5, 1.5)), "between 0 and 1"),
        (lambda r: r.engagements(within=0.0), "positive"),
        (lambda r: r.between(5.0), "no rows"),
        (lambda r: r.power_balance(start=0.12), "two rows"),
        (lambda r: r.transmission_error(driven=0), "1 to 2"),
        (lambda r: r.transmission_error(1, 1), r"transmission_error\(driven\): got 1, .* driver"),
        (lambda r: r.efficiency(after=5.0), "^after = 5: 0 rows there, a power needs two"),
        (lambda r: r.efficiency(after=0.12), "^after = 0.12: 1 rows there"),
    ],
)
def test_bad_requests_name_what_is_allowed(run, ask, words):
    with pytest.raises(rc.InvalidInput, match=words):
        ask(run)


def test_what_was_not_recorded_is_named():
    bare = rc.Simulation(EQUAL).run(1e-3, record=("hinges", "energy"), energy=False, progress=False)
    for ask, group in (
        (bare.link_tension, "bodies"),
        (bare.hinge_loads, "sprockets"),
        (bare.power_balance, "energy=True"),
        (bare.engagements, "teeth"),
    ):
        with pytest.raises(rc.NotRecorded, match=group):
            ask()


@pytest.mark.parametrize("frequency", [40.0, 333.0])
def test_a_spectrum_has_a_line_at_its_frequency_and_the_power_of_the_signal(run, frequency):
    wave = 3.0 * np.sin(2 * np.pi * frequency * run.time)
    tension = np.stack([wave, 2.0 * wave], axis=-1) + 7.0
    found = replace(run, arrays=run.arrays | {"strand_tension": tension}).spectrum("strand_tension")
    assert found.dims == ("strand", "frequency")
    hertz = found["frequency"].to_numpy()
    upper = found.sel(strand="upper").to_numpy()
    assert hertz[upper.argmax()] == pytest.approx(frequency, abs=1.1 * hertz[1])
    # Parseval: the density's integral is the mean square, 3^2 / 2; a cut-off wave leaves a little.
    assert trapezoid(upper, hertz) == pytest.approx(4.5, rel=0.05)
    np.testing.assert_allclose(found.sel(strand="lower"), 4.0 * upper, rtol=1e-6, atol=1e-12)


def test_spectra_of_parts_are_drawn(run):
    mpl.use("Agg")
    for draw, lines in (
        (lambda: run.plot.spectrum("strand_tension"), 2),
        (lambda: run.plot.spectrum("hinge_force", hinge=6), 1),
        (lambda: run.plot.spectrum("hinge_force"), 1),
    ):
        figure = draw()
        assert len(figure.axes[0].get_lines()) == lines
        plt.close(figure)
    with pytest.raises(rc.InvalidInput, match="did you mean 'strand'"):
        run.plot.spectrum("strand_tension", stran="upper")
    with pytest.raises(rc.InvalidInput, match="no finite numbers"):
        run.spectrum("tooth_penetration")


def test_the_spectrum_of_a_strand_whose_places_are_no_numbers_is_refused(run):
    positions = run.array("positions").copy()
    positions[3:] = np.nan
    broken = replace(run, arrays={**run.arrays, "positions": positions})
    with pytest.raises(rc.InvalidInput, match=r"positions: \d+ of \d+ values are no finite"):
        broken.strand_spectrum("upper")


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
@pytest.mark.parametrize("duration", [1e-3, 6e-3])
def test_runs_before_and_after_the_first_contact_have_all_outputs(hinges, duration):
    """Nothing touches before 4 ms: outputs are zero or empty there, and figures are drawn."""
    mpl.use("Agg")
    result = rc.Simulation(rc.paper_drive(hinges=hinges)).run(
        duration, record=GROUPS, progress=False
    )
    found = result.summary()
    assert all(np.isfinite(value) for value in found.values())
    assert (found["tooth_force_largest"] > 0.0) == (duration > 4e-3)
    assert len(result.engagements()) == (result.array("tooth_sprocket")[1:] > 0).any(0).sum()
    names = ("hinge_loads", "tooth_loads", "wrap_loads", "power_balance", "engagements")
    names += ("transmission_error", "speed_ripple")
    for figure in (
        *(getattr(result.plot, name)() for name in names),
        result.plot.contact_pressure("hinge"),
        result.plot.contact_pressure("tooth"),
    ):
        plt.close(figure)


def test_figures_of_a_drive_that_hardly_turned_are_zero_where_they_are_rounding():
    result = rc.Simulation(rc.paper_drive(25.0)).run(
        8e-4, record=("hinges", "sprockets"), progress=False
    )
    found = result.summary()
    assert found["transmission_error_2"] == 0.0
    assert found["ripple_2"] == 0.0
    assert result.transmission_error().attrs["peak_to_peak"] == 0.0
    # A pull of rounding alone has no deviation.
    tension = np.full_like(result.array("strand_tension"), 0.1)
    tension[::3] *= 1.0 + 4e-16
    even = replace(result, arrays=result.arrays | {"strand_tension": tension})
    assert even.summary()["tension_upper_std"] == 0.0
