"""What MuJoCo says about a model: the job of the bounded child of `mjcf`. Floor 4; the only module that imports mujoco.

MuJoCo resolves defaults, classes, frames, replicas, attached models, angles and orientations. Before it compiles, everything
that kinematics and masses do not need is deleted, so that a broken mesh, constraint or actuator cannot stop it. No file is
opened here but the meshes from which a mass is inferred, at the paths that the parent has allowed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

FLOOR = 1e-14  # kg and kg m²: MuJoCo does not compile a moving body without mass; taken off again afterwards
DEFAULT_COLOR = (0.5, 0.5, 0.5, 1.0)  # a geom that has this one takes its material's


def run(request: dict[str, Any]) -> dict[str, Any]:
    """The compiled model as lists of numbers, or {"refused": MuJoCo's message}.

    Args:
        request: "text", the model; "submodels", {file name: text}; "meshes", {file name: path, or None where there is none};
            "shapes", whether to say what the bodies look like, for which no mesh is opened, and nothing sound about masses.
    """
    if not hasattr(mujoco.MjSpec, "delete"):
        return {"refused": f"its version {mujoco.__version__} is too old; 3.3.4 or newer is needed"}
    mujoco.set_mju_user_warning(lambda _: None)  # by default a warning is written to a log file
    answer, needed = _answer(request, request["meshes"])
    if "refused" in answer and needed:  # is it a mesh? then kinematics can do without
        without, _ = _answer(request, dict.fromkeys(request["meshes"]))
        if "refused" not in without:
            return without | {"mesh_trouble": answer["refused"]}
    return answer


def _answer(request: dict[str, Any], meshes: dict[str, str | None]) -> tuple[dict[str, Any], set[str]]:
    """The answer, and the mesh files that it took."""
    needed: set[str] = set()
    try:
        return _compile(request, meshes, needed), needed
    except OSError as failure:
        return {"refused": f"a mesh cannot be read: {failure.strerror}"}, needed
    except (ValueError, RuntimeError, mujoco.FatalError) as failure:
        return {"refused": str(failure)}, needed


def _compile(request: dict[str, Any], meshes: dict[str, str | None], needed: set[str]) -> dict[str, Any]:
    submodels = {name: text.encode() for name, text in request["submodels"].items()}
    spec = mujoco.MjSpec.from_string(request["text"], include=submodels)
    answer: dict[str, Any] = {
        "equalities": [_equality(equality) for equality in spec.equalities],
        "actuators": [_actuator(actuator) for actuator in spec.actuators],
        "home": next(([float(x) for x in key.qpos] for key in spec.keys if key.name == "home"), None),
    }
    _delete(spec, [*spec.equalities, *spec.actuators, *spec.keys])
    shapes = [(geom, _shape(spec, geom)) for geom in spec.geoms] if request["shapes"] else []
    bodies = list(spec.bodies)
    bounds = [_compiler(spec, body).boundmass > 0 for body in bodies]  # asked before any is set: bodies share a compiler
    facts = [_settle(spec, body, bound, meshes, needed) for body, bound in zip(bodies, bounds, strict=True)]
    _delete(spec, [mesh for mesh in spec.meshes if mesh.file not in needed and mesh.file])
    spec.assets = {name: Path(meshes[name] or "").read_bytes() for name in needed}
    model = spec.compile()
    entries = [_body(model, body) for body in bodies]
    for entry, fact in zip(entries, facts, strict=True):
        _correct(entry, fact)
    answer["bodies"] = sorted(entries, key=lambda entry: entry["id"])
    answer["joints"] = sorted((_joint(model, joint) for joint in spec.joints), key=lambda entry: entry["id"])
    answer["sites"] = sorted((_site(model, site) for site in spec.sites), key=lambda entry: entry["id"])
    answer["shapes"] = [shape | _placed(model, geom) for geom, shape in shapes if shape["kind"] != "hfield"]
    answer["springs"] = [joint.name for joint in spec.joints if np.any(np.asarray(joint.stiffness) != 0)]
    return answer | {"nq": int(model.nq), "total_mass_is_set": bool(spec.compiler.settotalmass > 0)}


def _delete(spec: Any, elements: Iterable[Any]) -> None:
    for element in elements:
        spec.delete(element)


def _line(element: Any) -> int:
    """The line of the request's text on which an element began, 0 where it is not told."""
    found = re.search(r"line (\d+)", element.info)
    return int(found[1]) if found else 0


def _equality(equality: Any) -> dict[str, Any]:
    return {
        "type": equality.type.name.removeprefix("mjEQ_").lower(),
        "follower": equality.name1,
        "leader": equality.name2,
        "coefficients": [float(x) for x in equality.data[:5]],
        "active": bool(equality.active),
        "line": _line(equality),
    }


def _actuator(actuator: Any) -> dict[str, Any]:
    """Whose joint an actuator drives, and the range of force that it can put on it [N m or N], None without a bound."""
    on_joint = actuator.trntype in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    plain = actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED and actuator.biastype == mujoco.mjtBias.mjBIAS_NONE
    plain = plain and actuator.dyntype in (mujoco.mjtDyn.mjDYN_NONE, mujoco.mjtDyn.mjDYN_FILTER)
    ranges = []
    if _limited(actuator.forcelimited, actuator.forcerange):
        ranges.append([float(x) for x in actuator.forcerange])
    if plain and _limited(actuator.ctrllimited, actuator.ctrlrange):
        ranges.append(sorted(float(actuator.gainprm[0] * x) for x in actuator.ctrlrange))
    force = None
    if ranges:
        gear = float(actuator.gear[0])
        force = sorted([gear * max(low for low, _ in ranges), gear * min(high for _, high in ranges)])
    return {"joint": actuator.target if on_joint else None, "force": force, "line": _line(actuator)}


def _limited(word: Any, bounds: Any) -> bool:
    automatic = int(word) == int(mujoco.mjtLimited.mjLIMITED_AUTO)
    return bool(bounds[0] < bounds[1]) if automatic else bool(int(word))


def _compiler(spec: Any, body: Any) -> Any:
    """The compiler settings that hold for a body: an attached model keeps its own."""
    return getattr(body, "compiler", spec.compiler)


def _settle(spec: Any, body: Any, bound: bool, meshes: dict[str, str | None], needed: set[str]) -> dict[str, Any]:
    """Makes one body compile: geoms that only a viewer needs go, unsound inertias are replaced. Returns what was found."""
    compiler = _compiler(spec, body)
    for word in ("boundmass", "boundinertia"):
        if getattr(compiler, word) == 0:
            setattr(compiler, word, FLOOR)
    mode = int(compiler.inertiafromgeom)  # 0 never, 1 always, 2 where there is no <inertial>
    explicit = bool(body.explicitinertial)
    geoms = list(body.geoms)
    counts = [(mode == 1 or (mode == 2 and not explicit)) and _has_mass(geom, compiler) for geom in geoms]
    counted = [geom for geom, count in zip(geoms, counts, strict=True) if count]
    unknown = sorted({geom.meshname for geom in counted if _mesh_is_missing(spec, geom, meshes, needed)})
    for geom, count in zip(geoms, counts, strict=True):
        if geom.hfieldname or (geom.meshname and (unknown or not count)):
            _delete(spec, [geom])
    by_file = explicit and not counted
    massless = not counted and not (by_file and body.mass > 0)
    return {
        "mass_unknown": bool(unknown),
        "massless": massless and not bound,
        "own_inertia": _replace_inertia(body, compiler) if by_file and body.mass > 0 else None,
    }


def _has_mass(geom: Any, compiler: Any) -> bool:
    low, high = compiler.inertiagrouprange
    if not low <= geom.group <= high or geom.type in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
        return False
    return bool(geom.density != 0 if math.isnan(geom.mass) else geom.mass != 0)


def _mesh_is_missing(spec: Any, geom: Any, meshes: dict[str, str | None], needed: set[str]) -> bool:
    """Whether a geom takes its mass from a mesh whose file is not there; notes the file where it is."""
    mesh = next((mesh for mesh in spec.meshes if mesh.name == geom.meshname), None)
    if mesh is None or not mesh.file:  # no mesh, an unknown one (MuJoCo will say so), or one written in the model itself
        return False
    if meshes.get(mesh.file) is None:
        return True
    needed.add(mesh.file)
    return False


def _replace_inertia(body: Any, compiler: Any) -> dict[str, Any] | None:
    """An inertia that MuJoCo would refuse is exchanged for a sound one; the file's own, or None where it was sound."""
    full = [float(x) for x in body.fullinertia]
    if math.isnan(full[0]):
        moments = sorted(float(x) for x in body.inertia)
        matrix = np.diag([float(x) for x in body.inertia])
    else:
        xx, yy, zz, xy, xz, yz = full
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        moments = [float(x) for x in np.linalg.eigvalsh(matrix)]
    balanced = bool(compiler.balanceinertia) and moments[0] > 0
    if moments[0] >= FLOOR and (moments[0] + moments[1] >= moments[2] or balanced):
        return None
    if not math.isnan(full[0]):
        body.fullinertia = [math.nan] * 6
        body.iquat = [1.0, 0.0, 0.0, 0.0]
    body.inertia = [float(body.mass)] * 3  # a sphere: MuJoCo keeps the axes of <inertial>
    return {"matrix": matrix.tolist(), "mass": float(body.mass)}


def _body(model: Any, body: Any) -> dict[str, Any]:
    i = int(body.id)
    return {
        "id": i,
        "name": body.name,
        "parent": int(model.body_parentid[i]),
        "position": model.body_pos[i].tolist(),
        "quaternion": model.body_quat[i].tolist(),
        "mass": float(model.body_mass[i]),
        "compensated": bool(model.body_gravcomp[i] != 0),
        "center": model.body_ipos[i].tolist(),
        "axes": model.body_iquat[i].tolist(),
        "inertia": np.diag(model.body_inertia[i]).tolist(),
        "line": _line(body),
    }


def _correct(entry: dict[str, Any], fact: dict[str, Any]) -> None:
    """Puts back what had to be changed for MuJoCo to compile."""
    entry["mass_unknown"] = fact["mass_unknown"]
    own = fact["own_inertia"]
    entry["own_inertia"] = own is not None
    if fact["massless"] or fact["mass_unknown"]:
        entry["mass"], entry["inertia"] = 0.0, np.zeros((3, 3)).tolist()
    elif own is not None:  # scaled as MuJoCo has scaled the mass
        entry["inertia"] = (np.array(own["matrix"]) * (entry["mass"] / own["mass"])).tolist()


def _joint(model: Any, joint: Any) -> dict[str, Any]:
    i = int(joint.id)
    address = int(model.jnt_qposadr[i])
    return {
        "id": i,
        "name": joint.name,
        "body": int(model.jnt_bodyid[i]),
        "kind": joint.type.name.removeprefix("mjJNT_").lower(),
        "anchor": model.jnt_pos[i].tolist(),
        "axis": model.jnt_axis[i].tolist(),
        "reference": float(model.qpos0[address]),
        "range": model.jnt_range[i].tolist() if model.jnt_limited[i] else None,
        "force": model.jnt_actfrcrange[i].tolist() if model.jnt_actfrclimited[i] else None,
        "address": address,
        "line": _line(joint),
    }


def _site(model: Any, site: Any) -> dict[str, Any]:
    i = int(site.id)
    return {
        "id": i,
        "name": site.name,
        "body": int(model.site_bodyid[i]),
        "position": model.site_pos[i].tolist(),
        "quaternion": model.site_quat[i].tolist(),
        "line": _line(site),
    }


def _shape(spec: Any, geom: Any) -> dict[str, Any]:
    """What a geom looks like. One with a mesh becomes a small ball: MuJoCo then tells where the file's own axes lie."""
    kind = "mesh" if geom.meshname else geom.type.name.removeprefix("mjGEOM_").lower()
    shape: dict[str, Any] = {"kind": kind, "name": geom.name, "group": int(geom.group), "line": _line(geom), "mesh": None}
    material = next((material for material in spec.materials if material.name == geom.material), None)
    default = np.array_equal(geom.rgba, np.array(DEFAULT_COLOR, dtype=np.float32))
    shape["color"] = [float(x) for x in (material if material is not None and default else geom).rgba]
    if not geom.meshname:
        return shape
    mesh = next((mesh for mesh in spec.meshes if mesh.name == geom.meshname), None)
    if mesh is not None:
        shape["mesh"] = {
            "file": mesh.file,
            "scale": [float(x) for x in mesh.scale],
            "position": [float(x) for x in mesh.refpos],
            "quaternion": [float(x) for x in mesh.refquat],
        }
    geom.meshname, geom.type, geom.size = "", mujoco.mjtGeom.mjGEOM_SPHERE, [1e-3] * 3
    return shape


def _placed(model: Any, geom: Any) -> dict[str, Any]:
    """Whose geom it is, where it stands in the body, and its size as MuJoCo keeps it: halves and radii."""
    i = int(geom.id)
    return {
        "body": int(model.geom_bodyid[i]),
        "position": model.geom_pos[i].tolist(),
        "quaternion": model.geom_quat[i].tolist(),
        "size": model.geom_size[i].tolist(),
    }
