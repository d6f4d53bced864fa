"""Jobs of tests/stress that processes of their own import by the name of this module."""

from scenes import Trial

BRIEF = 1e-3  # [s]


class Given:
    """A job of one scene."""

    name = kind = "given"

    def __init__(self, scene, duration=BRIEF, restart=False):
        self.given = Trial(scene, duration, restart)

    def trial(self):
        return self.given


class Hanging(Given):
    """A job that obeys no interrupt."""

    def trial(self):
        while True:
            try:
                sum(range(10**9))
            except KeyboardInterrupt:
                continue
