"""Pictures: arms, ellipsoids, polytopes, lost directions, loads, torques, measures; ready for a paper. Floor 10.

They render what the floors below computed; nothing is computed here but where on the paper it goes. Each function is one
call and returns matplotlib axes. matplotlib is imported when the first picture is drawn.
"""

from .arm import arm
from .ellipsoids import force_ellipsoid, velocity_ellipsoid
from .page import analysis
from .paths import measure_along
from .polytopes import force_polytope, velocity_polytope
from .screws import lost_and_free
from .singular import singular_curves, singular_image
from .torques import load, torque_bars

__all__ = [
    "analysis",
    "arm",
    "force_ellipsoid",
    "force_polytope",
    "load",
    "lost_and_free",
    "measure_along",
    "singular_curves",
    "singular_image",
    "torque_bars",
    "velocity_ellipsoid",
    "velocity_polytope",
]
