"""A master for one FMU: FMPy's wrapper of either version, with the variables by name."""

from __future__ import annotations

from contextlib import contextmanager
from itertools import pairwise
from tempfile import TemporaryDirectory

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave


class Master:
    """An instance of an FMU."""

    def __init__(self, path, unpacked, token=None):
        description = fmpy.read_model_description(str(path))
        self.version = description.fmiVersion
        self.variables = {each.name: each for each in description.modelVariables}
        self.messages = []
        old = self.version == "2.0"
        self.slave = (FMU2Slave if old else FMU3Slave)(
            guid=token or (description.guid if old else description.instantiationToken),
            unzipDirectory=unpacked,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="drive",
        )
        if old:
            self.slave.instantiate(callbacks=self._callbacks())
        else:
            self.slave.instantiate(logMessage=lambda *message: self._keep(message[-1]))

    def _callbacks(self):
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda *message: self._keep(message[-1]))
        return callbacks

    def _keep(self, message):
        self.messages.append(message.decode())

    def initialize(self, start_time=0.0, stop_time=None):
        times = {"startTime": start_time, "stopTime": stop_time}
        if self.version == "2.0":
            self.slave.setupExperiment(**times)
            self.slave.enterInitializationMode()
        else:
            self.slave.enterInitializationMode(**times)
        self.slave.exitInitializationMode()
        return self

    def names(self, causality):
        return [each.name for each in self.variables.values() if each.causality == causality]

    def set(self, name, value):
        references = [self.variables[name].valueReference]
        setter = self.slave.setReal if self.version == "2.0" else self.slave.setFloat64
        setter(references, [value])

    def get(self, *names):
        references = [self.variables[name].valueReference for name in names]
        getter = self.slave.getReal if self.version == "2.0" else self.slave.getFloat64
        return np.array(getter(references))

    def outputs(self):
        return self.get(*self.names("output"))

    def step(self, time, size):
        self.slave.doStep(time, size)

    def steps(self, times):
        """Step along `times` and return the outputs at each but the first."""
        rows = []
        for begin, end in pairwise(times):
            self.step(begin, end - begin)
            rows.append(self.outputs())
        return np.array(rows)


@contextmanager
def opened(path, count=1, **keywords):
    """Give `count` instances of one FMU in this process."""
    with TemporaryDirectory(prefix="fmu é ") as unpacked:
        fmpy.extract(str(path), unzipdir=unpacked)
        masters = [Master(path, unpacked, **keywords) for _ in range(count)]
        try:
            yield masters[0] if count == 1 else masters
        finally:
            for master in masters:  # not with freeInstance, which also unloads the library
                free = getattr(master.slave, f"fmi{master.version[0]}FreeInstance")
                free(master.slave.component)
