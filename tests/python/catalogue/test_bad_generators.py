"""Wrong arguments of what makes drives and chains, each refused by name."""

import re
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from bad_input.fields import DRIVE
from bad_input.values import INF, NAN


def two_sprockets(**changes):
    return rc.two_sprocket_drive(**{"links": 60, **changes})


def by_distance(**changes):
    return rc.two_sprocket_drive(**{"center_distance": 0.25, **changes})


GENERATORS = [
    *[
        (rc.paper_drive, {"pretension": value}, "retension")
        for value in ("1", NAN, INF, -1.0, True)
    ],
    *[(two_sprockets, {"chain": value}, "chain") for value in (1, None, 40.0, rc.Chain, "ANSI 43")],
    *[
        (two_sprockets, {"teeth": value}, "teeth")
        for value in (17, (17,), (17, 25, 30), (17.5, 25), (4, 25), (17, 1001), "ab", (NAN, 17))
    ],
    *[(two_sprockets, {"links": value}, "links") for value in ("60", 60.5, -2, 0, NAN, 2**40)],
    *[(two_sprockets, {"center_distance": value}, "cent") for value in ("1", NAN, INF, 1j)],
    *[(by_distance, {"center_distance": value}, "cent") for value in ("1", NAN, INF, -1.0, 0.0)],
    *[(two_sprockets, {"speed": value}, "speed") for value in ("1", NAN, None, ((0.0,),))],
    *[(two_sprockets, {"torque": value}, "torque") for value in ("1", NAN, ())],
    *[(two_sprockets, {"pretension": value}, "retension") for value in ("1", NAN, -1.0)],
    *[(two_sprockets, {"seat": value}, "seat") for value in ("x", None, 1)],
    *[(two_sprockets, {"gravity": value}, "gravity") for value in (9.81, (0.0, NAN), (0, 0, 9.81))],
]


@pytest.mark.parametrize(("function", "keyword", "name"), GENERATORS)
def test_a_wrong_argument_of_a_generator_is_refused_by_name(function, keyword, name):
    with pytest.raises(rc.InvalidInput, match=name) as caught:
        function(**keyword)
    assert re.search(
        "must be|expected|must increase|needs at|too few|not in the cat", str(caught.value)
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: two_sprockets(links=60.0), "got 60.0; expected a whole number as an int, 60"),
        (lambda: two_sprockets(links="60"), "got '60'; expected a whole number as an int, 60"),
        (lambda: two_sprockets(links=np.float64(60.0)), "expected a whole number as an int, 60"),
        (
            lambda: rc.catalogue_chain("40", np.float64(60.0)),
            "Chain.links = 60.0: must be a whole number as an int, 60",
        ),
        (lambda: rc.Sprocket(17.0), "Sprocket.teeth = 17.0: must be a whole number as an int, 17"),
        (lambda: two_sprockets(teeth=(17, 25.0)), "got 25.0; expected a whole number as an int, 2"),
        (lambda: two_sprockets(teeth=17), "teeth = 17: must be two whole numbers, such as (17, 25"),
        (lambda: two_sprockets(chain=40), "chain = 40: must be text, a name in the catalogue: '40"),
        (lambda: rc.catalogue_chain(4.0, 60), "a name in the catalogue, such as 'ANSI 40'"),
        (lambda: rc.catalogue_chain(10**5000, 60), "chain = <int>: must be text, a name"),
        (lambda: rc.catalogue_chain(np.int64(40), 60), "a name in the catalogue: '40'"),
        (
            lambda: two_sprockets(profile=rc.AnsiTooth(), seat=np.zeros(3)),
            "two_sprocket_drive(seat): got array([0., 0., 0.]); expected 'bottom-diameter'",
        ),
    ],
)
def test_a_refusal_says_what_to_write_instead(call, message):
    with pytest.raises(rc.InvalidInput, match=re.escape(message)):
        call()


def test_center_distances_at_which_sprockets_overlap_are_refused_by_the_check():
    for distance in (-1.0, 0.0, 0.05):
        with pytest.raises(rc.InvalidInput, match=r"\d m"):
            two_sprockets(center_distance=distance).check()


@pytest.mark.parametrize("links", ["60", None, -2, 60.5, NAN])
def test_wrong_links_of_a_catalogue_chain_are_refused_by_name(links):
    with pytest.raises(rc.InvalidInput, match="links"):
        rc.catalogue_chain("ANSI 40", links)


@pytest.mark.parametrize("name", [40, None, "", "ANSI", "BS 40"])
def test_a_name_that_is_not_in_the_catalogue_is_refused(name):
    with pytest.raises(rc.InvalidInput, match="catalogue"):
        rc.catalogue_chain(name, 60)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"damaged_teeth": [(17, 0.5)]}, r"damaged_teeth = 17: .* 0 to 16"),
        ({"damaged_teeth": [(3, 0.5), (3, 0.2)]}, "each tooth once"),
        ({"damaged_teeth": [(3, 1.5)]}, r"damaged_teeth = 1\.5: must be between 0 and 1"),
        ({"damaged_teeth": [3]}, "must be rows"),
        ({"eccentricity": 0.01}, r"eccentricity = 0\.01: must be below half the pitch"),
        ({"profile": rc.IsoTooth(), "teeth": 8}, "must be between 9 and 150"),
        ({"profile": rc.IsoTooth(tip_diameter=0.05)}, "above the pitch diameter"),
        ({"profile": rc.IsoTooth(roller_diameter=0.0076)}, "seat wider than the bushing"),
        ({"profile": rc.StraightTooth(1.0)}, "pointed"),
    ],
)
def test_teeth_that_cannot_be_are_refused_when_the_drive_is_made(change, words):
    wrong = {"teeth": 17} | change
    with pytest.raises(rc.InvalidInput, match=words):
        replace(DRIVE, sprockets=[rc.Sprocket(**wrong), DRIVE.sprockets[1]])


def test_links_are_counted_with_the_mean_of_their_elongations():
    """A single new link in a chain that is 3 % longer, which takes two links less."""
    sprockets = [rc.Sprocket(17), rc.Sprocket(25, (0.4, 0.0))]
    count = rc.chain_drive("ANSI 40", sprockets).chain.links - 2
    worn = replace(rc.catalogue_chain("ANSI 40", count), elongation=(0.0, *[0.03] * (count - 1)))
    assert rc.chain_drive(worn, sprockets).chain == worn


def test_goods_on_links_beyond_the_first_hundred_stay_where_links_are_counted():
    chain = replace(rc.catalogue_chain("ANSI 40", 200), carried=[(150, 0.5)])
    drive = rc.chain_drive(chain, [rc.Sprocket(17), rc.Sprocket(25, (1.0, 0.0))])
    assert drive.chain.links > 150
    assert drive.chain.carried == ((150, 0.5),)


def test_elongations_of_another_number_of_links_are_refused():
    with pytest.raises(rc.InvalidInput, match="one for each of the 38 links"):
        replace(DRIVE.chain, elongation=(0.0, 0.001, 0.002))
    with pytest.raises(rc.InvalidInput, match="offset"):
        replace(DRIVE.chain, offset=rc.Link(1.0, 1.0))
