"""An analysis as a person would want to read it: the same numbers, in words and tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .._kernels import STANDARD_GRAVITY
from ..namespaces import Array
from ..quantities import TIED, WIDTH, format_number, largest, table, wrapped
from .result import Analysis, Margin


def paragraphs(a: Analysis) -> list[str]:
    """The parts of a printed analysis, from where the arm is to what is not known of it."""
    parts = [_heading(a), str(a.pose), str(a.jacobian), _rank_text(a), _direction_text(a), _near_text(a)]
    parts += [_ellipsoid_text(a), _ability_text(a), *_load_texts(a), _torque_text(a), _reaction_text(a), _limit_text(a)]
    return [part for part in [*parts, "\n".join(wrapped("note: ", note) for note in a.notes)] if part]


def _unit_of(kind: str, angle: str = "rad") -> str:
    return "m" if kind == "prismatic" else angle


def _heading(a: Analysis) -> str:
    head = f"{a.robot}: {len(a.joints)} joint{'s' * (len(a.joints) != 1)}, from {a.base} to {a.tip}"
    if not a.joints:
        return head
    about = []
    if a.payloads:
        held = [f"{name}{TIED}{format_number(mass)}{TIED}kg" for name, mass in a.payloads.items()]
        about.append(wrapped("carries ", ", ".join(held)))
    if tuple(a.gravity) != STANDARD_GRAVITY:
        pull = ", ".join(format_number(x) for x in a.gravity)
        about.append(wrapped("gravity ", f"({pull}) m/s² in axes of {a.base}"))
    lines = [head, *about, wrapped("q = ", _values(a.configuration, a.kinds, "rad", format_number))]
    if any(kind != "prismatic" and x != 0 for x, kind in zip(a.configuration, a.kinds, strict=True)):
        turned = [x if kind == "prismatic" else np.degrees(x) for x, kind in zip(a.configuration, a.kinds, strict=True)]
        lines.append(wrapped("  = ", _values(turned, a.kinds, "deg", lambda x: format_number(round(float(x), 2)))))
    return "\n".join(lines)


def _values(values: Sequence[float], kinds: Sequence[str], angle: str, write: Callable[[float], str]) -> str:
    """Joint values, with one unit behind them all where it is the same for all."""
    units = [_unit_of(kind, angle) for kind in kinds]
    if len(set(units)) == 1:
        return f"({', '.join(write(x) for x in values)}){TIED}[{units[0]}]"
    return f"({', '.join(f'{write(x)}{TIED}{unit}' for x, unit in zip(values, units, strict=True))})"


def _rank_text(a: Analysis) -> str:
    verdict = "singular" if a.is_singular else "not singular"
    small = f"singular values below {a.tolerance:g} of the largest count as zero"
    counted = [f"{x:.4g}" if k < a.rank else "0" for k, x in enumerate(a.singular_values)]
    unit = {"1": "", "mixed units": " (mixed units)"}.get(a.manipulability_unit, f" {a.manipulability_unit}")
    lines = [
        wrapped("task rows        ", f"{', '.join(a.task.row_names) or '(none)'} ({a.task.reason})"),
        wrapped("rank             ", f"{a.rank} of {a.task.rank}: {verdict} ({small})"),
        wrapped("singular values  ", ", ".join(counted) or "(none)"),
    ]
    if a.scaled:
        length = format_number(a.characteristic_length)
        lines.append(wrapped(" " * 17, f"({' and '.join(a.scaled)} times the characteristic length {length}{TIED}m)"))
    lines += [
        f"condition        {f'{a.condition:.4g}' if np.isfinite(a.condition) else 'infinite'}",
        f"isotropy         {'0' if a.is_singular else f'{a.isotropy:.4g}'}",
        f"manipulability   {'0' if a.is_singular else f'{a.manipulability:.4g}'}{unit}",
    ]
    return "\n".join(lines)


def _near_text(a: Analysis) -> str:
    """How far each singularity is, by name."""
    if a.near is None:
        return ""
    if not a.near:
        return "no singularity was found for this task"
    return "\n".join(["nearest singularities, in joint space", *(wrapped("  ", str(distance)) for distance in a.near)])


def _direction_text(a: Analysis) -> str:
    if not a.lost_twists:
        return "no direction of the task is lost; every wrench in it is felt by some joint"
    if a.is_singular:
        head = "directions of motion lost here"
        if (always := len(a.task.rows) - a.task.rank) > 0:
            head += f" (of them {always} in every posture: {len(a.task.rows)} rows, {a.task.rank} freedoms)"
    else:
        head = f"directions without motion, as in every posture ({len(a.task.rows)} rows, {a.task.rank} freedoms)"
    lost, free = ([wrapped("  ", screw.text, hang=4) for screw in screws] for screws in (a.lost_twists, a.free_wrenches))
    return "\n".join([head, *lost, "wrenches held for free (no joint torque)", *free])


def _ellipsoid_text(a: Analysis) -> str:
    """Both ellipsoids as one table: they share their axes, and their radii are reciprocal."""
    velocity, force = a.velocity_ellipsoid, a.force_ellipsoid
    if velocity is None or force is None:
        return ""
    rows = [[f"speed [{velocity.unit}]", f"force [{force.unit}]", *velocity.rows]]
    for speed, strength, axis in zip(velocity.radii, force.radii, velocity.axes.T, strict=True):
        held = "unlimited" if np.isinf(strength) else format_number(strength)
        rows.append([format_number(speed), held, *map(format_number, axis)])
    return "\n".join(["ellipsoids of velocity and force (unit joint speeds, unit joint torques)", table(rows)])


def _ability_text(a: Analysis) -> str:
    """What the limits of the joints allow along each axis, and the payload."""
    lines = []
    if a.abilities:
        lines.append(
            wrapped("", f"with the limits of the joints, along axes of {a.jacobian.frame.axes}, other loads left out")
        )
        lines += _ability_table(a)
        if rest := [row for row in a.speed_rows if not row.startswith("v")]:
            lines.append(wrapped("", f"(the speed is that of pure translation: {', '.join(rest)} at rest)"))
    if a.payload_capacity is not None:
        more = " more" if a.payloads else ""
        lines.append(wrapped("", f"greatest mass held at {a.tip}{more}, no other load: {a.payload_capacity.verdict}"))
    return "\n".join(lines)


def _ability_table(a: Analysis) -> list[str]:
    """With the names of the limiting joints, or with their numbers where names would make it too wide."""
    named = _abilities(a, {name: name for name in a.joints})
    if len(named.partition("\n")[0]) <= WIDTH:
        return [named]
    used = {name for able in a.abilities for name in (*able.speed_joints, *able.push_joints)}
    numbers = {name: f"joint {k + 1}" for k, name in enumerate(a.joints)}
    listed = ", ".join(f"{k + 1}{TIED}{name}" for k, name in enumerate(a.joints) if name in used)
    return [_abilities(a, numbers), wrapped("joints: ", listed)]


def _abilities(a: Analysis, names: dict[str, str]) -> str:
    rows = [["", "speed [m/s]", "limited by", "push [N]", "limited by"]]
    for able in a.abilities:
        cells = []
        for value, joints in ((able.speed, able.speed_joints), (able.push, able.push_joints)):
            shown = "unknown" if value is None else "unlimited" if np.isinf(value) else format_number(value)
            cells += [shown, ", ".join(names[joint] for joint in joints)]
        rows.append([able.direction, *cells])
    return table(rows)


def _load_texts(a: Analysis) -> list[str]:
    """Who holds each load; the torques are in a table of their own."""
    return [load.split.words for load in a.loads]


def _torque_text(a: Analysis) -> str:
    columns: list[tuple[str, Array]] = []
    if a.gravity_torques is not None:
        columns.append(("gravity", a.gravity_torques))
    if a.joint_torques is not None:
        columns.append(("loads" if a.wrench is None else _WORDS[a.wrench.acts_on], a.joint_torques))
    if not columns or not a.joints:
        return ""
    if len(columns) == 2 and a.holding_torques is not None:
        columns.append(("both", a.holding_torques))
    width = max(len(name) for name in a.joints)
    lines = ["torques that hold the arm still" + (" [N m]" if "prismatic" not in a.kinds else "")]
    cells = [[name, *(format_number(x, largest(values)) for x in values)] for name, values in columns]
    cells.append(["limit", *(format_number(x) if np.isfinite(x) else "unknown" for x in a.effort_limits)])
    widths = [max(len(cell) for cell in column) + 2 for column in cells]
    for i, name in enumerate(["", *a.joints]):
        numbers = "".join(f"{column[i]:>{w}s}" for column, w in zip(cells, widths, strict=True))
        lines.append(f"  {name:{width}s}{numbers}{_torque_remark(a, i - 1, columns[-1][1]) if i else ''}")
    if a.potential_energy is not None:
        lines.append(wrapped("", f"potential energy {format_number(a.potential_energy)} J (zero at the origin of the base)"))
    return "\n".join(lines)


def _torque_remark(a: Analysis, i: int, torques: Array) -> str:
    """The unit behind a row of the torque table, where they differ, and whether the motor can supply it."""
    unit = "" if "prismatic" not in a.kinds else "  N" if a.kinds[i] == "prismatic" else "  N m"
    return unit + ("  over the limit" if abs(torques[i]) > a.effort_limits[i] else "")


_WORDS = {"robot": "load", "environment": "push"}


def _reaction_text(a: Analysis) -> str:
    """What the bearings bear; the drive is in the torque table."""
    found = a.reactions
    if found is None or not found.joints:
        return ""
    rows = [["", "radial [N]", "axial [N]", "bending [N m]"]]
    slides = [kind == "prismatic" for kind in found.kinds]
    if any(slides):
        rows[0].append("torsion [N m]")
    sizes = [largest(column) for column in (found.radial, found.axial, found.bending, found.torsion)]
    for k, name in enumerate(found.joints):
        values = (found.radial[k], found.axial[k], found.bending[k], found.torsion[k])
        cells = [format_number(x, size) for x, size in zip(values, sizes, strict=True)]
        cells[1 if slides[k] else 3] = "(motor)"
        rows.append([name, *cells[: len(rows[0]) - 1]])
    return "\n".join(["what the bearings carry", table(rows)])


def _limit_text(a: Analysis) -> str:
    near = [m for m in a.margins if m.near]
    if not near:
        return "no joint is near a position limit" if a.margins else "no position limits are known"
    kinds = dict(zip(a.joints, a.kinds, strict=True))
    return "\n".join(["joints near a position limit"] + [f"  {m.joint}: {_margin_words(m, kinds[m.joint])}" for m in near])


def _margin_words(margin: Margin, kind: str) -> str:
    amount = f"{format_number(abs(margin.distance))} {_unit_of(kind)}"
    if kind != "prismatic":
        amount += f" ({format_number(np.degrees(abs(margin.distance)))} deg)"
    if margin.distance < 0:
        return f"outside its {margin.limit} limit by {amount}"
    if margin.locked:
        return "locked: its limits leave it one position"
    return f"{amount} from its {margin.limit} limit" if margin.distance > 0 else f"at its {margin.limit} limit"
