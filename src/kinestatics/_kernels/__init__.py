"""The C++ kernels and their one Python face: the quantities of `definition`, one call or a batch. Floor 4."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ..model import RobotModel
from . import _core
from .program import JOINT, compile_joints, compile_tail, gravity_base

if JOINT.itemsize != _core.JOINT_SIZE:  # pragma: no cover - a build of another version lies beside these files
    raise ImportError("the compiled kernels do not belong to this version of kinestatics; reinstall it")

Chain = _core.Chain
STANDARD_GRAVITY = (0.0, 0.0, -9.81)
ALL_ROWS = (0, 1, 2, 3, 4, 5)


def chain_arguments(
    model: RobotModel,
    link: int,
    *,
    axes_of_target: bool = False,
    origin_at_base: bool = False,
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rows: tuple[int, ...] = ALL_ROWS,
    rank: int | None = None,
    gravity: tuple[float, float, float] = STANDARD_GRAVITY,
) -> tuple[bytes, bytes, int, bool, bool, bytes, float, bytes, int]:
    """Arguments that make a `Chain`: the program of one target of a model.

    Args:
        model: the robot; its lengths must be float64. Masses that are symbols count as none.
        link: index of the target link; its frame is displaced by `offset` [m] in its own axes.
        axes_of_target: write six-vectors in the target's axes, else in base axes.
        origin_at_base: take them at the base origin, else at the target's.
        rows: rows in play for manipulability, singular values and damped rates.
        rank: how many singular values of these rows the manipulability multiplies, the largest first; default all.
        gravity: (3) in base axes [m/s²].
    """
    path = model.path(model.link_joints[link])
    turn, strength = gravity_base(gravity)
    tree = compile_joints(model, tuple(range(len(model.parents))), turn, masses=not model.has_symbolic_masses)
    tail = compile_tail(model, link, offset, path)
    return (
        compile_joints(model, path).tobytes(),
        tree.tobytes(),
        model.n,
        origin_at_base,
        axes_of_target,
        tail.tobytes(),
        strength,
        np.asarray(rows, dtype=np.intc).tobytes(),
        min(len(rows), model.n) if rank is None else rank,
    )


def instruction_set() -> str:
    """The instruction set in use: "avx512", "avx2" or "baseline"."""
    return _core.instruction_set()


def instruction_sets() -> list[str]:
    """The instruction sets this processor can run, the fastest first."""
    return _core.instruction_sets()


@contextmanager
def use(name: str) -> Iterator[None]:
    """Run the kernels of one instruction set inside a `with` block; for tests and benchmarks, and not thread-safe.

    Raises:
        ValueError: this processor cannot run it.
    """
    before = _core.instruction_set()
    _core.select_instruction_set(name)
    try:
        yield
    finally:
        _core.select_instruction_set(before)


def release_memory() -> None:
    """Give the memory kept for the next large result (at most two buffers) back to the system."""
    _core.release_memory()
