"""Certificates of random boxes, judged: `python benchmarks/certificates.py --markdown benchmarks/certificates.md`.

Boxes of ±0.05 rad (and ±0.05 m where a joint slides) around random postures. Every "free" is put before a judge that knows
no formula: singular values of the numeric Jacobian at random points of the box, and from the lowest of these steps towards
σ_min = 0 inside the box. Where it arrives, "free" was false. That the judge sees is shown by the boxes called singular.
"Decided" counts boxes where the product of singular values at the centre exceeds 5 % of the greatest of 20,000 postures.
CPU time of `certify_free` alone, warm.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import kinestatics as ks
from kinestatics.spatial import LINEAR_ROWS

ROOT = Path(__file__).parents[1]
NAMES = ("ur5e", "puma_560", "panda", "iiwa_14", "stanford_arm", "fanuc_crx10ia_l")
HALF, SHARE, ZERO = 0.05, 0.05, 1e-9
POSTURES, SAMPLES, STARTS, STEPS = 20_000, 200, 10, 40
AT_ONCE = 100


@dataclass(frozen=True)
class Judge:
    """Singular values of the rows in play of the numeric Jacobian, radians in reaches."""

    arm: ks.RobotModel
    rows: list[int]
    rank: int
    weights: np.ndarray

    @classmethod
    def of(cls, found: Any) -> Judge:
        """The judge of a robot."""
        rows = list(found.task.rows)
        reach = float(np.abs(ks.jacobian(found.model, found.space.random(500, seed=1)).array[:, list(LINEAR_ROWS)]).max())
        return cls(found.model, rows, found.task.rank, np.array([1.0 if r in LINEAR_ROWS else reach for r in rows]))

    def rows_at(self, q: np.ndarray) -> np.ndarray:
        """(..., rows, n)."""
        return self.weights[:, None] * ks.jacobian(self.arm, q).array[..., self.rows, :]

    def product(self, q: np.ndarray) -> np.ndarray:
        """(...) the product of the singular values: |det J| where J is square, √det J Jᵀ else."""
        return np.prod(np.linalg.svd(self.rows_at(q), compute_uv=False)[..., : self.rank], axis=-1)

    def least(self, q: np.ndarray) -> np.ndarray:
        """(...) the smallest singular value over the largest."""
        sigma = np.linalg.svd(self.rows_at(q), compute_uv=False)
        return sigma[..., self.rank - 1] / sigma[..., 0]

    def lowest(self, centres: np.ndarray, seed: int) -> np.ndarray:
        """(boxes) the lowest relative singular value found in each box around a centre."""
        rng = np.random.default_rng(seed)
        found = [self._lowest(centres[k : k + AT_ONCE], rng) for k in range(0, len(centres), AT_ONCE)]
        return np.concatenate(found) if found else np.zeros(0)

    def _lowest(self, centres: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        points = centres[:, None] + rng.uniform(-HALF, HALF, (len(centres), SAMPLES, centres.shape[1]))
        values = self.least(points)
        order = np.argsort(values, axis=1)[:, :STARTS]
        q = np.take_along_axis(points, order[..., None], axis=1)
        best = values.min(axis=1)
        for _ in range(STEPS):
            q = np.clip(q - self._step(q, centres[:, None]), centres[:, None] - HALF, centres[:, None] + HALF)
            best = np.minimum(best, self.least(q).min(axis=1))
        return best

    def _step(self, q: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """σ ∇σ / |∇σ|² with ∇σ = uᵀ (∂J/∂q) v by central differences; joints at an end that would leave are held."""
        U, sigma, V = np.linalg.svd(self.rows_at(q), full_matrices=False)
        u, v, h = U[..., self.rank - 1], V[..., self.rank - 1, :], 1e-6
        slopes = np.empty(q.shape)
        for j in range(q.shape[-1]):
            step = np.zeros(q.shape[-1])
            step[j] = h
            change = (self.rows_at(q + step) - self.rows_at(q - step)) / (2 * h)
            slopes[..., j] = np.einsum("...i,...ij,...j->...", u, change, v)
        outwards = ((q >= centre + HALF) & (slopes < 0)) | ((q <= centre - HALF) & (slopes > 0))
        slopes = np.where(outwards, 0.0, slopes)
        size = (slopes * slopes).sum(axis=-1)
        return (sigma[..., self.rank - 1] / np.maximum(size, 1e-12))[..., None] * slopes


def arm_of(name: str) -> ks.RobotModel:
    """A robot of the catalogue, or of the tests' golden file."""
    if name in ks.catalogue_names():
        return ks.load(name)
    sys.path.insert(0, str(ROOT / "tests"))
    from singular_robots import ROBOTS, numeric

    return numeric(ROBOTS[name])


def row(name: str, boxes: int, seed: int) -> tuple[str, int]:
    """One line of the table, and how many "free" were false."""
    found = ks.singularities(arm_of(name))
    judge, centres = Judge.of(found), found.space.random(boxes, seed=100 + seed)
    found.certify_free((centres[0] - HALF, centres[0] + HALF))
    times, verdicts = np.zeros(boxes), []
    for k, centre in enumerate(centres):
        began = time.process_time()
        verdicts.append(found.certify_free((centre - HALF, centre + HALF)).verdict)
        times[k] = time.process_time() - began
    told = np.array(verdicts)
    size = judge.product(centres)
    large = size > SHARE * judge.product(found.space.random(POSTURES, seed=seed)).max()
    lowest = judge.lowest(centres, seed)
    false = int((lowest[told == "free"] < ZERO).sum())
    seen = int((lowest[told == "singular"] < ZERO).sum())
    counts = [int((told == verdict).sum()) for verdict in ("free", "singular", "undecided")]
    decided = 100.0 * float((told[large] != "undecided").mean())
    median, high, most = (1e3 * float(x) for x in (np.median(times), np.percentile(times, 95), times.max()))
    cells = (
        name,
        str(found.model.n),
        *map(str, counts),
        str(false),
        f"{seen} of {counts[1]}",
        f"{decided:.2f} % of {int(large.sum())}",
        f"{100.0 * (1.0 - counts[2] / boxes):.2f} %",
        f"{median:.2f}",
        f"{high:.2f}",
        f"{most:.1f}",
    )
    return "| " + " | ".join(cells) + " |", false


def table(names: tuple[str, ...], boxes: int, seed: int) -> Iterator[tuple[str, int]]:
    """The lines of the table, each with its count of false "free"."""
    head = ("robot", "joints", "free", "singular", "undecided", "false free", "singular that the judge sees")
    head += ("decided where large", "decided", "median CPU ms", "95 % CPU ms", "most CPU ms")
    yield "| " + " | ".join(head) + " |", 0
    yield "|" + "---|" * len(head), 0
    for name in names:
        yield row(name, boxes, seed)


def main() -> None:
    """Parse, measure, print; ends with 1 where a "free" was false."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--boxes", type=int, default=1000, help="of each robot")
    parser.add_argument("--robots", default=",".join(NAMES))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    lines, false = [], 0
    for line, wrong in table(tuple(arguments.robots.split(",")), arguments.boxes, arguments.seed):
        print(line, flush=True)
        lines.append(line)
        false += wrong
    if arguments.markdown:
        versions = f"Python {platform.python_version()}, NumPy {np.__version__}, {time.strftime('%Y-%m-%d')}"
        about = __doc__.split("\n", 2)[2].strip()
        parts = (f"# Certificates of {arguments.boxes} random boxes a robot", about, versions, "\n".join(lines))
        arguments.markdown.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    sys.exit(1 if false else 0)


if __name__ == "__main__":
    main()
