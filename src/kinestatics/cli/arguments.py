"""Arguments that several commands share, and how their text becomes numbers."""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConfigurationError, KinestaticsError, UnknownNameError, nearest
from ..frames import TIP
from .completion import joint_values, link_values, links, links_or_ends, robots, words

if TYPE_CHECKING:
    from ..model import RobotModel
    from ..namespaces import Array
    from ..quantities import Wrench

_SIX = "fx,fy,fz or fx,fy,fz,mx,my,mz [N, N m] in base axes"

Robot = Annotated[
    str,
    typer.Argument(
        help="A catalogue name (see `kinestatics robots`) or a .urdf, .xml (MJCF), .xacro file.", autocompletion=robots
    ),
]
Base = Annotated[str | None, typer.Option(help="Link to start from; default the root.", autocompletion=links)]
Tip = Annotated[
    str | None,
    typer.Option(help="Link whose motion is asked for; default the only end of a branch.", autocompletion=links),
]
Link = Annotated[str, typer.Option(help="Link that is meant: tip or any link.", autocompletion=links_or_ends)]
At = Annotated[
    str,
    typer.Option(
        help="Configuration: numbers such as 0,-pi/2,30deg (radians, metres), or home, zero, random.",
        autocompletion=words("home", "zero", "random"),
    ),
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of --at random.")]
Task = Annotated[
    str,
    typer.Option(
        help="auto, full, position, orientation, or rows such as vx,vy,wz.",
        autocompletion=words("auto", "full", "position", "orientation"),
    ),
]
Loads = Annotated[
    list[str] | None,
    typer.Option(help=f"Load on the robot: {_SIX}; or link=... May be repeated.", autocompletion=link_values),
]
Pushes = Annotated[
    list[str] | None,
    typer.Option(help="What the robot exerts on its surroundings; as --load. May be repeated.", autocompletion=link_values),
]
WrenchAt = Annotated[
    str,
    typer.Option(help="Link at whose origin loads and pushes act, where they name none.", autocompletion=links_or_ends),
]
Payloads = Annotated[
    list[str] | None,
    typer.Option(
        help="What the tip holds: mass or mass,x,y,z of its centre [kg, m]; or link=... May be repeated.",
        autocompletion=link_values,
    ),
]
Mount = Annotated[
    str,
    typer.Option(
        help="How the base stands: floor, ceiling, wall, or roll,pitch,yaw.",
        autocompletion=words("floor", "ceiling", "wall"),
    ),
]
Hold = Annotated[
    list[str] | None,
    typer.Option(help="Hold a joint off the path: name=value. May be repeated.", autocompletion=joint_values),
]
Roots = Annotated[list[Path] | None, typer.Option("--package-root", help="Folder for package:// paths. May be repeated.")]
AllowXacro = Annotated[
    bool, typer.Option("--allow-xacro", help="Expand a xacro file. It can run code: only files you trust.")
]
Json = Annotated[bool, typer.Option("--json", help="Machine-readable output.")]

_THREE = 3
_OPERATIONS: dict[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def number(text: str) -> float:
    """A number, with pi, + - * / and a trailing "deg"; nothing else is understood, and nothing is executed.

    Raises:
        ConfigurationError: KS340.

    Example:
        >>> number("-pi/2") == -math.pi / 2, number("30deg") == math.radians(30)
        (True, True)
    """
    stripped = text.strip()
    degrees = stripped.endswith("deg")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python warns of text such as "1or2" before it refuses it
            value = _value(ast.parse(stripped.removesuffix("deg").strip(), mode="eval").body, depth=0)
    except (SyntaxError, ValueError, ZeroDivisionError, RecursionError, MemoryError, OverflowError):
        raise ConfigurationError("KS340", f"{text!r} is not a number", "write 0.5, -pi/2 or 30deg") from None
    if not math.isfinite(value):
        raise ConfigurationError("KS340", f"{text!r} is not finite", "write 0.5, -pi/2 or 30deg")
    return math.radians(value) if degrees else value


def _value(node: ast.AST, depth: int) -> float:
    if depth > 20:
        raise ValueError
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        return float(node.value)
    if isinstance(node, ast.Name) and node.id == "pi":
        return math.pi
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        return _OPERATIONS[type(node.op)](_value(node.left, depth + 1), _value(node.right, depth + 1))
    if isinstance(node, ast.UnaryOp) and type(node.op) in _OPERATIONS:
        return _OPERATIONS[type(node.op)](_value(node.operand, depth + 1))
    raise ValueError


def numbers(text: str) -> list[float]:
    """Numbers separated by commas, or by spaces where there is no comma."""
    return [number(part) for part in (text.split(",") if "," in text else text.split())]


def numbers_of(option: str, text: str) -> list[float]:
    """`numbers`, with the name of the option in the error."""
    try:
        return numbers(text)
    except ConfigurationError as error:
        raise ConfigurationError(error.code, f"{option}: {error.message}", error.hint) from None


def read_robot(
    robot: str, base: str | None, tip: str | None, hold: list[str] | None, roots: list[Path] | None, allow_xacro: bool
) -> RobotModel:
    """The model of the shared options."""
    from ..robots.loading import load

    joints: dict[str, float] = {}
    for entry in hold or []:
        name, separator, value = entry.rpartition("=")
        if not (separator and name):
            raise ConfigurationError("KS341", f"--hold {entry!r} is not name=value", "for example --hold finger_joint1=0.04")
        values = numbers_of("--hold", value)
        if len(values) != 1:
            raise ConfigurationError("KS341", f"--hold {entry!r} gives {len(values)} values for one joint", "name=value")
        joints[name] = values[0]
    return load(robot, base, tip, joints, package_roots=roots or (), allow_xacro=allow_xacro)


def read_configuration(model: RobotModel, at: str, seed: int) -> Array:
    """home, zero, random, or n numbers."""
    import numpy as np

    words: dict[str, Callable[[], Any]] = {
        "home": lambda: model.home,
        "zero": lambda: np.zeros(model.n),
        "random": lambda: model.random_configurations(1, seed)[0],
    }
    if at in words:
        return np.array(words[at]())
    try:
        values = numbers_of("--at", at)
    except KinestaticsError as error:
        if at.isalpha():
            raise UnknownNameError("KS342", f"--at {at!r} is not known", nearest(at, words)) from None
        raise error
    if len(values) != model.n:
        hint = f"one for each of {', '.join(model.joint_names)}, or home, zero, random"
        raise ConfigurationError("KS345", f"--at has {len(values)} numbers; {model.name!r} has {model.n} joints", hint)
    return np.array(values, dtype=np.float64)


def read_loads(loads: list[str] | None, pushes: list[str] | None, at: str) -> list[tuple[str, Wrench]]:
    """Every --load (acts on the robot) and --push (the robot acts on its surroundings) with the link it acts at.

    Each is 3 or 6 numbers, or link=numbers; `at` is the link of those that name none.
    """
    from ..quantities import Wrench

    found = []
    for texts, word, make in ((loads, "--load", Wrench.on_robot), (pushes, "--push", Wrench.on_environment)):
        for text in texts or []:
            link, named, values = text.rpartition("=")
            six = numbers_of(word, values)
            if len(six) not in (3, 6) or (named and not link):
                hint = "fx,fy,fz or fx,fy,fz,mx,my,mz [N, N m], or link=fx,fy,fz"
                raise ConfigurationError("KS344", f"{word} has {len(six)} numbers", hint)
            found.append((link or at, make(force=six[:_THREE], torque=six[_THREE:] or (0.0, 0.0, 0.0))))
    return found


def with_payloads(model: RobotModel, payloads: list[str] | None) -> RobotModel:
    """The model carrying every --payload: mass, or mass,x,y,z of its centre in axes of the tip; link=... elsewhere."""
    for k, text in enumerate(payloads or []):
        link, named, values = text.rpartition("=")
        found = numbers_of("--payload", values)
        if len(found) not in (1, 4) or (named and not link):
            hint = "mass or mass,x,y,z [kg, m], or link=mass,x,y,z"
            raise ConfigurationError("KS347", f"--payload has {len(found)} numbers", hint)
        center = found[1:] or (0.0, 0.0, 0.0)
        model = model.with_payload(found[0], center, at=link or TIP, name=f"payload{k + 1}")
    return model


def read_mounting(text: str) -> Array:
    """--mount as gravity in base axes [m/s²]: floor, ceiling, wall, or roll,pitch,yaw of the base."""
    from ..statics import gravity_in_base

    if text.replace("_", "").isalpha():
        return gravity_in_base(text)
    angles = numbers_of("--mount", text)
    if len(angles) != _THREE:
        raise ConfigurationError("KS348", f"--mount has {len(angles)} numbers", "floor, ceiling, wall, or r,p,y")
    return gravity_in_base(angles)
