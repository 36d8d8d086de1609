"""Pictures of regions, distances and sections: what they draw is what was computed, keys name it, mistakes are told."""

import numpy as np
import pytest

import kinestatics as ks
from kinestatics import plots

pytest.importorskip("matplotlib", reason="the extra plot")


def key(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def settled(ax):
    """All that is drawn is on the paper, and no two words of it overlap."""
    figure = ax.figure
    figure.draw_without_rendering()
    whole = figure.bbox.padded(1.0)
    boxes = [t.get_window_extent() for t in (ax.xaxis.label, ax.yaxis.label, *ax.get_legend().get_texts())]
    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        boxes += [tick.label1.get_window_extent() for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    visible = [b for b in boxes if b.width > 0]
    for k, box in enumerate(visible):
        assert whole.containsx(box.x0)
        assert whole.containsx(box.x1)
        assert not any(box.padded(-1.0).overlaps(other.padded(-1.0)) for other in visible[:k])
    return True


@pytest.fixture(scope="module")
def puma():
    return ks.singularities(ks.load("puma_560"))


@pytest.fixture(scope="module")
def ur5e():
    return ks.singularities(ks.load("ur5e"))


def tint(ax, x, y):
    """1, -1 or 0: in which of the two filled regions a place lies."""
    found = [c for c in ax.collections if hasattr(c, "get_paths")]
    (filled,) = [c for c in found if len(c.get_facecolor()) == 2]
    hits = [path.contains_point((x, y)) for path in filled.get_paths()]
    return -1 if hits[0] and not hits[1] else 1 if hits[1] and not hits[0] else 0


def test_regions_have_the_sign_of_the_determinant(puma):
    """At random places of the plane the colour is the sign of det J there; the curves are singular."""
    q = np.array([0.0, 0.4, -1.0, 0.3, 0.5, 0.0])
    ax = plots.aspect_regions(puma, ["joint2", "joint3"], q)
    assert key(ax) == ["det J > 0", "det J < 0", "shoulder", "elbow"]
    rng, right = np.random.default_rng(0), 0
    reference = np.linalg.det(ks.jacobian(puma.model, q).array) * puma.fourier.value(q)
    for place in rng.uniform(-3.0, 3.0, (60, 2)):
        q[1:3] = place
        det = np.linalg.det(ks.jacobian(puma.model, q, check_finite=False).array) * np.sign(reference)
        if abs(det) > 1e-3:
            assert tint(ax, *np.degrees(place)) == np.sign(det)
            right += 1
    assert right > 40
    for line in ax.lines:
        if len(line.get_xdata()) > 1:
            at = np.tile(q, (len(line.get_xdata()), 1))
            at[:, 1:3] = np.radians(np.array(line.get_data()).T)
            assert np.abs(puma.fourier.value(at)).max() < 1e-9 * puma.fourier.scale
    assert settled(ax)


def test_regions_within_two_turns_repeat(ur5e):
    """The plane of a UR5e's elbow and wrist goes from -360 to 360 degrees, with curves in every turn."""
    ax = plots.aspect_regions(ur5e, [2, 3], [0, -1, 1, 0, 1, 0], limits=True)
    assert ax.get_xlim() == pytest.approx((-360, 360))
    columns = {
        round(float(line.get_xdata()[0])) for line in ax.lines if len(line.get_xdata()) and np.ptp(line.get_xdata()) < 1e-6
    }
    assert {-360, -180, 0, 180, 360} <= columns
    with pytest.raises(ks.ConfigurationError, match="KS398"):
        plots.aspect_regions(ks.singularities(ks.load("planar_2r"), "position"), [0, 1])


def test_distances_are_those_of_the_postures(puma):
    """Lines are `distance` in degrees, in the order of the components; bands go down to the proved bounds."""
    path = np.linspace([0.0, 0.5, -1.0, 0.3, 0.6, 0.0], [0.0, 0.2, -0.4, 0.3, -0.2, 0.0], 3)
    times = [0.0, 0.5, 2.0]
    ax = plots.singular_distances(puma, path, times=times)
    assert key(ax) == ["shoulder", "elbow", "wrist"]
    assert ax.get_xlabel() == "time [s]"
    for line, band, component in zip(ax.lines, ax.collections, puma.components, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), times)
        own = [next(d for d in puma.distance(q) if d.component is component) for q in path]
        np.testing.assert_allclose(line.get_ydata(), np.degrees([d.value for d in own]), rtol=1e-9)
        rim = band.get_paths()[0].vertices
        assert rim[:, 1].min() == pytest.approx(np.degrees(min(d.at_least for d in own)), rel=1e-9, abs=1e-9)
    assert settled(ax)
    assert not plots.singular_distances(puma, path[:1], bounds=False).collections
    for bad, code in ((path[0], "KS384"), (path[:, :5], "KS384"), (path * np.nan, "KS301")):
        with pytest.raises(ks.ConfigurationError, match=code):
            plots.singular_distances(puma, bad)
    with pytest.raises(ks.ConfigurationError, match="KS385"):
        plots.singular_distances(puma, path, times=[0, 1, 1])
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        plots.singular_distances(puma.model, path)


@pytest.mark.parametrize("name", ["puma_560", "planar_3r"])
def test_sections_are_drawn_by_what_ends_them(name):
    """All pieces of the outline are drawn once, in the colour of their kind; the key says which there are."""
    section = ks.singularities(ks.load(name), "position").workspace_section(cells=16, image=60)
    ax = plots.workspace_section(section)
    words = {"barrier": "singular: a barrier", "limit": "at a joint limit"}
    assert {words[kind] for kind in set(section.kinds) - {"axis"}} <= set(key(ax))
    assert any("crossable" in word for word in key(ax)) == (name == "planar_3r")
    lines = [np.array(line.get_data()).T for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata()) > 1]
    drawn = sum(np.linalg.norm(np.diff(line, axis=0), axis=-1).sum() for line in lines)
    whole = sum(np.linalg.norm(o.points - np.roll(o.points, 1, axis=0), axis=-1).sum() for o in section.outlines)
    assert drawn == pytest.approx(whole, rel=1e-9)
    assert ax.get_aspect() == 1.0
    assert settled(ax)
    plain = plots.workspace_section(section, images=False)
    assert not any("inside" in word for word in key(plain))
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        plots.workspace_section("puma")


def test_pictures_side_by_side(puma):
    """A figure is drawn into, and axes that are given are kept."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3))
    left, right = figure.subplots(1, 2)
    assert plots.aspect_regions(puma, [1, 2], ax=left) is left
    assert plots.singular_distances(puma, np.full((1, 6), 0.4), ax=right) is right
    assert len(figure.axes) == 2
