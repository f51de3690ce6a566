"""Programs that turn samples into a density: histograms, triangulation, interpolation."""
import fast_histogram
import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay

from compare import median

BINS = 100
RESOLUTION = 5000


def rows(folder, ours, repeats, quick):
    phi, e, n = np.fromfile(folder / "cloud.f64").reshape(3, -1)
    phi_low, phi_high, e_low, e_high = np.fromfile(folder / "grid.f64")
    span = [[phi_low, phi_high], [e_low, e_high]]

    def row(stage):
        return "ours", stage, None, ours[stage, "", 1], ours[stage, "", 2]

    yield row("bin")
    yield "fast-histogram", "bin", None, median(lambda: fast_histogram.histogram2d(phi, e, BINS, span), 20 * repeats), None
    yield "numpy.histogram2d", "bin", None, median(lambda: np.histogram2d(phi, e, BINS, span), 4 * repeats), None
    yield row("triangulate")
    points = np.column_stack([phi, e])
    yield "SciPy Delaunay", "triangulate", None, median(lambda: Delaunay(points), repeats), None
    yield row("interpolate")
    if quick:
        return
    bins = np.fromfile(folder / "ours-bins.f64").reshape(BINS, BINS)
    interpolator = LinearNDInterpolator(Delaunay(points), n, fill_value=0.0)
    found = []
    seconds = median(lambda: found.append(interpolate(interpolator, span)), 1)
    error = np.abs(found[0] - bins).max() / bins.max()
    yield "SciPy LinearND (error: ours against it, of the peak)", "interpolate", error, seconds, None


def interpolate(interpolator, span):
    """Means of the values at RESOLUTION x RESOLUTION cell centres in each bin, one row of bins at a time."""
    (phi_low, phi_high), (e_low, e_high) = span
    centres = (np.arange(RESOLUTION) + 0.5) / RESOLUTION
    phi, e = phi_low + centres * (phi_high - phi_low), e_low + centres * (e_high - e_low)
    per_bin = RESOLUTION // BINS
    means = []
    for lines in phi.reshape(BINS, per_bin):
        values = interpolator(*np.meshgrid(lines, e, indexing="ij"))
        means.append(values.reshape(per_bin, BINS, per_bin).mean((0, 2)))
    return np.array(means)
