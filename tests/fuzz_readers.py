"""Mutation fuzzing of everything that reads input: `python tests/fuzz_readers.py --minutes 20 [--seed N] [--mjcf]`.

The contract: whatever comes in, the only exception is a KinestaticsError; no input takes more than 5 s of processor time or
1 GB of memory; and a model that is accepted has unit screws, finite poses, a finite Jacobian and finite holding torques.
Inputs are made from (seed, index) alone, so that each can be made again: `--only INDEX` runs one in this process.
A worker process runs them; when it dies or falls silent, its input is the offender, and another goes on from there.
"""

from __future__ import annotations

import argparse
import collections
import copy
import json
import math
import multiprocessing
import random
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

import kinestatics as ks
from corpus import malformed
from kinestatics.cli.arguments import number, numbers, read_configuration, read_loads, read_mounting, with_payloads
from kinestatics.robots.assemble import assemble
from kinestatics.robots.urdf import parse_urdf

try:
    import resource
except ImportError:  # Windows: time is still measured, memory is not
    resource = None

SECONDS, MEGABYTES, SILENCE = 5.0, 1024, 60.0
LARGEST_SEED, SHARE = 4000, 100  # bytes; one input in so many goes to the MJCF reader, where that is asked for

TREE = """<robot name="tree"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.5 0 0" rpy="0.1 0.2 0.3"/><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial><visual><geometry><mesh filename="package://p/a.stl"/>
</geometry></visual></link><link name="left"><inertial><mass value="1"/></inertial></link><link name="right"/>
<link name="tool"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 1" rpy="0 1.5 0"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="left"/><axis xyz="0 0 1"/>
<limit lower="0.1" upper="1" effort="10" velocity="1"/></joint>
<joint name="follow" type="prismatic"><parent link="arm"/><child link="right"/><axis xyz="1 0 1"/>
<mimic joint="slide" multiplier="-2" offset="0.25"/></joint>
<joint name="chase" type="continuous"><parent link="right"/><child link="tool"/><mimic joint="follow" multiplier="3"/>
</joint>
<gazebo reference="arm"><material>x</material></gazebo><transmission name="t"><joint name="turn"/></transmission></robot>"""
MJCF = """<mujoco model="m"><compiler angle="radian"/><worldbody><body name="a" pos="0 0 1"><joint name="j" axis="0 1 0"
range="-1 1"/><geom type="capsule" size="0.1 0.2" mass="1"/><body name="b" pos="0 0 0.5" quat="1 0 0 1"><joint name="s"
type="slide" axis="1 0 0" limited="false"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="tip"/></body>
</body></worldbody><equality><joint joint1="j" joint2="s" polycoef="0 2 0 0 0"/></equality></mujoco>"""
WORDS = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e155", "1e-162", "5e-324", "1e400", "0", "-0.0", "1,5", "0x10", "1_0", "٣",
    "", " ", "1 2", "1 2 3", "0 0 0", "1e200 1e200 0", "3e-162 0 0", "true", "${x}", "pi", "base", "arm", "tool", "turn",
    "slide", "revolute", "continuous", "prismatic", "fixed", "floating", "planar", "helical", "../../etc/passwd", "😀",
    "package://", "package:///etc/passwd", "file:///etc/passwd", "package://%00/..%2f", "\u202e", "1e9", "-1", "1" * 30,
)  # fmt: skip
FRAGMENTS = (
    "<!DOCTYPE r>", "<!ENTITY a 'b'>", "&a;", "&#0;", "&#x1F600;", "<![CDATA[", "]]>", "<!--", "-->", "<?xml?>", "\x00",
    "\xff", "</robot>", "<robot>", "<link/>", "<joint/>", 'xmlns="x"', "\ufeff", "\r\n", "<a>" * 70, f'name="{"n" * 5000}"',
)  # fmt: skip
NUMBERS = (
    0, 1, -1, 0.5, math.pi / 2, 7, 1e-8, 1e-162, 5e-324, 1e155, 1e308, -1e308, math.inf, math.nan, True, None, "1", b"1",
    1j, (), [1], [[1], [1, 2]], 10**400, np.float32(0.1), np.nan, np.array([1.0]), np.zeros((2, 2)), object(),
)  # fmt: skip
GRAMMAR = "0123456789.,+-*/()eEjx_ pidegnaf'\"\\\n\x00[]{}@=:lmbotruhj٣"


class Input(NamedTuple):
    """One input: which reader it goes to, and what it is."""

    reader: str
    value: Any


# ---- making inputs ------------------------------------------------------------------------------------------------------


def seeds(kind: str) -> list[str]:
    """Small files to start from: the malformed corpus, handmade ones, and real ones where they are installed."""
    own = [text for name, text in malformed().items() if name.endswith(kind) and 0 < len(text) < LARGEST_SEED]
    own += [TREE] * 12 if kind == ".urdf" else [MJCF] * 6
    real = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data/robots/*/urdf/*.urdf")
    small = sorted(path for path in real if path.stat().st_size < 5 * LARGEST_SEED) if kind == ".urdf" else []
    return own + [path.read_text(encoding="utf-8") for path in small[:8]]


SEEDS = {kind: seeds(kind) for kind in (".urdf", ".xml")}


def mutated_bytes(rng: random.Random, data: bytes) -> bytes:
    """A few flips, cuts, copies and insertions."""
    for _ in range(rng.choice((1, 1, 2, 4, 12))):
        at, end = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        piece = rng.choice((*WORDS, *FRAGMENTS)).encode()
        data = rng.choice(
            (
                data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
                data[:at] + data[min(end, at + 40) :],
                data[:at] + piece + data[at:],
                data[:at] + piece + data[at + len(piece) :],
                data[:at] + data[at : at + 200] * rng.choice((2, 3, 50)) + data[at:],
                data[:end],
            )
        )
    return data


def mutated_tree(rng: random.Random, text: str) -> bytes:
    """Elements dropped, repeated, moved and renamed; attributes dropped, exchanged and set to what no number should be."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return mutated_bytes(rng, text.encode())
    for _ in range(rng.choice((1, 1, 2, 3, 6))):
        elements = list(root.iter())
        one, other = rng.choice(elements), rng.choice(elements)
        names = list(one.attrib)
        action = rng.randrange(7)
        if action == 0 and len(one):
            one.remove(rng.choice(list(one)))
        elif action == 1:
            one.append(copy.deepcopy(other))
        elif action == 2:
            one.tag = other.tag
        elif action == 3 and names:
            del one.attrib[rng.choice(names)]
        elif action == 4 and names and other.attrib:
            one.attrib[rng.choice(names)] = rng.choice(list(other.attrib.values()))
        elif names:
            one.attrib[rng.choice(names)] = rng.choice(WORDS)
    return ElementTree.tostring(root, encoding="utf-8")


def made_file(rng: random.Random, kind: str) -> bytes:
    text = rng.choice(SEEDS[kind])
    data = mutated_tree(rng, text) if rng.random() < 0.7 else text.encode()
    return mutated_bytes(rng, data) if rng.random() < 0.4 else data


def some_number(rng: random.Random) -> Any:
    return rng.choice((rng.uniform(-2, 2), rng.choice(NUMBERS))) if rng.random() < 0.2 else rng.uniform(-2, 2)


def table(rng: random.Random, width: int) -> list[list[Any]]:
    """Rows of about the right width, mostly of numbers."""
    wide = rng.choice((width, width, width, width, width, width - 1, width + 1, 2 * width))
    return [[some_number(rng) for _ in range(wide)] for _ in range(rng.choice((0, 1, 2, 3, 7)))]


def sometimes(rng: random.Random, value: Any) -> Any:
    """The argument, something else in its place, or nothing."""
    return value if (dice := rng.random()) < 0.3 else rng.choice((*NUMBERS, *WORDS)) if dice < 0.35 else None


def options(rng: random.Random, n: int) -> dict[str, Any]:
    """Optional arguments that from_dh and from_screws share."""
    n = rng.choice((n, n, n, n, n + 1))
    given = {
        "joint_names": sometimes(rng, [rng.choice((f"j{i}", f"j{i}", f"j{i}", "j0")) for i in range(n)]),
        "limits": sometimes(rng, [(some_number(rng), some_number(rng)) for _ in range(n)]),
    }
    return {word: value for word, value in given.items() if value is not None}


def made_dh(rng: random.Random) -> dict[str, Any]:
    rows = table(rng, 4)
    n, pose = len(rows), np.eye(4)
    given = {
        "types": sometimes(rng, "".join(rng.choice("RPRPRPrpX") for _ in range(n))),
        "masses": sometimes(rng, [some_number(rng) for _ in range(n)]),
        "centers_of_mass": sometimes(rng, [[some_number(rng) for _ in range(3)] for _ in range(n)]),
        "inertias": sometimes(rng, [np.eye(rng.choice((3, 3, 3, 2))) for _ in range(n)]),
        "base": sometimes(rng, pose * rng.choice((1, 1, 2, np.nan))),
        "tool": sometimes(rng, pose[: rng.choice((4, 4, 3))]),
    }
    given = {word: value for word, value in given.items() if value is not None}
    return {
        "rows": rows,
        "convention": rng.choice(("standard", "modified") * 10 + ("craig", None)),
        **given,
        **options(rng, n),
    }


def made_screws(rng: random.Random) -> dict[str, Any]:
    axes: list[Any] = table(rng, 6)
    for i in range(len(axes)):
        if rng.random() < 0.8:
            w, p = np.array([rng.gauss(0, 1) for _ in range(3)]), [rng.gauss(0, 1) for _ in range(3)]
            axes[i] = ks.screw_axis(w, p, rng.choice((0.0, 0.0, 0.2, math.inf)))  # type: ignore[arg-type]
    given = {
        "home": sometimes(rng, np.eye(4)),
        "order": rng.choice(("linear-angular",) * 8 + ("angular-linear", None, "x")),
        "frame": rng.choice(("spatial", "body") * 10 + ("tool",)),
    }
    return {"axes": axes, **{k: v for k, v in given.items() if v is not None}, **options(rng, len(axes))}


def made_text(rng: random.Random) -> str:
    start = rng.choice(("", "-pi/2", "30deg", "0,-pi/4,0,-3*pi/4", "1e3*(2+pi)", "home", "random"))
    for _ in range(rng.choice((0, 1, 2, 5, 20))):
        at = rng.randrange(len(start) + 1)
        start = start[:at] + rng.choice(GRAMMAR) + start[at + rng.randrange(2) :]
    return start * rng.choice((1, 1, 1, 1, 2, 3000)) if rng.random() < 0.1 else start


def made_names(rng: random.Random) -> dict[str, Any]:
    links = ("base", "arm", "tool", "tip", "left", "right", "link:base", "turn", "", "ar\x00m", "n" * 200, "😀", "..")
    joints = {rng.choice(("turn", "slide", "follow", "chase", "slid")): rng.choice((0.0, 0.5, -3, 1e308, math.nan, "x"))}
    if rng.random() < 0.2:
        return {"robot": rng.choice(("planar_2r", "ur5ee", "/", *links))}
    base, tip = (rng.choice((None, *links[: rng.choice((3, 6, len(links)))])) for _ in range(2))
    return {"base": base, "tip": tip, "joints": rng.choice((None, joints)), "whole_tree": rng.random() < 0.3}


def made(seed: int, index: int, mjcf: bool = False) -> Input:
    """The input of that seed and index, and of nothing else."""
    rng = random.Random(f"{seed}:{index}")
    if mjcf and index % SHARE == 0:
        return Input("mjcf", made_file(rng, ".xml"))
    reader = rng.choices(("urdf", "file", "dh", "screws", "text", "names"), (60, 5, 12, 8, 10, 5))[0]
    makers = {"dh": made_dh, "screws": made_screws, "text": made_text, "names": made_names}
    return Input(reader, makers[reader](rng) if reader in makers else made_file(rng, ".urdf"))


# ---- the contract -------------------------------------------------------------------------------------------------------


def check_model(model: ks.RobotModel) -> None:
    """Unit screws; finite poses, Jacobians and torques wherever a joint may stand."""
    w, v = (np.linalg.norm(part, axis=-1) for part in (model.screws[:, 3:], model.screws[:, :3]))
    assert np.all((np.abs(w - 1) < 1e-6) | ((w == 0) & (np.abs(v - 1) < 1e-6))), f"screws are not unit: {model.screws}"
    R = model.placements[:, :3, :3]
    assert np.allclose(R @ R.swapaxes(-1, -2), np.eye(3), atol=1e-6), "a placement is not a rotation"
    assert np.all(np.isfinite(model.folding)), "multipliers are not finite"
    for q in (np.zeros(model.n), model.home, model.random_configurations(1, seed=0)[0]):
        for link in model.link_names[-3:]:
            name = model.link_name(model.link_names.index(link))
            assert np.all(np.isfinite(ks.pose(model, q, at=name).array)), f"pose of {link!r} is not finite at {q}"
            assert np.all(np.isfinite(ks.jacobian(model, q, at=name).array)), f"Jacobian of {link!r} is not finite at {q}"
        if model.has_masses:
            assert np.all(np.isfinite(ks.gravity_torques(model, q))), f"torques are not finite at {q}"


def read_text(text: str) -> None:
    """Every place where the shell turns text into numbers; one after the other, each with its own refusal."""
    arm, refusals = ks.load("planar_2r"), []
    readers = (
        number,
        numbers,
        lambda t: read_configuration(arm, t, 0),
        lambda t: [load.array for _, load in read_loads([t], None, "tip")],
        lambda t: with_payloads(arm, [t]).masses,
        read_mounting,
    )
    for read in readers:
        try:
            assert np.all(np.isfinite(np.asarray(read(text)))), "not finite"
        except ks.KinestaticsError as error:
            refusals.append(error)
    if len(refusals) == len(readers):
        raise refusals[0]


def read_names(value: dict[str, Any]) -> None:
    """Names of links, joints and robots that may not exist."""
    check_model(ks.load(value["robot"]) if "robot" in value else assemble(parse_urdf(TREE.encode(), "tree.urdf"), **value))


def run(one: Input, folder: Path) -> None:
    """Reads one input and checks what was accepted; raises KinestaticsError where it is refused."""
    if one.reader == "text":
        read_text(one.value)
    elif one.reader == "names":
        read_names(dict(one.value))
    elif one.reader == "urdf":
        check_model(assemble(parse_urdf(one.value, str(folder / "input.urdf")), whole_tree=True))
    elif one.reader in ("file", "mjcf"):
        path = folder / ("input.urdf" if one.reader == "file" else "input.xml")
        path.write_bytes(one.value)
        check_model(ks.load(path, whole_tree=one.reader == "mjcf"))
    else:
        make: Any = {"dh": ks.from_dh, "screws": ks.from_screws}[one.reader]
        value = dict(one.value)
        check_model(make(value.pop("rows" if one.reader == "dh" else "axes"), **value))


def megabytes_at_most() -> float:
    """The most memory this process has had so far."""
    if resource is None:
        return 0.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)


def outcome(one: Input, folder: Path) -> tuple[str, str]:
    """("accepted" or a code, "") or ("broken", why)."""
    began, before = time.process_time(), megabytes_at_most()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ks.KinestaticsWarning)
        try:
            run(one, folder)
            result = ("accepted", "")
        except ks.KinestaticsError as error:
            result = (error.code, str(error))
        except Exception:
            result = ("broken", traceback.format_exc(limit=-6))
    if (spent := time.process_time() - began) > SECONDS:
        return "broken", f"{spent:.1f} s of processor time"
    allowed = MEGABYTES + (before if before > MEGABYTES else 0.0)  # in a process that was large already, what it has grown
    if (most := megabytes_at_most()) > allowed:
        return "broken", f"{most:.0f} MB of memory"
    return result


# ---- the loop -----------------------------------------------------------------------------------------------------------


def work(pipe: Any, seed: int, start: int, mjcf: bool, folder: str) -> None:
    """The worker: one report for each input, until it is stopped. An input that takes twice what it may is cut short."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_DATA, (2 * MEGABYTES << 20, 2 * MEGABYTES << 20))
    for index in range(start, sys.maxsize):
        one = made(seed, index, mjcf)
        pipe.send((index, one.reader, *outcome(one, Path(folder))))


class Tally:
    """Counts what the worker reports, and keeps the offenders."""

    def __init__(self, seed: int, mjcf: bool) -> None:
        self.seed, self.mjcf = seed, mjcf
        self.counts: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
        self.offenders: list[dict[str, Any]] = []
        self.seconds = 0.0

    @property
    def inputs(self) -> int:
        """How many were read."""
        return sum(counter.total() for counter in self.counts.values())

    def add(self, index: int, reader: str, result: str, why: str) -> None:
        """One report."""
        self.counts[reader][result] += 1
        if result == "broken":
            value = repr(made(self.seed, index, self.mjcf).value)
            self.offenders.append({"seed": self.seed, "index": index, "reader": reader, "why": why, "input": value})

    def __str__(self) -> str:
        lines = [f"{self.inputs} inputs in {self.seconds:.0f} s: {self.inputs / max(self.seconds, 1e-9):.0f} a second"]
        for reader, counter in sorted(self.counts.items()):
            shown = ", ".join(f"{name} {count}" for name, count in counter.most_common())
            lines.append(f"  {reader}: {counter.total()} ({shown})")
        return "\n".join([*lines, f"offenders: {len(self.offenders)}"])


def fuzz(seconds: float, seed: int = 0, *, mjcf: bool = False, most: int = sys.maxsize) -> Tally:
    """Feeds inputs to a worker for some seconds, or until `most` have been read."""
    with tempfile.TemporaryDirectory() as folder:  # ours, since workers are killed
        return _fuzz(seconds, seed, mjcf, most, folder)


def _fuzz(seconds: float, seed: int, mjcf: bool, most: int, folder: str) -> Tally:
    tally, began, following = Tally(seed, mjcf), time.monotonic(), 0
    context = multiprocessing.get_context("spawn")
    while time.monotonic() - began < seconds and tally.inputs < most:
        ours, theirs = context.Pipe()
        worker = context.Process(target=work, args=(theirs, seed, following, mjcf, folder), daemon=True)
        worker.start()
        theirs.close()
        try:
            while time.monotonic() - began < seconds and tally.inputs < most:
                if not ours.poll(SILENCE):
                    raise EOFError
                report = ours.recv()
                tally.add(*report)
                following = report[0] + 1
        except EOFError:
            worker.join(1)
            tally.add(following, made(seed, following, mjcf).reader, "broken", f"the worker fell silent ({worker.exitcode})")
            following += 1
        worker.kill()
        worker.join()
    tally.seconds = time.monotonic() - began
    return tally


def main() -> int:
    """The command line; exit code 1 when the contract was broken."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mjcf", action="store_true", help=f"one input in {SHARE} goes to the MJCF reader")
    parser.add_argument("--save", type=Path, help="file for the offending inputs, one JSON object a line")
    parser.add_argument("--only", type=int, help="run the input of this index here, with its traceback")
    arguments = parser.parse_args()
    if arguments.only is not None:
        one = made(arguments.seed, arguments.only, arguments.mjcf)
        with tempfile.TemporaryDirectory() as folder:
            sys.stdout.write(f"{one}\n{outcome(one, Path(folder))}\n")
        return 0
    tally = fuzz(60 * arguments.minutes, arguments.seed, mjcf=arguments.mjcf)
    sys.stdout.write(f"{tally}\n" + "".join(f"{o['reader']} {o['index']}: {o['why']}\n" for o in tally.offenders[:20]))
    if arguments.save is not None:
        arguments.save.write_text("".join(json.dumps(o) + "\n" for o in tally.offenders), encoding="utf-8")
    return 1 if tally.offenders else 0


if __name__ == "__main__":
    sys.exit(main())
