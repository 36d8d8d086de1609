"""Sections of the workspace: nothing outside, every point reached, the conditions of a boundary, known radii, voids."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.singular_sets import singularities
from kinestatics.singular_sets.second_order import second_order


def seen(arm, q):
    """Distance from axis z of base and height, for arms whose first axis that is; none of the code under test."""
    p = ks.pose(arm, q).array[..., :3, 3]
    return np.stack([np.hypot(p[..., 0], p[..., 1]), p[..., 2]], -1)


def inside(section, places):
    """Whether places lie inside an odd number of outlines, by matplotlib."""
    path = pytest.importorskip("matplotlib.path").Path
    found = np.zeros(len(places), dtype=bool)
    for outline in section.outlines:
        found ^= path(np.vstack([outline.points, outline.points[:1]]), closed=True).contains_points(places)
    return found


def off(section, places):
    """(k) distances from the nearest piece of an outline."""
    best = np.full(len(places), np.inf)
    for outline in section.outlines:
        a, b = outline.points, np.roll(outline.points, -1, axis=0)
        for some in np.array_split(np.arange(len(places)), max(1, len(places) // 200)):
            x = places[some][:, None]
            share = np.clip(((x - a) * (b - a)).sum(-1) / np.maximum(((b - a) ** 2).sum(-1), 1e-300), 0, 1)
            best[some] = np.minimum(best[some], np.linalg.norm(a + share[..., None] * (b - a) - x, axis=-1).min(1))
    return best


@cache
def of_position(name):
    return singularities(ks.load(name), "position")


def section_and_heights(name, **options):
    """A section, and by how much its heights start above base."""
    found = of_position(name)
    section = found.workspace_section(**options)
    return found, section, np.array([0.0, section.origin[2]])


@pytest.mark.parametrize(("name", "tolerance"), [("elbow_rrr", 1e-5), ("puma_560", 1e-6), ("iiwa_14", 1e-4)])
def test_no_random_posture_is_outside_and_all_of_the_outline_is_near_one(name, tolerance):
    """200,000 postures by forward kinematics: none is beyond the pieces by more than the tolerance, some near to all."""
    found, section, above = section_and_heights(name, cells=24, tolerance=tolerance, image=0)
    assert section.settled
    q = found.model.random_configurations(200_000, seed=11)
    places = seen(found.model, q) - above
    outside = places[~inside(section, places)]
    assert off(section, outside).max(initial=0.0) <= 1.05 * tolerance * section.reach
    rim = section.points[np.array(section.kinds) != "axis"][::9]
    cells = {tuple(c) for c in np.floor(places / (0.06 * section.reach)).astype(int).tolist()}
    around = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    for i, j in np.floor(rim / (0.06 * section.reach)).astype(int).tolist():
        assert any((i + a, j + b) in cells for a, b in around)
    np.testing.assert_array_equal(section.covers(places[:5000]), inside(section, places[:5000]))


@pytest.mark.parametrize("name", ["puma_560", "ur5e"])
def test_points_are_reached_and_cannot_be_passed(name):
    """Forward kinematics gives the points; u · dw <= 0 within the limits; off them the posture is singular and a barrier."""
    found, section, above = section_and_heights(name, cells=16, image=0, tolerance=1e-4)
    arm, seen_kinds = found.model, set()
    for outline in section.outlines:
        kept = np.array(outline.kinds) != "axis"
        q, points, normals = outline.postures[kept], outline.points[kept], outline.normals[kept]
        kinds = np.array(outline.kinds)[kept]
        seen_kinds |= set(kinds.tolist())
        np.testing.assert_allclose(seen(arm, q) - above, points, atol=1e-12)
        np.testing.assert_allclose(section.place(q), points, atol=1e-12)
        assert np.all((q >= arm.lower - 1e-12) & (q <= arm.upper + 1e-12))
        p, J = ks.pose(arm, q).array[:, :3, 3], ks.jacobian(arm, q).linear
        out = np.concatenate([p[:, :2] / np.hypot(p[:, 0], p[:, 1])[:, None], np.zeros((len(p), 1))], 1)
        u = normals[:, :1] * out + normals[:, 1:] * [0.0, 0.0, 1.0]
        pull = np.einsum("kr,krj->kj", u, J) / section.reach
        assert pull[q < arm.upper - 1e-9].max() < 1e-5
        assert pull[q > arm.lower + 1e-9].min() > -1e-5
        for posture in q[kinds == "barrier"][::40]:
            second = second_order(arm, posture, found.task, tolerance=1e-5)
            assert second.rank == 2
            assert second.kind == "barrier" or not second.decided or second.self_motion
    assert seen_kinds == ({"barrier", "limit"} if name == "puma_560" else {"barrier"})


def test_radii_that_are_known():
    """Sums and differences of lengths: the elbow arm, the PUMA's shoulder offset, the UR5e's d4 - d6, the iiwa's reach."""
    _, elbow, _ = section_and_heights("elbow_rrr", cells=24, image=0)
    lengths = of_position("elbow_rrr").lengths
    a2, a3 = (float(v) for k, v in lengths.items() if str(k) in ("a2", "a3"))
    assert elbow.points.max(0) == pytest.approx([a2 + a3, a2 + a3], abs=2e-5)
    radii = np.linalg.norm(elbow.points, axis=-1)
    assert radii.min() == pytest.approx(abs(a2 - a3), abs=2e-5)
    found, ur5e, _ = section_and_heights("ur5e", cells=16, image=0, tolerance=1e-4)
    values = {str(k): float(v) for k, v in found.lengths.items()}
    assert ur5e.points[:, 0].min() == pytest.approx(values["d4"] - values["d6"], abs=1e-9)
    _, iiwa, _ = section_and_heights("iiwa_14", cells=16, image=0, tolerance=1e-4)
    assert iiwa.points[:, 1].max() == pytest.approx(0.42 + 0.4 + 0.126, abs=1e-6)


def test_the_tip_of_a_void_does_not_hang_on_the_grid():
    """The PUMA's limits leave a void that ends in a tip thinner than the cells of either grid."""
    tips = []
    for cells in (16, 40):
        _, section, _ = section_and_heights("puma_560", cells=cells, image=0, tolerance=1e-4)
        x = section.points
        tips.append(x[(x[:, 0] > 0.26) & (np.abs(x[:, 1] + 0.2) < 0.1), 1].max())
    assert tips[0] == pytest.approx(tips[1], abs=5e-3)
    assert min(tips) > -0.215


def test_a_planar_arm_has_its_plane_and_its_void():
    """Lengths 1 and 0.4: an annulus from 0.6 to 1.4, its inner rim an outline of its own; with limits a sickle."""
    arm = ks.from_dh([(1.0, 0, 0, 0), (0.4, 0, 0, 0)], convention="standard")
    section = singularities(arm, ("vx", "vy")).workspace_section(cells=24, tolerance=1e-4)
    assert section.axes == ("x", "y")
    assert [outline.encloses for outline in section.outlines] == [True, False]
    for outline, radius in zip(section.outlines, (1.4, 0.6), strict=True):
        np.testing.assert_allclose(np.linalg.norm(outline.points, axis=-1), radius, atol=1e-9)
        assert set(outline.kinds) == {"barrier"}
    (image,) = section.images
    assert set(image.kinds) == {"barrier"}
    np.testing.assert_array_equal(section.covers([[0.0, 0.0], [1.0, 0.0], [0.0, 1.5]]), [False, True, False])
    bent = replace(arm, lower=np.array([-1.0, 0.2]), upper=np.array([1.2, 2.0]))
    section = singularities(bent, ("vx", "vy")).workspace_section(cells=24, tolerance=1e-4)
    (outline,) = section.outlines
    assert set(outline.kinds) == {"limit"}
    x = outline.points
    area = 0.5 * abs(float((x[:, 0] * np.roll(x[:, 1], -1) - x[:, 1] * np.roll(x[:, 0], -1)).sum()))
    assert area == pytest.approx(2.2 * 1.0 * 0.4 * (np.cos(0.2) - np.cos(2.0)), abs=1e-3)  # ∫ |det J| dq, one to one


def test_kinds_of_images_are_those_of_the_second_order():
    """Places on the UR5e's components: the classes of the form around axis 1 and of the posture in space agree."""
    found, section, above = section_and_heights("ur5e", cells=16, image=40)
    agreed = 0
    for image in section.images:
        np.testing.assert_allclose(seen(found.model, image.postures) - above, image.points, atol=1e-12)
        for posture, kind in list(zip(image.postures, image.kinds, strict=True))[:6]:
            second = second_order(found.model, posture, found.task)
            if second.corank == 1 and second.kind in ("barrier", "crossable"):
                assert kind == second.kind
                agreed += 1
    assert agreed >= 8


def test_words_data_time_and_mistakes():
    """A section prints, is plain data, says when it was cut short; what has no section is told."""
    found = of_position("elbow_rrr")
    section = found.workspace_section(cells=16, image=20)
    assert "outline: radius 0 to 0.85 m" in str(section)
    assert max(len(line) for line in str(section).splitlines()) <= 80
    data = section.to_dict()
    assert data["axes"] == ["radius", "height"]
    assert len(data["outlines"][0]["points"]) == len(section.points)
    told = []
    cut = found.workspace_section(budget=1e-3, image=0, progress=lambda *word: told.append(word))
    assert told
    assert not cut.settled
    for options, code in (
        ({"cells": 4}, "KS303"),
        ({"tolerance": 0.0}, "KS303"),
        ({"image": -1}, "KS303"),
        ({"budget": 0}, "KS353"),
    ):
        with pytest.raises(ks.ConfigurationError, match=code):
            found.workspace_section(**options)
    with pytest.raises(ks.ConfigurationError, match="KS303"):
        section.covers([1.0, 2.0, 3.0])
    with pytest.raises(ks.ConfigurationError, match=r"(?s)KS398.*task='position'"):
        singularities(ks.load("puma_560")).workspace_section()
