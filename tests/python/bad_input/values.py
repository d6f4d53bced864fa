"""Wrong values by what a field may hold, with what the message then allows; how a refusal reads."""

import contextlib
import math
import re

import numpy as np

NAN, INF = math.nan, math.inf

# What a field may hold, in words for the table below: wrong values and what the message allows.
NO_NUMBER = ["1", b"1", None, True, (1.0, 2.0), [], 1 + 2j, object, np.array([1.0])]
NO_OPTION = [value for value in NO_NUMBER if value is not None]
POSITIVE = [NAN, INF, -INF, -1.0, -1, 0.0, 0, np.float32("nan")]
NOT_NEGATIVE = [NAN, INF, -INF, -1.0, -1, -1e-300]
FINITE = [NAN, INF, -INF]
NO_COUNT = ["17", None, True, 17.0, 17.5, NAN, -1, 2**40, 10**400, (17,)]
NO_VECTOR = [None, 1.0, "ab", (), (1.0,), (1.0, 2.0, 3.0), [[1.0, 2.0]], np.zeros(3)]
NO_TEXT = [None, 1, 1.5, True, ("a",), b"a", object]
NO_WORD = [1, True, "", "none", ("kept",), b"kept", NAN]


def allowed_count(value):
    large = isinstance(value, int) and value >= 2**32
    return "must be at most 4294967295" if large else "must be a whole number"


def positive(unit):
    return [
        *[(value, f"must be a positive number in {unit}") for value in POSITIVE],
        *[(value, f"must be a number in {unit}") for value in NO_NUMBER],
    ]


def optional_positive(unit):
    return [case for case in positive(unit) if case[0] is not None]


def not_negative(unit):
    return [
        *[(value, f"must be zero or a positive number in {unit}") for value in NOT_NEGATIVE],
        *[(value, f"must be a number in {unit}") for value in NO_NUMBER],
    ]


def within(low, high, *outside):
    return [
        *[(value, f"must be between {low} and {high}") for value in (*FINITE, *outside)],
        *[(value, "must be a number") for value in NO_NUMBER],
    ]


def count(low, high, *outside):
    return [
        *[(value, f"must be between {low} and {high}") for value in outside],
        *[(value, allowed_count(value)) for value in NO_COUNT],
    ]


def vector(unit):
    return [(value, f"must be two numbers (x, y) in {unit}") for value in NO_VECTOR]


def word(*allowed):
    text = " or ".join(f'"{each}"' if each else "None" for each in allowed)
    return [
        (value, f"must be {text}") for value in [*NO_WORD, *([] if None in allowed else [None])]
    ]


def instance(kind, *others):
    wrong = [1.0, "x", (), object, *others]
    article = "an" if kind[0] in "AEIOU" else "a"
    return [(value, f"must be {article} {kind}") for value in wrong]


def table(unit):
    return [
        *[(value, f"must be a finite number in {unit}") for value in FINITE],
        *[(value, f"must be a number in {unit}") for value in ("1", None, True, 1 + 2j, object)],
    ]


def shown(value):
    """The value as a message may show it: as the description holds it."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    return tuple(map(shown, value)) if isinstance(value, list | tuple) else value


def numbers(text):
    """The numbers in a text, so that "(0, NaN)" and "(0.0, nan)" are the same."""
    words = re.findall(r"[^\s(),]+", text)
    with contextlib.suppress(ValueError):
        return [repr(float(word)) for word in words]
    return words


def assert_refused(error, name, value, allowed):
    """The message reads ``name = value: what is allowed``."""
    message = str(error)
    said = re.fullmatch(r"(.+?) = (.*?): (.+)", message, flags=re.DOTALL)
    assert said, message
    assert said[1] == name
    assert allowed in said[3], message
    whole = repr(value)
    whole = whole if len(whole) <= 80 else f"{whole[:77]}..."
    assert said[2] == whole or numbers(said[2]) == numbers(whole), message
