"""A scene in one file that needs no server: for reports, notebooks and colleagues."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..analysis import Analysis, analyze
from ..dexterity import Polytope, force_polytope, velocity_polytope
from ..errors import missing_extra
from ..model import RobotModel
from ..skeleton import one_configuration
from ..spatial import LINEAR_ROWS
from .solids import solids_of

if TYPE_CHECKING:
    from .arm_scene import View


def scene_html(model: RobotModel, q: Any = None, analysis: Analysis | None = None, view: View | None = None) -> str:
    """The arm and its signs as a page of its own, with a camera that can be moved.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        analysis: what is shown; default the analysis of this posture.
        view: a `View`; default the velocity ellipsoid, and what is lost and held for free.

    Returns:
        A whole HTML document (about 1 MB). It asks for nothing from the network; the same input makes the same bytes.

    Raises:
        MissingExtraError: KS400 without the extra `view`. ArrayTypeError, ConfigurationError: as in `analyze`, and where the
        view has a polytope as in `velocity_polytope` and `force_polytope`.

    Example:
        >>> import kinestatics as ks
        >>> scene_html(ks.load("planar_2r"), [0.3, 0.0]).startswith("<!doctype html>")
        True
    """
    try:
        import viser  # noqa: F401
    except ImportError:
        raise missing_extra("viser", "view", "a scene") from None
    from .arm_scene import ArmScene, fitting_view
    from .guard import guarded_server

    values = one_configuration(model, q)
    shown = analyze(model, values, brief=True) if analysis is None else analysis
    with guarded_server() as guarded:  # viser builds scenes on a server only; nobody knows the address of this one
        scene = ArmScene(guarded.server, model, solids_of(model))
        chosen = fitting_view(shown, scene.size) if view is None else view
        scene.update(shown, chosen, _polytopes(model, shown, chosen))
        return str(guarded.server.get_scene_serializer().as_html())


def _polytopes(model: RobotModel, a: Analysis, view: View) -> tuple[Polytope | None, Polytope | None]:
    """Those of the linear rows in play that the view asks for."""
    rows = [row for row in a.task.rows if row in LINEAR_ROWS]
    velocity = force = None
    if rows and view.velocity == "polytope":
        velocity = velocity_polytope(model, a.configuration, task=rows, at=a.tip)
    if rows and view.force == "polytope":
        force = force_polytope(model, a.configuration, task=rows, at=a.tip, gravity=tuple(a.gravity))
    return velocity, force
