#!/usr/bin/env python3
"""Where drag, which no model of phasecloud has, would matter: beside radiation pressure, and for an eccentric orbit.

    python3 benches/drag.py

Prints, for heights from 300 to 1,000 km,
- the density of an exponential atmosphere (Vallado, Fundamentals of Astrodynamics and Applications, 4th ed. 2013, Table 8-4);
- the acceleration by drag on a circular orbit over that by radiation pressure: rho v^2 c_D / (2 P c_R), which does not depend on
  the area-to-mass ratio;
- by how much drag shrinks the orbit of scenario 1 (a = 2.5 Earth radii) in a day for each m^2/kg, while its pericentre is that high,
  from the change of the semi-major axis in one revolution (King-Hele, Satellite Orbits in an Atmosphere, 1987, Ch. 4):
  da = -c_D (A/m) a^2 rho_p integral over E of (1 + e cos E)^(3/2) (1 - e cos E)^(-1/2) exp(-(a e / H) (1 - cos E)).
"""
import math

MU = 3.986004418e14  # m^3/s^2
RADIUS = 6378.137e3  # m
PRESSURE = 4.56e-6  # N/m^2, at 1 au
DRAG, REFLECTION = 2.2, 1.3  # c_D, c_R
AXIS = 2.5 * RADIUS
# Height, km; density there, kg/m^3; scale height, km.
ATMOSPHERE = [
    (300, 2.418e-11, 53.628),
    (400, 3.725e-12, 58.515),
    (500, 6.967e-13, 63.822),
    (600, 1.454e-13, 71.835),
    (700, 3.614e-14, 88.667),
    (800, 1.170e-14, 124.64),
    (1000, 3.019e-15, 268.00),
]


def beside_pressure(height, density):
    """Drag on a circular orbit over radiation pressure."""
    return density * MU / (RADIUS + height) * DRAG / (2 * PRESSURE * REFLECTION)


def shrinking(height, density, scale):
    """Fall of the semi-major axis in a day for each m^2/kg [m]."""
    e = 1 - (RADIUS + height) / AXIS

    def integrand(anomaly):
        cos = math.cos(anomaly)
        return (1 + e * cos) ** 1.5 * (1 - e * cos) ** -0.5 * math.exp(-AXIS * e / scale * (1 - cos))

    # The trapezoidal rule converges exponentially for a periodic function.
    count = 4000
    integral = sum(integrand(2 * math.pi * k / count) for k in range(count)) * 2 * math.pi / count
    per_revolution = DRAG * AXIS**2 * density * integral
    return per_revolution * 86400 / (2 * math.pi * math.sqrt(AXIS**3 / MU))


print("height, km  density, kg/m^3  drag / pressure  da of scenario 1, km/day for each m^2/kg")
for kilometres, density, scale in ATMOSPHERE:
    height = 1e3 * kilometres
    print(
        f"{kilometres:10}  {density:15.2e}  {beside_pressure(height, density):15.2g}"
        f"  {shrinking(height, density, 1e3 * scale) / 1e3:.2g}"
    )
