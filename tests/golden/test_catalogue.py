"""The bundled arms against the documents they come from and against other encodings of the same arm."""

import math
import tomllib
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.robots.catalogue import catalogue_entries, exact_number

NAMES = ks.catalogue_names()
EXPECTED = {
    "planar_2r", "planar_3r", "rrp_note_000", "rrp_note_001", "three_joint_note_003", "elbow_rrr", "scara", "stanford_arm",
    "puma_560", "ur3e", "ur5e", "ur10e", "panda", "iiwa_14", "gen3", "al5d", "irb_140", "kr5",
}  # fmt: skip


def test_all_promised_arms_are_there():
    """The catalogue holds the arms it promises, each with a title and a source."""
    assert set(NAMES) == EXPECTED
    for entry in catalogue_entries():
        assert entry.title
        assert entry.source
        assert entry.joints == ks.load(entry.name).n


@pytest.mark.parametrize("name", NAMES)
def test_home_is_within_limits_and_not_singular(name):
    """Every arm's home is a posture one can work in."""
    arm = ks.load(name)
    assert np.all(arm.lower <= arm.home)
    assert np.all(arm.home <= arm.upper)
    assert not ks.analyze(arm).is_singular


@pytest.mark.parametrize("name", NAMES)
def test_every_file_names_its_sources(name):
    """Each file has sources that say what they give, and only keys that the reader knows."""
    data = tomllib.loads(
        resources.files("kinestatics.robots.catalogue").joinpath(f"{name}.toml").read_text(encoding="utf-8")
    )
    assert data["name"] == name
    assert all(source["document"] and source["gives"] for source in data["source"])
    known = {
        "name",
        "link",
        "type",
        "a",
        "alpha",
        "d",
        "theta",
        "axis",
        "point",
        "pitch",
        "lower",
        "upper",
        "velocity",
        "effort",
    }
    known |= {"home", "mass", "center_of_mass", "inertia"}
    for joint in data["joint"]:
        assert set(joint) <= known


REACH = {  # tip at zero, from the dimensions printed in the makers' documents [m]
    "ur3e": (-0.24355 - 0.2132, -0.13105 - 0.0921, 0.15185 - 0.08535),
    "ur5e": (-0.425 - 0.3922, -0.1333 - 0.0996, 0.1625 - 0.0997),
    "ur10e": (-0.6127 - 0.57155, -0.17415 - 0.11655, 0.1807 - 0.11985),
    "panda": (0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107),
    "iiwa_14": (0.0, 0.0, 0.36 + 0.42 + 0.4 + 0.126),
    "gen3": (0.0, -0.0246, 0.2848 + 0.4208 + 0.3143 + 0.1674),
    "irb_140": (0.07 + 0.38 + 0.065, 0.0, 0.352 + 0.36),
    "scara": (0.325 + 0.275, 0.0, 0.387),
    "puma_560": (0.4318 + 0.0203, -0.15005, 0.6718 + 0.4318),
    "kr5": (0.18 + 0.6 + 0.12, 0.0, 0.4 - 0.62 - 0.115),
}


@pytest.mark.parametrize("name", REACH)
def test_tip_at_zero(name):
    """At zero the tip is where the maker's dimensions put it."""
    arm = ks.load(name)
    np.testing.assert_allclose(ks.pose(arm, np.zeros(arm.n)).translation, REACH[name], atol=1e-12)


def test_spherical_arm_of_note_000():
    """tip = (c1 c2 d3, s1 c2 d3, d1 - s2 d3)."""
    q1, q2, d3 = 0.4, -0.7, 0.9
    tip = ks.pose(ks.load("rrp_note_000"), [q1, q2, d3]).translation
    expected = [math.cos(q1) * math.cos(q2) * d3, math.sin(q1) * math.cos(q2) * d3, 0.3 - math.sin(q2) * d3]
    np.testing.assert_allclose(tip, expected, atol=1e-15)


def test_load_on_the_arm_of_note_001():
    """The motor torque that holds 100 N at (0, -90 deg, 2 m) is -200 N m (erratum E001-3: not +200)."""
    J = ks.jacobian(ks.load("rrp_note_001"), [0.0, -math.pi / 2, 2.0])
    torques = ks.joint_torques(J, ks.Wrench.on_robot(force=(0, 0, -100)))
    np.testing.assert_allclose(torques, [0, -200, 0], atol=1e-12)


def test_published_limits():
    """Torque and speed limits as the makers print them."""
    panda, ur5e, iiwa = (ks.load(name) for name in ("panda", "ur5e", "iiwa_14"))
    assert panda.effort_limits.tolist() == [87.0] * 4 + [12.0] * 3
    assert panda.velocity_limits.tolist() == [2.175] * 4 + [2.61] * 3
    assert ur5e.effort_limits.tolist() == [150.0] * 3 + [28.0] * 3
    np.testing.assert_allclose(np.degrees(iiwa.velocity_limits), [85, 85, 100, 75, 130, 135, 135])


def test_numbers_of_the_data_files():
    """Multiples of pi and degrees are read exactly; anything else is refused."""
    assert exact_number("-3*pi/4") == -3 * math.pi / 4
    assert exact_number("pi") == math.pi
    assert exact_number("55 deg") == math.radians(55)
    for text in ("", "pi*", "__import__('os')", "1;2"):
        with pytest.raises((ks.RobotDefinitionError, ValueError)):
            exact_number(text)


def _wheel(package, pattern):
    import importlib.metadata

    files = importlib.metadata.files(package) or []
    return next(Path(file.locate()) for file in files if str(file).endswith(pattern))


def test_panda_agrees_with_a_urdf():
    """Panda: modified rows against the URDF of example-robot-data; that file's right angles have 11 digits."""
    other = ks.load(_wheel("example-robot-data", "panda_description/urdf/panda.urdf"), tip="panda_link8")
    arm = ks.load("panda")
    for q in arm.random_configurations(20, seed=1):
        np.testing.assert_allclose(ks.pose(arm, q).array, ks.pose(other, q).array, atol=1e-10)
        np.testing.assert_allclose(ks.jacobian(arm, q).array, ks.jacobian(other, q).array, atol=1e-10)


@pytest.mark.parametrize("name", ["ur3e", "ur5e"])
def test_universal_robots_agree_with_a_urdf(name):
    """UR e-series: the maker's rows against the URDF of airo-models, whose base is turned by 180 degrees."""
    other = ks.load(_wheel("airo-models", f"{name}/{name}.urdf"), base="base_link", tip="tool0")
    arm = ks.load(name)
    half_turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    for q in arm.random_configurations(20, seed=1):
        np.testing.assert_allclose(half_turn @ ks.pose(arm, q).array, ks.pose(other, q).array, atol=2e-9)
