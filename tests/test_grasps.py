"""Grasps: worked examples, theorems with their limits, independent judges, array libraries, and mistakes."""

import json
import pickle
import sys

import numpy as np
import pytest
import scipy.optimize

import kinestatics as ks

OBJECT = ks.Frame.body("object")
GRAVITY = 9.81


def pinch(friction, half=0.04, torsion=None):
    """Two fingers against each other along x."""
    places = [((half, 0, 0), (-1, 0, 0)), ((-half, 0, 0), (1, 0, 0))]
    if torsion is None:
        return [ks.Contact.with_friction(p, n, friction) for p, n in places]
    return [ks.Contact.soft(p, n, friction, torsion) for p, n in places]


def push(*pairs):
    """Frictionless contacts in the plane: ((x, y), (nx, ny)), ..."""
    return [ks.Contact.frictionless((*p, 0), (*n, 0)) for p, n in pairs]


def windmill(offset):
    """Four frictionless fingers on a square of 2 m, each beside the middle of its side."""
    return push(((1, offset), (-1, 0)), ((-1, -offset), (1, 0)), ((offset, 1), (0, -1)), ((-offset, -1), (0, 1)))


def weight(mass, point=(0.0, 0.0, 0.0)):
    return ks.Wrench.on_robot(force=(0, 0, -mass * GRAVITY), frame=ks.Frame("object", "object", point))


def closed(contacts, rows="full"):
    return ks.force_closure(contacts, rows=rows, accuracy=None).closed


# the grasp matrix


def test_box_held_by_two_soft_fingers():
    """MLS example 5.2: G of two soft fingers at y = -r and y = r, in their contact axes, at symbols."""
    sympy = pytest.importorskip("sympy")
    r, mu, gamma = sympy.symbols("r mu gamma", positive=True)
    first = ks.Contact([0, -r, 0], [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "soft", mu, gamma)
    second = ks.Contact([0, r, 0], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "soft", mu, gamma)
    expected = [
        [0, 1, 0, 0, 1, 0, 0, 0],
        [0, 0, 1, 0, 0, 0, -1, 0],
        [1, 0, 0, 0, 0, 1, 0, 0],
        [-r, 0, 0, 0, 0, r, 0, 0],
        [0, 0, 0, 1, 0, 0, 0, -1],
        [0, r, 0, 0, -r, 0, 0, 0],
    ]
    G = ks.grasp_matrix([first, second])
    assert sympy.simplify(sympy.Matrix(G) - sympy.Matrix(expected)) == sympy.zeros(6, 8)
    assert str(first) == "soft contact with friction mu, torsion gamma m at (0, -r, 0) m, inward normal (0, 1, 0)"
    assert json.dumps(first.to_dict())
    values = {r: 0.05, mu: 0.5, gamma: 0.01}
    numbers = [
        ks.Contact([0, y, 0], c.rotation, "soft", values[mu], values[gamma]) for y, c in ((-0.05, first), (0.05, second))
    ]
    np.testing.assert_allclose(ks.grasp_matrix(numbers), np.array(sympy.Matrix(G).subs(values), dtype=float))


@pytest.mark.parametrize(
    ("contact", "basis"),
    [
        (ks.Contact.frictionless((0, 0, 0), (0, 0, 1)), [[2]]),
        (ks.Contact.with_friction((0, 0, 0), (0, 0, 1), 0.5), [[0], [1], [2]]),
        (ks.Contact.soft((0, 0, 0), (0, 0, 1), 0.5, 0.01), [[0], [1], [2], [5]]),
    ],
    ids=["frictionless", "friction", "soft"],
)
def test_wrench_bases(contact, basis):
    """MLS table 5.2: what each kind transmits."""
    assert np.argwhere(contact.wrench_basis.T)[:, 1:].tolist() == basis
    assert len(contact.components) == len(basis)
    np.testing.assert_array_equal(ks.grasp_matrix([contact]), contact.wrench_basis)


@pytest.mark.parametrize("normal", [*np.vstack([np.eye(3), -np.eye(3)]), (1e-200, 0, 1), (3e200, -4e200, 0), (1, 2, -3)])
def test_contact_axes(normal):
    """A rotation with the normal as its third axis and a level first axis, for normals of any size."""
    R = ks.Contact.frictionless((0, 0, 0), normal).rotation
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-15)
    assert np.linalg.det(R) == pytest.approx(1)
    unit = np.array(normal) / np.max(np.abs(normal))
    np.testing.assert_allclose(R[:, 2], unit / np.linalg.norm(unit), atol=1e-15)
    assert R[2, 0] == 0
    assert R[2, 1] >= 0 or abs(R[2, 2]) == 1


def test_symbolic_normals():
    """A normal at an angle has its tangent in the plane; the pole is recognized."""
    sympy = pytest.importorskip("sympy")
    a, u, v = sympy.symbols("a u v", real=True)
    R = ks.Contact.frictionless([0, 0, 0], [sympy.cos(a), sympy.sin(a), 0]).rotation
    assert sympy.Matrix(R) == sympy.Matrix([[-sympy.sin(a), 0, sympy.cos(a)], [sympy.cos(a), 0, sympy.sin(a)], [0, 1, 0]])
    R = ks.Contact.frictionless([0, 0, 0], [0 * u, 0, -sympy.Symbol("h", positive=True)]).rotation
    assert sympy.Matrix(R) == sympy.diag(1, -1, -1)
    general = np.array([u, v, sympy.Integer(1)], dtype=object)
    R = sympy.lambdify((u, v), sympy.Matrix(ks.Contact.frictionless([0, 0, 0], general).rotation))(0.3, -0.8)
    np.testing.assert_allclose(R, ks.Contact.frictionless((0, 0, 0), (0.3, -0.8, 1)).rotation, atol=1e-15)
    with pytest.raises(ks.ConfigurationError, match="KS371"):
        ks.Contact.frictionless([0, 0, 0], [u - u, 0 * v, 0 * u])


@pytest.mark.parametrize("library", ["jax", "torch"])
def test_other_libraries(library):
    """The same numbers, and derivatives, from JAX and PyTorch."""
    rng = np.random.default_rng(0)
    positions, normals, x = rng.normal(size=(2, 3)), rng.normal(size=(2, 3)), rng.normal(size=7)

    def net(p, n, forces):
        contacts = [ks.Contact.with_friction(p[0], n[0], 0.5), ks.Contact.soft(p[1], n[1], 0.5, 0.1)]
        return ks.contact_wrench(contacts, forces).array

    expected = net(positions, normals, x)
    if library == "jax":
        jax = pytest.importorskip("jax")
        arguments = [jax.numpy.asarray(a) for a in (positions, normals, x)]
        both = jax.jit(lambda *given: (net(*given), jax.jacobian(net, argnums=1)(*given)))
        found, slope = both(*arguments)
        _, at_pole = both(arguments[0], jax.numpy.asarray(np.eye(3)[[2, 2]]), arguments[2])
        assert np.isfinite(at_pole).all()
    else:
        torch = pytest.importorskip("torch")
        found = net(*(torch.tensor(a) for a in (positions, normals, x)))
        slope = torch.autograd.functional.jacobian(lambda n: net(torch.tensor(positions), n, x), torch.tensor(normals))
    tolerance = 1e-5 if str(found.dtype).endswith("32") else 1e-12
    np.testing.assert_allclose(np.asarray(found), expected, atol=tolerance)
    step = 1e-6 * np.eye(6).reshape(6, 2, 3)
    rates = [(net(positions, normals + e, x) - net(positions, normals - e, x)) / 2e-6 for e in step]
    np.testing.assert_allclose(np.asarray(slope).reshape(6, 6).T, rates, atol=1e-3 if tolerance > 1e-6 else 1e-7)


def test_batches():
    """Batch axes of positions, normals and forces go together."""
    rng = np.random.default_rng(1)
    p, n, x = rng.normal(size=(4, 1, 3)), rng.normal(size=(5, 3)), rng.normal(size=(4, 5, 4))
    contacts = [ks.Contact.with_friction(p, n, 0.5), ks.Contact.frictionless((1, 0, 0), (-1, 0, 0))]
    G, w = ks.grasp_matrix(contacts), ks.contact_wrench(contacts, x)
    assert G.shape == (4, 5, 6, 4)
    for i, j in np.ndindex(4, 5):
        one = [ks.Contact.with_friction(p[i, 0], n[j], 0.5), contacts[1]]
        np.testing.assert_array_equal(G[i, j], ks.grasp_matrix(one))
        np.testing.assert_allclose(w.array[i, j], ks.contact_wrench(one, x[i, j]).array, atol=1e-14)
    assert ks.grasp_matrix([ks.Contact.frictionless(np.zeros((0, 3)), (0, 0, 1))]).shape == (0, 6, 1)
    assert str(contacts[0]) == "contact with friction 0.5, batch of shape (4, 5)"


# closure


@pytest.mark.parametrize("friction", [1e-3, 0.3, 5.0])
@pytest.mark.parametrize("torsion", [1e-4, 0.02])
def test_two_soft_fingers_close(friction, torsion):
    """Two soft fingers against each other close whatever their friction; two hard ones leave a couple (MLS section 5.3)."""
    assert closed(pinch(friction, torsion=torsion))
    found = ks.force_closure(pinch(friction), length=0.04)
    assert (found.closed, found.rank, found.margin) == (False, 5, 0.0)
    np.testing.assert_allclose(np.abs(scaled := found.unresisted.array), [0, 0, 0, 0.04, 0, 0], atol=1e-12)
    assert ks.grasp_equilibrium(pinch(friction), ks.Wrench.on_robot(scaled[:3], scaled[3:], OBJECT)).held == 0


@pytest.mark.parametrize("beyond", [-1e-2, -1e-5, -1e-7, 1e-7, 1e-5, 1e-2])
@pytest.mark.parametrize("soft", [False, True], ids=["planar", "soft"])
def test_antipodal_limit(beyond, soft):
    """Two fingers close when the line between them is within both cones: to 1e-7 rad (Nguyen 1988; MLS section 5.4)."""
    angle = np.arctan(0.5) + beyond  # between the second normal and the line
    tilted = (-np.cos(angle), np.sin(angle), 0)
    if soft:
        contacts = [ks.Contact.soft((-1, 0, 0), (1, 0, 0), 0.5, 0.1), ks.Contact.soft((1, 0, 0), tilted, 0.5, 0.1)]
    else:
        contacts = [ks.Contact.with_friction((-1, 0, 0), (1, 0, 0), 0.5), ks.Contact.with_friction((1, 0, 0), tilted, 0.5)]
    assert closed(contacts, "full" if soft else "planar") == (beyond < 0)
    if not soft:
        assert (ks.force_closure(contacts, rows="planar").margin > 0) == (beyond < 0)


@pytest.mark.parametrize("offset", [0.1, 0.3, -0.5])
def test_four_fingers_around_a_square(offset):
    """Beside the middles of the sides they close, with the margin worked out by hand; in the middles they do not."""
    found = ks.force_closure(windmill(offset), rows="planar")
    assert found.closed
    # wrenches (-1, 0, o), (1, 0, o), (0, -1, -o), (0, 1, -o): a tetrahedron; a face has the normal (0, 2 o, 1)
    assert found.margin == pytest.approx(abs(offset) / np.sqrt(1 + 4 * offset**2), rel=1e-9)
    assert found.margin_at_most == pytest.approx(found.margin, rel=1e-9)
    still = ks.force_closure(windmill(0.0), rows="planar")
    assert (still.closed, still.rank) == (False, 2)
    np.testing.assert_allclose(np.abs(still.escape.array), [0, 0, 0, 0, 0, 1], atol=1e-12)


@pytest.mark.parametrize(("friction", "length"), [(0.2, 1.0), (0.5, 1.0), (1.3, 1.0), (0.5, 0.5)])
def test_margin_of_a_planar_pinch(friction, length):
    """By hand, for fingers 2 m apart and L = 1 m: wrenches (∓1, ±μ, ±μ) span a tetrahedron μ / √(μ² + 2) around 0."""
    found = ks.force_closure(pinch(friction, half=length), rows="planar", length=length)
    assert found.margin == pytest.approx(friction / np.sqrt(friction**2 + 2), rel=1e-6)
    assert found.margin_at_most == pytest.approx(found.margin, rel=1e-6)


@pytest.mark.parametrize("torsion", [0.05, 0.2, 0.6])
def test_margin_of_a_soft_pinch(torsion):
    """By hand: the lesser of γ and μ / √(μ² + 2), for fingers 2 m apart and a length of 1 m; the bounds enclose it."""
    found = ks.force_closure(pinch(0.5, half=1.0, torsion=torsion), accuracy=0.03)
    expected = min(torsion, 0.5 / np.sqrt(0.5**2 + 2))
    assert found.margin <= expected * (1 + 1e-9)
    assert found.margin_at_most >= expected * (1 - 1e-9)
    assert found.margin >= 0.97 * found.margin_at_most


def test_margin_by_sampling():
    """No direction has less reach than the lower bound; the best of many has little more than the upper one."""
    rng = np.random.default_rng(2)
    places = rng.normal(size=(4, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    contacts = [ks.Contact.with_friction(p, -p, 0.7) for p in places]
    found = ks.force_closure(contacts)
    assert found.closed
    V = rng.normal(size=(200_000, 6))
    V /= np.linalg.norm(V, axis=1)[:, None]
    for _ in range(4):  # around the best directions so far
        reach = np.max([_reach(c, V) for c in contacts], axis=0)
        best = V[np.argsort(reach)[:20]]
        V = np.concatenate([best, (best[:, None] + 0.03 * rng.normal(size=(20, 5000, 6))).reshape(-1, 6)])
        V /= np.linalg.norm(V, axis=1)[:, None]
    least = np.max([_reach(c, V) for c in contacts], axis=0).min()
    assert found.margin * (1 - 1e-9) <= least
    assert found.margin_at_most <= least * 1.02
    assert found.margin >= 0.99 * found.margin_at_most


def _reach(contact, V):
    at = (V[:, :3] + np.cross(V[:, 3:], contact.position)) @ contact.rotation
    return at[:, 2] + contact.friction * np.hypot(at[:, 0], at[:, 1])


def random_pushes(rng, count, planar):
    flat = np.array([1, 1, 0]) if planar else np.ones(3)
    return [ks.Contact.frictionless(rng.normal(size=3) * flat, rng.normal(size=3) * flat) for _ in range(count)]


@pytest.mark.parametrize(
    ("planar", "count", "chance"),
    [(True, 3, 0), (True, 4, 1 / 8), (True, 6, 1 / 2), (False, 6, 0), (False, 7, 1 / 64), (False, 12, 1 / 2)],
)
def test_how_many_frictionless_fingers(planar, count, chance):
    """Closure takes one more than the rows (Somov, Lakshminarayana); beyond it random ones close as often as Wendel's
    theorem says: N random vectors in d dimensions fail to surround 0 with probability 2^(1 - N) Σ_{k < d} C(N - 1, k)."""
    rng, tries = np.random.default_rng(3), 160
    number = sum(closed(random_pushes(rng, count, planar), "planar" if planar else "full") for _ in range(tries))
    spread = np.sqrt(tries * chance * (1 - chance))
    assert abs(number - tries * chance) <= 3.5 * spread
    assert number > 0 or chance == 0


def test_surfaces_that_frictionless_fingers_never_hold():
    """A sphere turns about its centre; a body of revolution about its axis (exceptional surfaces, MLS section 5.4)."""
    rng = np.random.default_rng(4)
    directions = rng.normal(size=(20, 3))
    sphere = ks.force_closure([ks.Contact.frictionless(d / np.linalg.norm(d), -d) for d in directions])
    assert (sphere.closed, sphere.rank) == (False, 3)
    cone = [ks.Contact.frictionless((x, y, z), (-x, -y, (x * x + y * y) * s)) for x, y, z in directions for s in (1, -1)]
    turned = ks.force_closure(cone)
    assert (turned.closed, turned.rank) == (False, 5)
    np.testing.assert_allclose(np.abs(turned.escape.array), [0, 0, 0, 0, 0, 1], atol=1e-9)
    assert closed([ks.Contact.soft(c.position, c.normal, 0.1, 0.0) for c in cone])


def test_contacts_without_friction_by_value():
    """Friction of 0 is no friction, whatever the kind; torsion alone is some."""
    for kind in ("friction", "soft"):
        contacts = [ks.Contact(c.position, c.rotation, kind, 0.0, 0.0) for c in windmill(0.3)]
        assert closed(contacts, "planar")
        assert not closed([ks.Contact(c.position, c.rotation, kind, 0.0, 0.0) for c in pinch(0.5)], "planar")
    assert ks.force_closure([ks.Contact.soft((0, 0, 0), (0, 0, 1), 0.0, 0.1)]).rank == 2


def test_chosen_rows():
    """Two fingers close in forces alone; one row is a matter of signs; rows may be arrays."""
    assert closed(pinch(0.5), (0, 1, 2))
    assert closed(pinch(0.5), np.array([0]))
    assert not closed(pinch(0.5)[:1], [0])
    assert ks.force_closure(pinch(0.5), rows=[0]).margin == pytest.approx(1.0)


def test_closure_prints_and_tells():
    """Text of at most 80 columns, plain data, and the same object after pickling."""
    for found in (
        ks.force_closure(pinch(0.5, torsion=0.01)),
        ks.force_closure(pinch(0.5)),
        ks.force_closure(windmill(0.2), rows="planar"),
    ):
        text = str(found)
        assert max(map(len, text.splitlines())) <= 80
        assert text.startswith("force closure")
        assert json.loads(json.dumps(found.to_dict()))["closed"] == found.closed
        assert str(pickle.loads(pickle.dumps(found))) == text
    assert ks.force_closure(pinch(0.5, torsion=0.01), accuracy=None).margin is None


# equilibrium


@pytest.mark.parametrize("friction", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("minimize", ["largest", "total"])
def test_box_between_two_fingers(friction, minimize):
    """Each presses with m g / (2 μ), and all friction is used; a safety factor of 2 takes twice as much, and half of it."""
    found = ks.grasp_equilibrium(pinch(friction), weight(1.0), minimize=minimize)
    assert found.feasible
    np.testing.assert_allclose(found.normal, GRAVITY / (2 * friction))
    np.testing.assert_allclose(found.friction_used, 1.0)
    assert "about to slip: contacts[0], contacts[1]" in found.reason
    safe = ks.grasp_equilibrium(pinch(friction), weight(1.0), minimize=minimize, safety=2.0)
    np.testing.assert_allclose(safe.normal, GRAVITY / friction)
    np.testing.assert_allclose(safe.friction_used, 0.5)
    assert "slip" not in safe.reason


def test_limit_of_force():
    """Fingers of 5 N hold the share that they can, and the result says which are at their limit."""
    found = ks.grasp_equilibrium(pinch(0.5), weight(1.0), limit=5)
    assert not found.feasible
    assert found.held == pytest.approx(5 / GRAVITY)
    np.testing.assert_allclose(found.normal, 5)
    np.testing.assert_allclose(found.missing.force, [0, 0, GRAVITY - 5], atol=1e-12)
    assert "contacts[0], contacts[1]" in found.reason
    assert ks.grasp_equilibrium(pinch(0.5), weight(1.0), limit=GRAVITY).feasible
    one = ks.grasp_equilibrium(pinch(0.5), weight(1.0), limit=[np.inf, 4.0])
    assert one.held == pytest.approx(4 / GRAVITY)
    assert "at the limit of normal force: contacts[1];" in one.reason
    assert one.to_dict()["limit"] == [None, 4.0]


def test_weight_beside_the_line_of_fingers():
    """Two soft fingers take m g d by torsion, γ N each, by hand; hard fingers cannot, and lack just that couple."""
    d, friction, torsion = 0.01, 0.5, 0.004
    found = ks.grasp_equilibrium(pinch(friction, torsion=torsion), weight(0.4, (0, d, 0)))
    np.testing.assert_allclose(found.normal, 0.4 * GRAVITY * d / (2 * torsion))
    np.testing.assert_allclose(found.torsion_used, 1)
    np.testing.assert_allclose(found.friction_used, 2 * torsion / d)
    hard = ks.grasp_equilibrium(pinch(friction), weight(0.4, (0, d, 0)))
    assert (hard.feasible, hard.held) == (False, 0.0)
    np.testing.assert_allclose(hard.missing.array, [0, 0, 0, 0.4 * GRAVITY * d, 0, 0], atol=1e-9)
    assert "mx 0.0392" in hard.reason
    straight = ks.grasp_equilibrium(pinch(friction, torsion=torsion), weight(0.4))
    np.testing.assert_allclose(straight.torsion_used, 0, atol=1e-9)


def test_block_on_a_slope():
    """One contact with friction holds a weight up to the angle of friction, exactly."""
    for beyond in (-1e-7, 1e-7):
        angle = np.arctan(0.5) + beyond
        ground = [ks.Contact.with_friction((0, 0, 0), (0, 0, 1), 0.5)]
        down = ks.Wrench.on_robot(force=(np.sin(angle), 0, -np.cos(angle)), frame=OBJECT)
        found = ks.grasp_equilibrium(ground, down)
        assert found.feasible == (beyond < 0)
        np.testing.assert_allclose(found.normal, np.cos(angle), rtol=1e-6)


def test_three_fingers_around_a_glass():
    """They share its weight: m g / (3 μ) each, whichever sum is minimized."""
    angles = np.arange(3) * 2 * np.pi / 3
    around = [(np.cos(a), np.sin(a), 0.0) for a in angles]
    contacts = [ks.Contact.with_friction(0.03 * np.array(d), -np.array(d), 0.4) for d in around]
    for minimize in ("largest", "total"):
        found = ks.grasp_equilibrium(contacts, weight(0.3), minimize=minimize)
        np.testing.assert_allclose(found.normal, 0.3 * GRAVITY / (3 * 0.4), rtol=1e-6)


def polygon_program(contacts, wanted, edges, outside, minimize):
    """The least force with cones of many flat faces, within the round ones or around them: a judge from either side."""
    widen = 1 / np.cos(np.pi / edges) if outside else 1.0
    angles = 2 * np.pi * (np.arange(edges) + 0.37) / edges
    columns, owners = [], []
    for k, c in enumerate(contacts):
        for a in angles:
            for m in (c.torsion, -c.torsion) if c.torsion else (0.0,):
                f = c.rotation @ [widen * c.friction * np.cos(a), widen * c.friction * np.sin(a), 1.0]
                columns.append(np.r_[f, m * c.normal + np.cross(c.position, f)])
                owners.append(k)
    A = np.array(columns).T
    n, K = len(contacts), len(owners)
    by_contact = (np.array(owners) == np.arange(n)[:, None]).astype(float)
    total = minimize == "total"
    cost = np.r_[np.ones(K) if total else np.zeros(K), 0.0 if total else 1.0]
    found = scipy.optimize.linprog(
        cost,
        A_ub=np.hstack([by_contact, -np.ones((n, 1))]),
        b_ub=np.zeros(n),
        A_eq=np.hstack([A, np.zeros((6, 1))]),
        b_eq=wanted,
    )
    return found.fun if found.status == 0 else np.inf


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("minimize", ["largest", "total"])
def test_least_force_against_flat_cones(seed, minimize):
    """Between the least forces of 120-sided cones outside and inside the round ones, which differ by little."""
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(5, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    contacts = [ks.Contact.with_friction(p, -p, 0.6) for p in places[:3]]
    contacts += [ks.Contact.soft(p, -p, 0.4, 0.1) for p in places[3:]]
    wanted = rng.normal(size=6)
    load = ks.Wrench.on_environment(wanted[:3], wanted[3:], OBJECT)
    found = ks.grasp_equilibrium(contacts, load, minimize=minimize)
    least = (found.normal.sum() if minimize == "total" else found.normal.max()) if found.feasible else np.inf
    inside, outside = (polygon_program(contacts, wanted, 120, side, minimize) for side in (False, True))
    assert outside * (1 - 1e-6) <= least <= inside * (1 + 1e-6)
    if np.isfinite(inside):
        assert inside / outside < 1.01


def test_the_signs_of_loads():
    """What acts on the hand is carried by its opposite; what the hand is to exert is exerted; joint_torques agrees."""
    up = ks.Wrench.on_environment(force=(0, 0, GRAVITY), frame=OBJECT)
    carried, exerted = (ks.grasp_equilibrium(pinch(0.5), w) for w in (weight(1.0), up))
    np.testing.assert_allclose(carried.forces, exerted.forces)
    net = ks.contact_wrench(pinch(0.5), carried.stacked)
    np.testing.assert_allclose(net.array, [0, 0, GRAVITY, 0, 0, 0], atol=1e-12)
    assert net.acts_on == "environment"
    total = np.zeros(6)
    for contact, wrench in zip(pinch(0.5), carried.wrenches, strict=True):
        assert wrench.frame == ks.Frame("object", "object", tuple(contact.position))
        assert wrench.acts_on == "environment"
        total += np.r_[wrench.force, wrench.torque + np.cross(contact.position, wrench.force)]
    np.testing.assert_allclose(total, net.array, atol=1e-12)


def test_no_load():
    """Nothing to hold takes nothing; rows that are left out need no balance."""
    nothing = ks.grasp_equilibrium(pinch(0.5), ks.Wrench.on_robot(frame=OBJECT))
    assert nothing.feasible
    assert not nothing.forces.any()
    assert ks.grasp_equilibrium(pinch(0.5), weight(1.0), rows="planar").normal.max() == 0
    assert not ks.grasp_equilibrium(windmill(0.3), ks.Wrench.on_robot(force=(0, 0, -1), frame=OBJECT)).feasible
    torque = ks.Wrench.on_robot(torque=(0, 0, 1), frame=OBJECT)
    assert ks.grasp_equilibrium(windmill(0.3), torque, rows="planar").feasible


def test_equilibrium_prints_and_tells():
    """Text of at most 80 columns, plain data, and the same object after pickling."""
    for contacts, limit in ((pinch(0.5), None), (pinch(0.5), 3), (pinch(0.5)[:1], None), (windmill(0.2), 10)):
        found = ks.grasp_equilibrium(contacts, weight(1.0, (0, 0.01, 0)), limit=limit)
        text = str(found)
        assert max(map(len, text.splitlines())) <= 80
        assert text.count("contacts[") >= len(contacts)
        assert json.loads(json.dumps(found.to_dict()))["held"] == found.held
        assert str(pickle.loads(pickle.dumps(found))) == text


# mistakes


@pytest.mark.parametrize(
    ("code", "call"),
    [
        ("KS370", lambda: ks.Contact((0, 0, 0), np.eye(3), "sticky")),
        ("KS371", lambda: ks.Contact.frictionless((0, 0, 0), (0, 0, 0))),
        ("KS371", lambda: ks.Contact((0, 0, 0), 2 * np.eye(3))),
        ("KS371", lambda: ks.Contact((0, 0, 0), np.diag([1.0, 1.0, -1.0]))),
        ("KS371", lambda: ks.Contact((0, 0, 0), np.eye(3), "frictionless", 0.5)),
        ("KS371", lambda: ks.Contact((0, 0, 0), np.eye(3), "friction", 0.5, 0.1)),
        ("KS371", lambda: ks.Contact.with_friction((0, 0, 0), (0, 0, 1), -0.5)),
        ("KS371", lambda: ks.Contact.with_friction((0, 0, 0), (0, 0, 1), np.nan)),
        ("KS371", lambda: ks.Contact.with_friction((0, 0, 0), (0, 0, 1), "rough")),
        ("KS371", lambda: ks.Contact.soft((0, 0, 0), (0, 0, 1), 0.5, [0.1, 0.2])),
        ("KS301", lambda: ks.Contact.frictionless((0, np.inf, 0), (0, 0, 1))),
        ("KS301", lambda: ks.Contact((0, 0, 0), np.full((3, 3), np.nan))),
        ("KS303", lambda: ks.Contact.frictionless((0, 0), (0, 0, 1))),
        ("KS303", lambda: ks.Contact((0, 0, 0), np.eye(4))),
        ("KS372", lambda: ks.grasp_matrix([])),
        ("KS302", lambda: ks.grasp_matrix(pinch(0.5)[0])),
        ("KS302", lambda: ks.grasp_matrix([(0, 0, 0)])),
        ("KS303", lambda: ks.contact_wrench(pinch(0.5), [1, 2, 3])),
        ("KS303", lambda: ks.grasp_matrix([ks.Contact.frictionless(np.zeros((2, 3)), np.ones((5, 3)))])),
        ("KS303", lambda: ks.grasp_matrix([ks.Contact.frictionless(np.zeros((n, 3)), (0, 0, 1)) for n in (2, 3)])),
        ("KS303", lambda: ks.force_closure([ks.Contact.frictionless(np.zeros((2, 3)), (0, 0, 1))])),
        ("KS373", lambda: ks.force_closure(pinch(0.5), rows="spatial")),
        ("KS373", lambda: ks.internal_forces(pinch(0.5), rows=(0, 0))),
        ("KS373", lambda: ks.force_closure(pinch(0.5), rows=())),
        ("KS373", lambda: ks.force_closure(pinch(0.5), rows=(0, 6))),
        ("KS374", lambda: ks.force_closure(pinch(0.5), edges=2)),
        ("KS374", lambda: ks.force_closure(pinch(0.5), accuracy=0)),
        ("KS303", lambda: ks.force_closure(pinch(0.5), length=0)),
        ("KS303", lambda: ks.internal_forces(pinch(0.5), length=np.inf)),
        ("KS330", lambda: ks.grasp_equilibrium(pinch(0.5), ks.Wrench.on_robot(force=(0, 0, -1)))),
        ("KS302", lambda: ks.grasp_equilibrium(pinch(0.5), (0, 0, -1, 0, 0, 0))),
        ("KS303", lambda: ks.grasp_equilibrium(pinch(0.5), ks.Wrench.on_robot(np.zeros((2, 3)), frame=OBJECT))),
        ("KS301", lambda: ks.grasp_equilibrium(pinch(0.5), ks.Wrench.on_robot((0, 0, np.nan), frame=OBJECT))),
        ("KS376", lambda: ks.grasp_equilibrium(pinch(0.5), weight(1), safety=0.5)),
        ("KS376", lambda: ks.grasp_equilibrium(pinch(0.5), weight(1), limit=[1, 2, 3])),
        ("KS376", lambda: ks.grasp_equilibrium(pinch(0.5), weight(1), limit=0)),
        ("KS376", lambda: ks.grasp_equilibrium(pinch(0.5), weight(1), limit="strong")),
        ("KS377", lambda: ks.grasp_equilibrium(pinch(0.5), weight(1), minimize="size")),
    ],
)
def test_mistakes(code, call):
    """Each has its code, and a remedy."""
    with pytest.raises(ks.KinestaticsError) as caught:
        call()
    assert caught.value.code == code
    assert caught.value.message


def test_symbols_where_numbers_are_needed():
    """Closure is a question to numbers; two array libraries do not go together."""
    sympy = pytest.importorskip("sympy")
    torch = pytest.importorskip("torch")
    mu = sympy.Symbol("mu", positive=True)
    for function in (ks.force_closure, ks.internal_forces):
        with pytest.raises(ks.ArrayTypeError, match="KS302"):
            function(pinch(mu))
    mixed = [
        ks.Contact.frictionless(torch.zeros(3), (0, 0, 1)),
        ks.Contact.frictionless([sympy.Symbol("x"), 0, 0], (0, 0, 1)),
    ]
    with pytest.raises(ks.ArrayTypeError, match="sympy and torch"):
        ks.grasp_matrix(mixed)


def test_without_scipy(monkeypatch):
    """The error names the command that installs it; the grasp matrix needs none."""
    for name in ("scipy", "scipy.optimize", "scipy.spatial"):
        monkeypatch.setitem(sys.modules, name, None)
    assert ks.grasp_matrix(pinch(0.5)).shape == (6, 6)
    assert len(ks.internal_forces(pinch(0.5))) == 1
    for call in (lambda: closed(pinch(0.5, torsion=0.1)), lambda: ks.grasp_equilibrium(pinch(0.5), weight(1))):
        with pytest.raises(ks.MissingExtraError, match=r"kinestatics\[grasp\]"):
            call()


def test_arguments_are_left_alone():
    """A contact keeps its own copy of what it was given."""
    place = np.array([1.0, 0, 0])
    contact = ks.Contact.frictionless(place, (-1, 0, 0))
    place[0] = 5
    assert contact.position[0] == 1
    with pytest.raises(AttributeError):
        contact.friction = 1.0
