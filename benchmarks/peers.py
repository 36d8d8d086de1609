"""The contestants that are called from Python: Pinocchio in a loop, JAX under vmap and jit, the Robotics Toolbox."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from robots import Subject


def pinocchio_python(subject: Subject, q: Any, out: Any) -> Callable[[], None]:
    """A Python loop over computeFrameJacobian, into a preallocated array."""
    model, data, tool, frame = subject.model, subject.data, subject.tool, pin.LOCAL_WORLD_ALIGNED

    def loop() -> None:
        for i in range(len(q)):
            out[i] = pin.computeFrameJacobian(model, data, q[i], tool, frame)

    return loop


def jax_jacobian(subject: Subject) -> Callable[[Any], Any] | None:
    """A hand-written Jacobian of a revolute chain under jit(vmap), double precision; None where JAX is not installed."""
    try:
        import jax
        import jax.numpy as jnp
    except ImportError:
        return None
    jax.config.update("jax_enable_x64", True)
    arm = subject.arm
    placements, last = jnp.asarray(arm.placements), jnp.asarray(arm.link_placements[arm.link("tip")])
    axes = jnp.asarray(arm.screws[:, 3:])
    skews = [jnp.asarray(np.cross(np.eye(3), axis).T) for axis in np.asarray(axes)]

    def one(q: Any) -> Any:
        R, p, points, directions = jnp.eye(3), jnp.zeros(3), [], []
        for i in range(arm.n):
            p, R = p + R @ placements[i, :3, 3], R @ placements[i, :3, :3]
            K = skews[i]
            points.append(p)
            directions.append(R @ axes[i])
            R = R @ (jnp.eye(3) + jnp.sin(q[i]) * K + (1 - jnp.cos(q[i])) * (K @ K))
        w = jnp.stack(directions)
        v = jnp.cross(w, p + R @ last[:3, 3] - jnp.stack(points))
        return jnp.concatenate([v, w], 1).T

    compiled = jax.jit(jax.vmap(one))
    return lambda q: compiled(q).block_until_ready()


def toolbox_jacobian(subject: Subject) -> Callable[[Any], Any] | None:
    """`jacob0` of the Robotics Toolbox for Python, on its model of the same file; None where it is not installed."""
    try:
        import roboticstoolbox as rtb
    except ImportError:
        return None
    transforms: list[Any] = []
    arm = subject.arm
    for i in range(arm.n):
        transforms.append(rtb.ET.SE3(arm.placements[i]))
        axis = "xyz"[int(np.argmax(np.abs(arm.screws[i, 3:])))]
        transforms.append(getattr(rtb.ET, f"R{axis}")(flip=bool(arm.screws[i, 3:].sum() < 0)))
    transforms.append(rtb.ET.SE3(arm.link_placements[arm.link("tip")]))
    chain = rtb.ETS(transforms)
    jacobian: Callable[[Any], Any] = chain.jacob0
    return jacobian
