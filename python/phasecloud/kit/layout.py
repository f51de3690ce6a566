"""The headers of phasecloud's messages, byte for byte as in messages/src/layout.rs, which says what each field means.

A test (messages/tests/python_layout.rs) compares this file with the Rust one. iceoryx2 compares type names and sizes when a topic
is opened, but not fields: a change of a header there must be made here, too.

The classes stand in a module of their own because iceoryx2 0.10 leaves its files behind at exit if its ports are globals of
the module that defines their header's class.
"""

import ctypes
from ctypes import c_double, c_uint8, c_uint32, c_uint64

Label = c_uint8 * 32
"""NUL-padded UTF-8."""

# What a snapshot's columns are, and how many there are of them.
SAMPLES = 1  # phi [rad], e of equally weighted samples
CHARACTERISTICS = 2  # phi [rad], e, density n [1/rad] carried along
MIXTURE = 3  # weight, mean phi [rad], mean e, variance of phi [rad^2], covariance [rad], variance of e
COLUMNS = {SAMPLES: 2, CHARACTERISTICS: 3, MIXTURE: 6}
DETAIL_WORDS = 8  # 64-bit words at the end of a snapshot's header for the fields that only its kind has

# How the estimator makes a density of characteristics.
CARRIED_MESH, HULL_MESH = 0, 1

# The events that a node reports.
READY, PROGRESS, DONE, FAILED = 1, 2, 3, 4
CASE, SHARD = 0, 1

# Time [yr], probability, lower and upper end of its interval (NaN without one). Probabilities do not
# fall; one that is NaN between two ends is withheld.
PASSAGE_COLUMNS = 4
PASSAGE_TIMES = 65

# Events on a topic: a publisher has sent, a reader has joined.
SENT, JOINED = 1, 2


# Which values a variable takes.
CIRCLE, INTERVAL = 1, 2  # an angle [rad] without a beginning; numbers between two bounds


class VariableEntry(ctypes.Structure):
    """A variable in which orbits are given and read out."""

    _fields_ = [
        ("low", c_double),
        ("high", c_double),
        ("range", c_uint32),
        ("reserved", c_uint32),
        ("name", Label),
        ("symbol", c_uint8 * 16),
        ("unit", c_uint8 * 16),
    ]

    @staticmethod
    def type_name():
        return "phasecloud/ScenarioHeader/2/Variable"


class ParameterEntry(ctypes.Structure):
    """A parameter of the model."""

    _fields_ = [("value", c_double), ("name", Label), ("symbol", c_uint8 * 16)]

    @staticmethod
    def type_name():
        return "phasecloud/ScenarioHeader/2/Parameter"


class ProjectionEntry(ctypes.Structure):
    """One variable or two, in which densities are compared."""

    _fields_ = [
        ("dimensions", c_uint32),
        ("first", c_uint32),
        ("second", c_uint32),
        ("first_bins", c_uint32),
        ("second_bins", c_uint32),
        ("reserved", c_uint32),
    ]

    @staticmethod
    def type_name():
        return "phasecloud/ScenarioHeader/2/Projection"


class ScenarioHeader(ctypes.Structure):
    """The problem. Payload: mean and upper triangle of the covariance of the initial Gaussian, then one row per snapshot: time [yr], and
    the lowest and highest value of every axis of every projection."""

    _fields_ = [
        ("run_id", c_uint64),
        ("critical", c_double),
        ("scenario", c_uint32),
        ("scenarios", c_uint32),
        ("snapshots", c_uint32),
        ("reentry", c_uint32),
        ("variable_count", c_uint32),
        ("parameter_count", c_uint32),
        ("projection_count", c_uint32),
        ("reserved", c_uint32),
        ("name", Label),
        ("model", Label),
        ("variables", VariableEntry * 8),
        ("parameters", ParameterEntry * 16),
        ("projections", ProjectionEntry * 16),
    ]

    @staticmethod
    def type_name():
        return "phasecloud/ScenarioHeader/2"


class SamplesDetails(ctypes.Structure):
    """The fields of samples beyond those that all snapshots share."""

    _fields_ = [("replicates", c_uint32), ("reserved", c_uint32)]

    @staticmethod
    def type_name():
        return "phasecloud/SnapshotHeader/5/Samples"


class CharacteristicsDetails(ctypes.Structure):
    """The fields of characteristics beyond those that all snapshots share."""

    _fields_ = [("treatment", c_uint32), ("resolution", c_uint32), ("lattice", c_uint32), ("degree", c_uint32)]

    @staticmethod
    def type_name():
        return "phasecloud/SnapshotHeader/5/Characteristics"


class MixtureDetails(ctypes.Structure):
    """The fields of a mixture beyond those that all snapshots share."""

    _fields_ = [("disagreement", c_double)]

    def __init__(self, disagreement=float("nan")):
        super().__init__(disagreement)  # NaN: not known

    @staticmethod
    def type_name():
        return "phasecloud/SnapshotHeader/5/Mixture"


DETAILS = {SAMPLES: SamplesDetails, CHARACTERISTICS: CharacteristicsDetails, MIXTURE: MixtureDetails}


def details(kind, fields):
    """The words at the end of a snapshot's header: the fields that its kind has, then zeros."""
    structure = DETAILS[kind]
    known = [name for name, _ in structure._fields_ if name != "reserved"]
    if unknown := set(fields) - set(known):
        raise TypeError(f"{', '.join(sorted(unknown))}: unknown for this kind of snapshot; it has {', '.join(known)}")
    area = (c_uint64 * DETAIL_WORDS)()
    said = structure(**fields)
    ctypes.memmove(area, ctypes.addressof(said), ctypes.sizeof(said))
    return area


class SnapshotHeader(ctypes.Structure):
    """What a propagator computed at one time. Payload: the columns of its kind, one after the other."""

    _fields_ = [
        ("run_id", c_uint64),
        ("time", c_double),
        ("seconds", c_double),
        ("total", c_uint64),
        ("trajectories", c_uint64),
        ("trajectory_error", c_double),
        ("scenario", c_uint32),
        ("index", c_uint32),
        ("count", c_uint32),
        ("kind", c_uint32),
        ("rows", c_uint32),
        ("columns", c_uint32),
        ("attempt", c_uint32),
        ("shard", c_uint32),
        ("shards", c_uint32),
        ("most_rows", c_uint32),
        ("label", Label),
        ("details", c_uint64 * DETAIL_WORDS),
    ]

    @staticmethod
    def type_name():
        return "phasecloud/SnapshotHeader/5"


class PassageHeader(ctypes.Structure):
    """First passages. Payload: PASSAGE_COLUMNS numbers per time, or none and a reason; `given` is 0 from this kit."""

    _fields_ = [
        ("run_id", c_uint64),
        ("seconds", c_double),
        ("samples", c_uint64),
        ("scenario", c_uint32),
        ("rows", c_uint32),
        ("shard", c_uint32),
        ("shards", c_uint32),
        ("dependent", c_uint32),
        ("given", c_uint32),
        ("label", Label),
        ("reason", c_uint8 * 192),
    ]

    @staticmethod
    def type_name():
        return "phasecloud/PassageHeader/4"


class StatusHeader(ctypes.Structure):
    """A report to the launcher. Payload: units of work done, units in total."""

    _fields_ = [
        ("run_id", c_uint64),
        ("event", c_uint32),
        ("scenario", c_uint32),
        ("role", c_uint32),
        ("shard", c_uint32),
        ("subject_role", c_uint32),
        ("subject_shard", c_uint32),
        ("node", Label),
        ("subject", Label),
        ("text", c_uint8 * 1024),
    ]

    @staticmethod
    def type_name():
        return "phasecloud/StatusHeader/4"
