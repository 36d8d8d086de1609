"""What is installed here, and does it work? Floor 9.

Every optional package is imported once, the kernels of every instruction set are compared with the definition, and a browser
is looked for. Nothing is opened, nothing is sent.
"""

from __future__ import annotations

import os
import platform
import shutil
import sys
import warnings
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

from .extras import BASE, EXTRAS, bounds_of, imported_as, version_of, within
from .progress import Progress

CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
TOLERANCE = 1e-13
"""Of the self-test, relative to the largest entry of the Jacobian."""
_POSTURES = 64


@dataclass(frozen=True)
class PackageState:
    """One package.

    Attributes:
        name: what pip calls it; version: what is installed, None where nothing is; bounds: the versions asked for.
        fault: why it cannot be used though it is installed; empty where it can.
    """

    name: str
    version: str | None
    bounds: str
    fault: str


@dataclass(frozen=True)
class ExtraState:
    """One extra: its packages, what it is for, and the command that installs it.

    Attributes:
        name, purpose, command: as in `extras`.
        packages: each with its version.
        ready: whether all of it can be used.
    """

    name: str
    purpose: str
    command: str
    packages: tuple[PackageState, ...]
    ready: bool


@dataclass(frozen=True)
class KernelState:
    """The compiled kernels.

    Attributes:
        used: the instruction set in use; offered: all that this processor can run, the fastest first.
        processors: how many this process may use; a call uses one thread unless `threads=` asks for more.
        difference: largest deviation of a Jacobian from the definition, relative to its largest entry, over `checked`; None
            where none could be computed.
        checked: postures compared, for each instruction set.
        fault: what is wrong; empty where nothing is.
    """

    used: str
    offered: tuple[str, ...]
    processors: int
    difference: float | None
    checked: int
    fault: str


@dataclass(frozen=True)
class Installation:
    """What is installed, and whether it works.

    Attributes:
        version: of kinestatics; python, executable, system: where it runs.
        base: packages that are always needed; extras: the optional ones; kernels: the compiled part.
        browser: whether one can be opened from here; chromium: path of a Chromium, or None.
    """

    version: str
    python: str
    executable: str
    system: str
    base: tuple[PackageState, ...]
    extras: tuple[ExtraState, ...]
    kernels: KernelState
    browser: bool
    chromium: str | None

    @property
    def faults(self) -> tuple[str, ...]:
        """What is broken, a sentence each. An extra that is not installed is not broken."""
        packages = [*self.base, *(package for extra in self.extras for package in extra.packages)]
        found = [f"{package.name}: {package.fault}" for package in packages if package.fault]
        return (*found, *([f"kernels: {self.kernels.fault}"] if self.kernels.fault else []))

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "faults": list(self.faults)}


def examine(progress: Progress | None = None) -> Installation:
    """The state of this installation; takes some seconds, since every installed extra is imported.

    Args:
        progress: told which package is being looked at.

    Example:
        >>> examine().kernels.fault
        ''
    """
    version = version_of("kinestatics") or ""
    base = tuple(_package(name, needed=True) for name in BASE)
    extras = []
    for k, extra in enumerate(EXTRAS):
        if progress is not None:
            progress(f"extra {extra.name}", k / len(EXTRAS))
        states = tuple(_package(name) for name in extra.packages)
        ready = all(state.version is not None and not state.fault for state in states)
        extras.append(ExtraState(extra.name, extra.purpose, extra.command, states, ready))
    python, system = platform.python_version(), f"{platform.system()} {platform.machine()}"
    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    return Installation(version, python, sys.executable, system, base, tuple(extras), _kernels(), _can_open_browser(), found)


def _package(name: str, needed: bool = False) -> PackageState:
    """Version and fitness of a package; it is imported, since a broken one shows only then."""
    version, bounds = version_of(name), bounds_of(name)
    if version is None:
        return PackageState(name, None, bounds, f"is not installed; {name}{bounds} is needed" if needed else "")
    if not within(version, bounds):
        return PackageState(name, version, bounds, f"version {version} is installed; {bounds} is needed")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import_module(imported_as(name))
    except Exception as error:  # whatever an import may raise
        return PackageState(name, version, bounds, f"cannot be imported: {_sentence(error)}")
    return PackageState(name, version, bounds, "")


def _sentence(error: BaseException) -> str:
    return f"{type(error).__name__}: {str(error).strip() or 'no message'}".splitlines()[0][:200]


def _kernels() -> KernelState:
    """Loads the kernels and holds each instruction set to the definition at postures of one arm."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    try:
        from . import _kernels as kernels

        used, offered = kernels.instruction_set(), tuple(kernels.instruction_sets())
        difference = max(_difference(name) for name in offered)
    except Exception as error:  # a kernel that does not load or run is what is looked for
        return KernelState("", (), processors, None, 0, _sentence(error))
    good = difference <= TOLERANCE
    fault = "" if good else f"a Jacobian differs from the definition by {difference:.2g} (relative); reinstall kinestatics"
    return KernelState(used, offered, processors, difference, _POSTURES, fault)


def _difference(instruction_set: str) -> float:
    """Largest deviation of the kernel's Jacobians from the definition's, relative to the largest entry."""
    import numpy as np

    from . import _kernels as kernels, definition
    from .evaluator import Evaluator
    from .namespaces import as_array
    from .robots.loading import load

    arm = load("ur5e")
    q, xp = as_array(arm.random_configurations(_POSTURES, 0))
    base, tip = arm.link("base"), arm.link("tip")
    expected = definition.jacobian(arm, q, definition.Target(tip, base, tip, (0.0, 0.0, 0.0)), xp)
    with kernels.use(instruction_set):
        found = Evaluator(arm).jacobian(q)
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def _can_open_browser() -> bool:
    import webbrowser

    try:
        webbrowser.get()
    except webbrowser.Error:
        return False
    return True
