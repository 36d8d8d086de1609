"""An analysis as a person would want to read it: the same numbers, in words and tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..namespaces import Array
from ..quantities import TIED, format_number, wrapped
from .result import Analysis, Margin


def paragraphs(a: Analysis) -> list[str]:
    """The parts of a printed analysis, from where the arm is to what is not known of it."""
    parts = [_heading(a), str(a.pose), str(a.jacobian), _rank_text(a), _direction_text(a), _torque_text(a), _limit_text(a)]
    return [part for part in [*parts, "\n".join(wrapped("note: ", note) for note in a.notes)] if part]


def _unit_of(kind: str, angle: str = "rad") -> str:
    return "m" if kind == "prismatic" else angle


def _heading(a: Analysis) -> str:
    head = f"{a.robot}: {len(a.joints)} joint{'s' * (len(a.joints) != 1)}, from {a.base} to {a.tip}"
    if not a.joints:
        return head
    lines = [head, wrapped("q = ", _values(a.configuration, a.kinds, "rad", format_number))]
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
        f"manipulability   {'0' if a.is_singular else f'{a.manipulability:.4g}'}{unit}",
    ]
    return "\n".join(lines)


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


def _torque_text(a: Analysis) -> str:
    columns: list[tuple[str, Array]] = []
    if a.gravity_torques is not None:
        columns.append(("gravity", a.gravity_torques))
    if a.joint_torques is not None:
        columns.append(("wrench" if a.wrench is None else _WORDS[a.wrench.acts_on][0], a.joint_torques))
    if not columns or not a.joints:
        return ""
    if len(columns) == 2:
        columns.append(("both", columns[0][1] + columns[1][1]))
    width = max(len(name) for name in a.joints)
    lines = ["torques that hold the arm still" + (" [N m]" if "prismatic" not in a.kinds else "")]
    if a.wrench is not None:
        values = ", ".join(format_number(x) for x in a.wrench.array)
        text = f"({values}) [N, N m]: {_WORDS[a.wrench.acts_on][1]}; {a.wrench.frame}"
        lines.insert(0, wrapped("wrench ", text))
    cells = [[name, *(format_number(x) for x in values)] for name, values in columns]
    cells.append(["limit", *(format_number(x) if np.isfinite(x) else "unknown" for x in a.effort_limits)])
    widths = [max(len(cell) for cell in column) + 2 for column in cells]
    for i, name in enumerate(["", *a.joints]):
        numbers = "".join(f"{column[i]:>{w}s}" for column, w in zip(cells, widths, strict=True))
        lines.append(f"  {name:{width}s}{numbers}{_torque_remark(a, i - 1, columns[-1][1]) if i else ''}")
    return "\n".join(lines)


def _torque_remark(a: Analysis, i: int, torques: Array) -> str:
    """The unit behind a row of the torque table, where they differ, and whether the motor can supply it."""
    unit = "" if "prismatic" not in a.kinds else "  N" if a.kinds[i] == "prismatic" else "  N m"
    return unit + ("  over the limit" if abs(torques[i]) > a.effort_limits[i] else "")


_WORDS = {"robot": ("load", "a load on the robot"), "environment": ("push", "the robot pushes on its surroundings")}


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
