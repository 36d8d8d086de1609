"""`show`: the arm in three dimensions, as a page of its own in a frame that can reach nothing else."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis import analyze
from ..errors import ArrayTypeError, ConfigurationError
from ..kinematics import require_model
from ..model import RobotModel
from ..report.blocks import Html, tag
from ..skeleton import one_configuration
from ..statics import Loads
from .frame import framed

if TYPE_CHECKING:
    from ..scene.arm_scene import View

_HEIGHTS = (120, 4000)


@dataclass(frozen=True, repr=False)
class Shown:
    """An arm in three dimensions: a notebook displays it; elsewhere, save it and open the file in a browser.

    Attributes:
        robot: its name.
        html: the whole page, which asks for nothing from the network and for no server or kernel.
        height: of the frame in a notebook [pixels].

    Example:
        >>> import kinestatics as ks
        >>> ks.show(ks.load("planar_2r"), [0.3, 0.6])
        <planar_2r in three dimensions: a notebook displays it; else .save("arm.html"), and open that file in a browser>
    """

    robot: str
    html: str = field(hash=False)
    height: int = 480

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the page into a file, which any browser opens; what the file held is replaced.

        Returns:
            The path of the file.

        Raises:
            ConfigurationError: KS452 where it cannot be written.
        """
        try:
            file = Path(path)
            file.write_text(self.html, encoding="utf-8", newline="\n")
        except (OSError, TypeError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            hint = 'name a file in a folder that exists, as in .save("arm.html")'
            raise ConfigurationError("KS452", f"the scene cannot be written to {path!r}: {reason}", hint) from None
        return file

    def _repr_html_(self) -> str:
        inner = Html(escape(self.html))
        look = f"width:100%;height:{self.height}px;border:1px solid rgba(128,128,128,.35);border-radius:6px;background:#fff"
        words = f"{self.robot} in three dimensions"
        frame = tag(
            "iframe",
            srcdoc=inner,
            sandbox="allow-scripts",
            title=words,
            style=look,
            loading="lazy",
            referrerpolicy="no-referrer",
        )
        return framed(frame, f"{words}: to be seen where notebooks are trusted, and in the file that .save(path) writes")

    def __repr__(self) -> str:
        how = 'a notebook displays it; else .save("arm.html"), and open that file in a browser'
        return f"<{self.robot} in three dimensions: {how}>"


def show(model: RobotModel, q: Any = None, *, wrench: Loads = None, height: int = 480, view: View | None = None) -> Shown:
    """An arm in three dimensions, to be turned with the mouse: in a notebook as the last line of a cell.

    It is drawn once, at one posture, and needs no running kernel: a notebook that was saved still shows it. For an arm that
    moves there is `kinestatics explore`.

    Args:
        model: the robot.
        q: (n) one configuration [rad or m]; default the robot's home.
        wrench: loads on the robot or pushes on its surroundings, as in `analyze`; drawn as arrows.
        height: of the frame in a notebook [pixels].
        view: a `kinestatics.scene.arm_scene.View`: which ellipsoids, polytopes and signs are seen, at what scale; default
            the ellipsoid of velocity, lost motions and free wrenches.

    Returns:
        Shown: with the whole page as `html`, and `save`.

    Raises:
        MissingExtraError: KS400 without the extra `view`.
        ConfigurationError: KS450 for a height that is none; KS303, KS301 for q and wrench.
        ArrayTypeError: KS451 for a view that is none; KS302 for what is no robot.

    Example:
        >>> import kinestatics as ks
        >>> shown = ks.show(ks.load("planar_2r"), [0.3, 0.6], wrench=ks.Wrench.on_robot(force=(0, -10, 0)))
        >>> shown.html.startswith("<!doctype html>"), len(shown.html) < 3e6
        (True, True)
    """
    from ..scene.arm_scene import View
    from ..scene.export import scene_html

    require_model(model)
    if isinstance(height, bool) or not isinstance(height, int) or not _HEIGHTS[0] <= height <= _HEIGHTS[1]:
        raise ConfigurationError(
            "KS450", f"height is {height!r}", f"a whole number of pixels, {_HEIGHTS[0]} to {_HEIGHTS[1]}"
        )
    if view is not None and not isinstance(view, View):
        hint = 'from kinestatics.scene.arm_scene import View; view=View(velocity="polytope")'
        raise ArrayTypeError("KS451", f"view is a {type(view).__name__}; expected a View", hint)
    values = one_configuration(model, q)
    return Shown(model.name, scene_html(model, values, analyze(model, values, wrench, brief=True), view), height)
