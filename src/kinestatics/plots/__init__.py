"""Pictures: arms, ellipsoids, polytopes, lost directions, loads, torques, measures, workspaces; ready for a paper. Floor 10.

They render what the floors below computed; nothing is computed here but where on the paper it goes. Each function is one
call and returns matplotlib axes. matplotlib is imported when the first picture is drawn.
"""

from .arm import arm
from .ellipsoids import force_ellipsoid, velocity_ellipsoid
from .page import analysis
from .paths import measure_along
from .polytopes import force_polytope, velocity_polytope
from .screws import lost_and_free
from .singular import aspect_regions, singular_curves, singular_image
from .singular_distances import singular_distances
from .torques import load, torque_bars
from .workspace import workspace_section

__all__ = [
    "analysis",
    "arm",
    "aspect_regions",
    "force_ellipsoid",
    "force_polytope",
    "load",
    "lost_and_free",
    "measure_along",
    "singular_curves",
    "singular_distances",
    "singular_image",
    "torque_bars",
    "velocity_ellipsoid",
    "velocity_polytope",
    "workspace_section",
]
