"""What the Tab key offers: robots, files, links and joints of the robot already typed, and words. Never an error."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from ..model import RobotModel

_MOST = 200
_SPECIAL = set(" \t\n'\"\\$&();<>|*?[]{}`!#")  # a shell would want these quoted; its own completion of files knows how


def robots(incomplete: str) -> list[str]:
    """Catalogue names and robot files; nothing where only folders fit, so that the shell completes them as it does."""
    from ..robots.catalogue import catalogue_names

    named = [name for name in catalogue_names() if name.startswith(incomplete)]
    files, folders = _robot_files(incomplete)
    return [*named, *files, *(folders if named or files else [])]


def links(ctx: typer.Context, incomplete: str) -> list[str]:
    """Links of the robot on the line, where it can be read in no time."""
    return _starting(incomplete, _model_names(ctx, lambda model: model.link_names))


def links_or_ends(ctx: typer.Context, incomplete: str) -> list[str]:
    """Links, and the words base and tip."""
    return [*_starting(incomplete, ("base", "tip")), *links(ctx, incomplete)]


def link_values(ctx: typer.Context, incomplete: str) -> list[str]:
    """Links with an equals sign, for options such as --load link=fx,fy,fz."""
    return [f"{link}=" for link in links(ctx, incomplete)]


def joint_values(ctx: typer.Context, incomplete: str) -> list[str]:
    """Joints with an equals sign, for --hold joint=value."""
    return [f"{joint}=" for joint in _starting(incomplete, _model_names(ctx, lambda model: model.joint_names))]


def words(*known: str) -> Callable[[str], list[str]]:
    """One of these words."""

    def offered(incomplete: str) -> list[str]:
        return _starting(incomplete, known)

    return offered


def conventions(incomplete: str) -> list[str]:
    """Names of conventions of other libraries."""
    from ..conventions import CONVENTIONS

    return _starting(incomplete, sorted(CONVENTIONS))


def _starting(incomplete: str, known: Sequence[str]) -> list[str]:
    return [word for word in known if word.startswith(incomplete)][:_MOST]


def _robot_files(incomplete: str) -> tuple[list[str], list[str]]:
    """Robot files and folders whose path begins so; none that would have to be quoted."""
    from ..robots.loading import SUFFIXES

    folder, start = os.path.split(incomplete)
    files, folders = [], []
    try:
        with os.scandir(os.path.expanduser(folder) or ".") as entries:
            for entry in entries:
                name = entry.name
                if not name.startswith(start) or (name.startswith(".") and not start) or _SPECIAL & set(name):
                    continue
                if entry.is_dir():
                    folders.append(os.path.join(folder, name, ""))
                elif name.lower().endswith(SUFFIXES):
                    files.append(os.path.join(folder, name))
    except (OSError, ValueError):
        return [], []
    return sorted(files)[:_MOST], sorted(folders)[:_MOST]


def _model_names(ctx: typer.Context, of: Callable[[RobotModel], Sequence[str]]) -> Sequence[str]:
    """Names in the robot on the line; none of a MuJoCo model or a xacro file, which take a child process to read."""
    import warnings
    from pathlib import Path

    from ..errors import KinestaticsError
    from ..robots.loading import file_format, load

    robot = ctx.params.get("robot") or next(iter(ctx.args), None)  # left in args where the last option has no value yet
    if not isinstance(robot, str):
        return ()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if os.path.isfile(robot) and file_format(Path(robot)) != "urdf":
                return ()
            return [name for name in of(load(robot, whole_tree=True)) if not _SPECIAL & set(name)]
    except (KinestaticsError, OSError, ValueError):
        return ()
