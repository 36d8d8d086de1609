"""The explorer without a browser: the session, its worker, and what the page says."""

import json
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

import kinestatics as ks
from browser import wait_until
from kinestatics.explorer import explore
from kinestatics.explorer.files_tab import postures_data, read_postures
from kinestatics.explorer.joints_tab import STEP, slider_ranges
from kinestatics.explorer.session import LOAD, PUSH, Session, Situation
from kinestatics.explorer.tables import jacobian, torques, verdict
from kinestatics.explorer.words import shown_name
from kinestatics.explorer.worker import LatestWorker

REGULAR = [0.3, -1.2, 1.3, -0.6, 1.0, 0.2]


def session_of(name="ur5e", q=REGULAR, **situation):
    return Session(ks.load(name), Situation(np.array(q), **situation))


def test_session_says_what_analyze_says():
    """The page's numbers are those of `analyze`, with payload, mount and wrench."""
    session = session_of()
    session.change(force=(1.0, 2.0, -30.0), acts=PUSH, mass=2.0, center=(0.0, 0.0, 0.05), mount="wall")
    arm = ks.load("ur5e").with_payload(2.0, (0.0, 0.0, 0.05))
    wrench = ks.Wrench.on_environment(force=(1.0, 2.0, -30.0))
    a = ks.analyze(arm, REGULAR, wrench, gravity=ks.gravity_in_base("wall"))
    np.testing.assert_array_equal(session.analysis.holding_torques, a.holding_torques)
    np.testing.assert_array_equal(session.analysis.jacobian.array, a.jacobian.array)
    assert str(session.whole_analysis(singularities=False)) == str(a)


def test_brief_analysis_leaves_out_and_changes_nothing():
    """What both hold is the same; a brief one holds no abilities, payload, bearings, shares of links."""
    arm, wrench = ks.load("ur5e"), ks.Wrench.on_robot(force=(0, 0, -50))
    whole, brief = (ks.analyze(arm, REGULAR, wrench, brief=word) for word in (False, True))
    left_out = {"abilities", "speed_rows", "payload_capacity", "reactions", "gravity_by_link", "potential_energy"}
    assert whole.abilities
    assert not brief.abilities
    for key, value in brief.to_dict().items():
        if key not in left_out:
            assert value == whole.to_dict()[key], key


def test_an_arm_that_holds_something_can_hold_more():
    """The page's payload has a name of its own."""
    arm = ks.load("ur5e").with_payload(1.0)
    session = Session(arm, Situation(np.array(REGULAR)))
    session.change(mass=2.0)
    expected = ks.gravity_torques(ks.load("ur5e").with_payload(3.0), REGULAR)
    np.testing.assert_allclose(session.analysis.gravity_torques, expected, rtol=1e-12, atol=1e-12)


def test_what_is_refused_does_not_stay_in_the_boxes():
    """A load that cannot be computed with is told of, and the boxes show again what the page computes with."""
    with explore(ks.load("ur5e"), REGULAR) as explorer:
        tab = explorer.page.statics
        tab.force.value = (1e300, 0.0, 0.0)
        explorer.page.attempt(tab._asked)
        assert tab.force.value == explorer.session.situation.force == (0.0, 0.0, 0.0)
        assert "KS301" in explorer.page.verdict.content


def test_joints_stay_inside_their_limits():
    """A posture beyond the limits is brought to them."""
    session = session_of()
    session.change(q=np.full(6, 100.0))
    np.testing.assert_array_equal(session.situation.q, session.model.upper)


def test_what_fails_changes_nothing():
    """A load that cannot be computed with is refused; posture, load and answer stay."""
    session = session_of()
    before = session.analysis
    with pytest.raises(ks.ConfigurationError):
        session.change(force=(1e300, 0.0, 0.0))
    assert session.analysis is before
    assert session.situation.force == (0.0, 0.0, 0.0)
    with pytest.raises(ks.ConfigurationError):
        session.change(q=np.full(6, np.nan))
    np.testing.assert_array_equal(session.situation.q, REGULAR)


def test_back_undoes_posture_by_posture():
    """A motion of many postures is one step back."""
    session = session_of()
    session.change(q=np.zeros(6))
    session.mark()
    for k in range(5):
        session.change(undo=False, q=np.full(6, 0.1 * k))
    assert session.back()
    np.testing.assert_array_equal(session.situation.q, np.zeros(6))
    assert session.back()
    np.testing.assert_array_equal(session.situation.q, REGULAR)
    assert not session.back()


def test_listeners_are_told_once_for_each_change():
    session = session_of()
    told = []
    session.listen(lambda: told.append(session.situation.mass))
    session.change(mass=1.0)
    session.change(q=np.zeros(6))
    assert told == [1.0, 1.0]


def test_history_has_the_measures_of_the_motion():
    """The smallest singular value over the largest, and manipulability; 0 at a singular posture."""
    session = session_of("planar_2r", [0.3, 1.0])
    session.change(q=[0.3, 0.0])
    regular, singular = session.history
    a = ks.analyze(session.model, [0.3, 1.0])
    assert regular.least == a.singular_values[1] / a.singular_values[0]
    assert regular.manipulability == a.manipulability
    assert singular.least < 1e-15
    assert singular.manipulability == 0.0


def test_polytopes_without_limits_say_why():
    """A DH table has no velocity limits: a sentence, no exception."""
    arm = ks.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard")
    session = Session(arm, Situation(np.array([0.3, 1.0])))
    velocity, force, notes = session.polytopes(True, True)
    assert velocity is force is None
    assert len(notes) == 2
    assert all("limit" in note for note in notes)


def test_worker_answers_the_latest_question_only():
    """Questions that come while one is answered are dropped but for the last; an exception does not end the work."""
    failures, answered, gate = [], [], threading.Event()
    worker = LatestWorker("test", failures.append)
    worker.ask(lambda: gate.wait(10), quiet=0.0)
    while worker._question is not None:
        time.sleep(0.001)
    for k in range(5):
        worker.ask(lambda k=k: answered.append(k), quiet=0.0)
    gate.set()
    assert worker.wait(10)
    assert answered == [4]
    worker.ask(lambda: 1 / 0, quiet=0.0)
    assert worker.wait(10)
    assert isinstance(failures[0], ZeroDivisionError)
    worker.ask(lambda: answered.append(5), quiet=0.0)
    assert worker.wait(10)
    assert answered == [4, 5]
    worker.stop()
    worker._thread.join(5)
    assert not worker._thread.is_alive()


def test_a_shape_that_is_chosen_is_seen_at_a_scale_that_fits():
    """A polytope of the joint limits is far larger than an ellipsoid of unit rates: its scale is its own."""
    with explore(ks.load("ur5e"), REGULAR) as explorer:
        view, size = explorer.page.view, explorer.page.scene.size
        before = view.velocity_scale.value
        view.velocity.value = "polytope"
        wait_until(lambda: view.velocity_scale.value != before)
        reach = np.linalg.norm(ks.velocity_polytope(ks.load("ur5e"), REGULAR, task="position").corners, axis=-1).max()
        assert 0.15 * size < view.velocity_scale.value * reach < 0.6 * size


def test_a_slider_that_has_moved_on_is_not_pulled_back():
    """While one step is computed the reader makes the next: it is neither shown back nor lost."""
    with explore(ks.load("ur5e"), REGULAR) as explorer:
        joints, session = explorer.page.joints, explorer.session
        slider, event = joints.sliders[2], SimpleNamespace(client_id=1, target=joints.sliders[2])

        def next_step():
            if slider._impl.value == 1.301:
                slider._impl.value = 1.302  # as a message of the client sets it

        session._listeners.insert(0, next_step)
        slider._impl.value = 1.301
        joints._moved(2)(event)
        assert session.situation.q[2] == 1.301
        assert slider.value == 1.302
        joints._moved(2)(event)
        assert session.situation.q[2] == slider.value == 1.302


def test_slider_ranges():
    """Limits where there are some; else half a turn, or as far as the posture is."""
    lower, upper = np.array([-1.0, -np.inf, -np.inf, 0.5]), np.array([2.0, np.inf, np.inf, 0.5])
    ranges = slider_ranges(lower, upper, np.array([0.0, 0.0, 7.0, 0.5]))
    assert ranges == [(-1.0, 2.0), (-np.pi, np.pi), (-np.pi, 7.0), (0.5, 0.5 + STEP)]


def test_postures_come_back_from_their_file():
    """What is written is read again, bit for bit."""
    session = session_of()
    kept = {"a": np.array(REGULAR), "b <script>": np.arange(6) / 3}
    text = json.dumps(postures_data(session, kept)).encode()
    found = read_postures(text, session.model.joint_names)
    assert list(found) == ["a", "b <script>"]
    for q, again in zip(kept.values(), found.values(), strict=True):
        np.testing.assert_array_equal(q, again)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"[]",
        b"{}",
        b"\xff\xfe",
        b'{"joints": [], "postures": 3}',
        b"[" * 100_000,
        b'{"joints": ["a"], "postures": []}',
        b'{"joints": ["a"], "postures": [{"name": "x", "q": [1, 2]}]}',
        b'{"joints": ["a"], "postures": [{"name": "x", "q": [NaN]}]}',
        b'{"joints": ["a"], "postures": [{"name": "x", "q": [1e999]}]}',
        b'{"joints": ["b"], "postures": [{"name": "x", "q": [1]}]}',
        b" " * 1_000_001,
    ],
)
def test_files_that_hold_no_postures_are_refused(content):
    with pytest.raises(ks.ConfigurationError, match="KS436"):
        read_postures(content, ("a",))


def test_names_are_escaped_in_every_table():
    """No name of a file becomes markup; it is still there to be read."""
    name = "<b>&\"'\u202e"
    arm = ks.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard", name=name, joint_names=[name, f"{name}2"])
    a = ks.analyze(arm, [0.3, 0.0], ks.Wrench.on_robot(force=(0, -1, 0)), brief=True)
    for text in (verdict(a, None, name), jacobian(a.jacobian, a), torques(a)):
        assert "<b>" not in text
        assert "\u202e" not in text
        assert "&lt;b&gt;" in text or name not in str(a)


def test_long_names_are_shortened():
    assert shown_name("x" * 100, 20) == "xxxxxxxx…xxxxxxxxxxx"
    assert len(shown_name("x" * 100, 20)) == 20


def test_dependent_rows_are_those_of_the_wrench_held_for_free():
    """A stretched 2R arm at 0: vx is lost, and is the row that is always zero here; at an angle, both rows depend."""
    arm = ks.load("planar_2r")
    a = ks.analyze(arm, [0.4, 0.0], brief=True)
    text = jacobian(a.jacobian, a)
    marked = [row for row in ("vx", "vy", "vz", "wz") if f'<tr class="dependent" data-row="{row}">' in text]
    assert {"vx", "vy"} <= set(marked)
    assert 'class="still" data-row="vz"' in text


def test_explorer_begins_with_the_given_wrench_and_stops():
    """Its sign is kept; stopping twice does no harm, and ends the threads."""
    before = threading.active_count()
    arm = ks.load("planar_2r")
    explorer = explore(arm, [0.3, 1.0], wrench=ks.Wrench.on_environment(force=(0, -5, 0)), gravity=(0, -9.81, 0))
    assert explorer.session.situation.acts == PUSH != LOAD
    expected = ks.joint_torques(ks.jacobian(arm, [0.3, 1.0]), ks.Wrench.on_environment(force=(0, -5, 0)))
    np.testing.assert_allclose(explorer.session.analysis.joint_torques, expected)
    explorer.stop()
    explorer.stop()
    deadline = time.monotonic() + 10
    while threading.active_count() > before and time.monotonic() < deadline:
        time.sleep(0.05)
    assert threading.active_count() <= before + 1  # a pool of viser may keep one


def test_a_page_of_every_catalogue_arm():
    """Each can be looked at, planar ones at right angles to their plane."""
    for name in ks.catalogue_names():
        arm = ks.load(name)
        with explore(arm) as explorer:
            assert len(explorer.page.joints.sliders) == arm.n
            if explorer.page.scene.plane is not None:
                away = explorer.page.server.initial_camera.position - explorer.page.server.initial_camera.look_at
                assert np.abs(explorer.page.scene.plane @ away).max() < 1e-9
