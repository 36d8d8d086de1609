"""`explore`, and what it returns."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import missing_extra
from ..kinematics import require_model
from ..model import RobotModel
from ..namespaces import Array
from ..quantities import Wrench
from ..skeleton import one_configuration
from ..spatial import ANGULAR, LINEAR
from .page import Page
from .session import LOAD, PUSH, Session, Situation


class Explorer:
    """A running page; made by `explore`. As a context manager it stops at the end.

    Attributes:
        address: the one address that opens it; whoever knows it can.
        session: what the page is about; `session.change(q=...)` moves the arm for everyone who looks.
        page: what is on it.

    Example:
        >>> import kinestatics as ks
        >>> with ks.explore(ks.load("planar_2r")) as explorer:
        ...     explorer.session.change(q=[0.3, 0.0])
        ...     explorer.address.startswith("http://127.0.0.1:"), explorer.session.analysis.rank
        (True, 1)
    """

    def __init__(self, guarded: Any, session: Session, page: Page) -> None:
        self._guarded, self.session, self.page = guarded, session, page
        self.address: str = guarded.address
        self._over = threading.Event()

    def open_in_browser(self) -> bool:
        """Opens the page in this user's browser; False where there is none."""
        return bool(self._guarded.open_in_browser())

    def wait(self) -> None:
        """Until `stop` is called, or Ctrl-C."""
        self._over.wait()

    def stop(self) -> None:
        """Closes the page; more than once does no harm."""
        self.page.close()
        self._guarded.stop()
        self._over.set()

    def __enter__(self) -> Explorer:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def explore(
    model: RobotModel,
    q: Any = None,
    *,
    wrench: Wrench | None = None,
    gravity: Sequence[float] | str = "floor",
    host: str = "127.0.0.1",
    port: int = 0,
    also_known_as: Sequence[str] = (),
    token: str | None = None,
    package_roots: Sequence[Path | str] = (),
    seed: int = 0,
) -> Explorer:
    """Opens a page on which an arm is moved by sliders and by pulling at its tool, with everything `analyze` says of it.

    The page is served to this machine alone, and only to those who have its address; see `kinestatics.scene.guard`.

    Args:
        model: the robot, with a tip.
        q: (n) the first configuration [rad or m]; default the robot's home.
        wrench: at the tip, in base axes: what the page begins with.
        gravity: how the base stands ("floor", "wall", "ceiling"), or (3) gravity in base axes [m/s²].
        host, port, also_known_as, token: as in `kinestatics.scene.guard.guarded_server`.
        package_roots: folders in which meshes named package://... are looked for.
        seed: of the random postures.

    Returns:
        Explorer: `.address` opens it, `.stop()` ends it.

    Raises:
        MissingExtraError: KS400 without the extra `view`. ConfigurationError: KS303 for q; KS430, KS432, KS433 as there.

    Example:
        >>> import kinestatics as ks
        >>> with ks.explore(ks.load("planar_2r"), [0.3, 0.0]) as page:
        ...     page.session.analysis.is_singular
        True
    """
    require_model(model)
    try:
        import viser  # noqa: F401
    except ImportError:
        raise missing_extra("viser", "view", "a page in the browser") from None
    from ..scene.guard import guarded_server
    from ..scene.solids import solids_of

    values = one_configuration(model, q)
    session = Session(model, _situation(values, wrench, gravity))
    guarded = guarded_server(host=host, port=port, also_known_as=also_known_as, token=token)
    try:
        page = Page(guarded.server, session, solids_of(model, package_roots), seed)
    except BaseException:
        guarded.stop()
        raise
    return Explorer(guarded, session, page)


def _situation(q: Array, wrench: Wrench | None, gravity: Sequence[float] | str) -> Situation:
    mount = gravity if isinstance(gravity, str) else _three(gravity)
    if wrench is None:
        return Situation(q, mount=mount)
    acts = PUSH if wrench.acts_on == "environment" else LOAD
    return Situation(q, _three(wrench.array[LINEAR]), _three(wrench.array[ANGULAR]), acts, mount=mount)


def _three(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
