"""The explorer in a real browser: what a reader does with mouse and keys, and which values come of it."""

import json
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

import kinestatics as ks
from browser import browser_fixture, page_of_fixture, wait_until
from kinestatics.explorer import explore
from kinestatics.explorer.jacobian_tab import FRAMES

__all__ = ["browser_fixture", "page_of_fixture"]

REGULAR = [0.3, -1.2, 1.3, -0.6, 1.0, 0.2]


@pytest.fixture(scope="module")
def running():
    """A page about a UR5e that all tests of this module share; each begins at the same posture."""
    with explore(ks.load("ur5e"), REGULAR) as explorer:
        assert explorer.page.singular.worker.wait(60)
        yield explorer


@pytest.fixture(name="ur5e")
def ur5e_fixture(running):
    """The shared page, at its first posture, without a load."""
    zero = (0.0, 0.0, 0.0)
    running.session.change(q=REGULAR, force=zero, torque=zero, mass=0.0, acts="a load on the robot")
    return running


def opened(page_of, explorer, **options):
    """The page, once it has been shown whole. Fewer pixels, so that drawing in software does not hold it up."""
    tab = page_of(explorer.address + "&fixedDpr=0.4", **options)
    tab.page.locator("[data-quantity=ready]").wait_for(state="attached", timeout=60_000)
    return tab


def q_of(explorer):
    return np.array(explorer.session.situation.q)


def show_tab(tab, name):
    tab.page.get_by_role("tab", name=name, exact=True).press("Enter")


def read(tab, quantity, attribute="data-value"):
    """Every value of a quantity that the page shows."""
    found = tab.page.locator(f"[data-quantity={quantity}]")
    return [element.get_attribute(attribute) for element in found.all()]


def verdict(tab):
    element = tab.page.locator("[data-quantity=verdict]")
    return element.get_attribute("data-singular") == "true", float(element.get_attribute("data-least"))


def type_number(box, value):
    """Into a box, as one who comes to it with the tabulator; no mouse, so that nothing waits for frames to be drawn."""
    box.fill(str(value))
    box.press("Enter")


def press(tab, name):
    """A button, by the keyboard."""
    tab.page.get_by_role("button", name=name).press("Enter")


def number_boxes(tab):
    """The boxes that stand beside the sliders, in the order of q."""
    return tab.page.locator("input[type=text]:visible, input:not([type]):visible")


def test_arrow_keys_on_a_slider_move_one_joint(page_of, ur5e):
    """Five steps of a thousandth; no other joint moves, not even by rounding."""
    tab = opened(page_of, ur5e)
    slider = tab.page.locator("[role=slider]").nth(2)
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
    tab.wait_until(lambda: abs(q_of(ur5e)[2] - (REGULAR[2] + 0.005)) < 1e-9)
    assert slider.get_attribute("aria-valuenow") == "1.305"
    np.testing.assert_array_equal(np.delete(q_of(ur5e), 2), np.delete(REGULAR, 2))
    tab.assert_quiet()


def test_dragging_a_slider_with_the_mouse(page_of, ur5e):
    """The thumb follows the mouse, the joint the thumb; it stays inside its limits when pulled beyond the end."""
    tab = opened(page_of, ur5e)
    thumb = tab.page.locator("[role=slider]").nth(0)
    place = thumb.bounding_box()
    x, y = place["x"] + place["width"] / 2, place["y"] + place["height"] / 2
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x + 400, y, steps=6)
    tab.page.mouse.up()
    upper = ur5e.session.model.upper[0]
    tab.wait_until(lambda: abs(q_of(ur5e)[0] - upper) < 2e-3)
    assert q_of(ur5e)[0] <= upper


def test_typed_value_turns_the_verdict(page_of, ur5e):
    """Joint 5 typed to 0: the wrist is singular, the meter says so, the lost motion is in words and as arrows."""
    tab = opened(page_of, ur5e)
    assert not verdict(tab)[0]
    type_number(number_boxes(tab).nth(4), 0)
    tab.wait_until(lambda: verdict(tab)[0])
    assert q_of(ur5e)[4] == 0.0
    assert verdict(tab)[1] < 1e-9
    scene = ur5e.page.scene
    assert scene._lost._arrows.visible
    assert scene._free._arrows.visible
    assert "lost: " in tab.page.locator(".ks").first.inner_text()
    type_number(number_boxes(tab).nth(4), 1)
    tab.wait_until(lambda: not verdict(tab)[0])
    assert not scene._lost._arrows.visible


def test_wrench_to_bars(page_of, ur5e):
    """A typed load: the bars are Jᵀ f of it, as the motors supply it, to 1e-6; gravity is what holds the arm."""
    tab = opened(page_of, ur5e)
    show_tab(tab, "Statics")
    boxes = number_boxes(tab)
    for k, value in enumerate((12.5, -7.0, -80.0)):
        type_number(boxes.nth(k + 1), value)
    arm = ks.load("ur5e")
    J = ks.jacobian(arm, REGULAR)
    tab.wait_until(lambda: ur5e.session.situation.force == (12.5, -7.0, -80.0))
    expected = -J.array.T @ [12.5, -7.0, -80.0, 0, 0, 0]  # a load on the robot: the motors push against it
    tab.wait_until(lambda: len(read(tab, "load")) == 6)
    tab.wait_until(lambda: np.allclose([float(x) for x in read(tab, "load")], expected, atol=1e-6))
    gravity = ks.gravity_torques(arm, REGULAR)
    np.testing.assert_allclose([float(x) for x in read(tab, "gravity")], gravity, atol=1e-6)
    np.testing.assert_allclose([float(x) for x in read(tab, "holding")], gravity + expected, atol=1e-6)


def test_payload_is_carried(page_of, ur5e):
    """Three kilograms at the tip add their weight to gravity's torques."""
    tab = opened(page_of, ur5e)
    show_tab(tab, "Statics")
    type_number(number_boxes(tab).nth(7), 3)
    tab.wait_until(lambda: ur5e.session.situation.mass == 3.0)
    expected = ks.gravity_torques(ks.load("ur5e").with_payload(3.0), REGULAR)
    tab.wait_until(lambda: len(read(tab, "gravity")) == 6)
    tab.wait_until(lambda: np.allclose([float(x) for x in read(tab, "gravity")], expected, atol=1e-6))


def test_gizmo_is_followed_by_the_joints(page_of, ur5e):
    """The mouse pulls the gizmo: the tip is where it was left, to a millimetre, and no joint is outside its limits."""
    model = ur5e.session.model
    tab = opened(page_of, ur5e)
    before = np.array(ur5e.session.analysis.pose.translation)
    place = tab.page.locator("canvas").first.bounding_box()
    moved = False
    for x, y in gizmo_pixels(ur5e, place):
        tab.page.mouse.move(x, y)
        tab.page.wait_for_timeout(700)  # the arrow must be seen hovered before it can be gripped
        tab.page.mouse.down()
        for step in range(1, 7):
            tab.page.mouse.move(x + 6 * step, y - 5 * step)
            tab.page.wait_for_timeout(120)
        tab.page.mouse.up()
        tab.page.wait_for_timeout(400)
        if moved := ur5e.page.tool.motion is not None:
            break
    assert moved, "the gizmo was not gripped at any of the pixels tried"
    wait_until(lambda: not ur5e.page.tool._held)
    assert ur5e.page.tool.worker.wait(20)
    motion, q = ur5e.page.tool.motion, q_of(ur5e)
    assert motion.distance <= 1e-3
    assert np.all((q >= model.lower) & (q <= model.upper))
    after = ks.pose(model, q).translation
    assert np.linalg.norm(after - before) > 0.01
    np.testing.assert_allclose(np.array(ur5e.page.tool.handle.position), after, atol=1e-3)


def gizmo_pixels(explorer, place):
    """Where the arrows of the gizmo may be seen: along its axes from the tip, as the camera of the page sees them."""
    (client,) = explorer.page.server.get_clients().values()
    camera = client.camera
    pose, size = explorer.session.analysis.pose, explorer.page.scene.size
    R, p = np.array(pose.rotation), np.array(pose.translation)
    w, x, y, z = camera.wxyz
    R_camera = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    for k in (2, 0, 1):
        for share in (0.9, 0.75, 0.6, 1.0):
            seen = R_camera.T @ (p + 0.28 * size * share * R[:, k] - camera.position)
            focal = place["height"] / 2 / np.tan(camera.fov / 2)
            yield (
                place["x"] + place["width"] / 2 + focal * seen[0] / seen[2],
                place["y"] + place["height"] / 2 + focal * seen[1] / seen[2],
            )


def test_button_lands_on_the_nearest_singularity(page_of, ur5e):
    """The nearest by name; the smallest singular value is then below 1e-9 of the largest, all joints inside their limits."""
    nearest = ur5e.page.singular._found.distance(REGULAR, within_limits=True)[0]
    tab = opened(page_of, ur5e)
    show_tab(tab, "Singular")
    press(tab, "go there")
    tab.wait_until(lambda: verdict(tab)[0], 30)
    a = ur5e.session.analysis
    assert a.singular_values[-1] / a.singular_values[0] < 1e-9
    np.testing.assert_allclose(q_of(ur5e), nearest.nearest, atol=1e-12)
    model = ur5e.session.model
    assert np.all((q_of(ur5e) >= model.lower) & (q_of(ur5e) <= model.upper))
    tab.wait_until(lambda: read(tab, "nearest", "data-name") == [nearest.component.label], 30)


def test_null_motion_of_the_wrist_leaves_the_tip(page_of, ur5e):
    """At the wrist's singularity joints 4 and 6 turn against each other; the slider moves them, the tip stands still."""
    ur5e.session.change(q=[*REGULAR[:4], 0.0, 0.2])
    before = np.array(ur5e.session.analysis.pose)
    tab = opened(page_of, ur5e)
    show_tab(tab, "Singular")
    press(tab, "take the null motion")
    slider = tab.page.locator("[role=slider]:visible").last
    tab.wait_until(lambda: ur5e.page.singular._path is not None)
    slider.focus()
    for _ in range(20):
        slider.press("ArrowRight")
    tab.wait_until(lambda: abs(ur5e.page.singular.along.value - 0.4) < 1e-6)
    tab.wait_until(lambda: not np.allclose(q_of(ur5e)[[3, 5]], [REGULAR[3], 0.2], atol=0.1))
    np.testing.assert_allclose(np.array(ur5e.session.analysis.pose), before, atol=1e-6)


def test_reload_shows_the_same(page_of, ur5e):
    """What was set is there again after a reload, the token no longer being in the address bar."""
    tab = opened(page_of, ur5e)
    type_number(number_boxes(tab).nth(1), -0.777)
    tab.wait_until(lambda: abs(q_of(ur5e)[1] + 0.777) < 1e-12)
    tab.page.reload()
    tab.page.locator("[data-quantity=ready]").wait_for(state="attached", timeout=60_000)
    tab.wait_until(lambda: tab.page.locator("[role=slider]").nth(1).get_attribute("aria-valuenow") == "-0.777")
    assert ur5e.address.partition("token=")[2] not in tab.page.url
    assert abs(verdict(tab)[1] - ur5e.session.history[-1].least) < 1e-15


def test_two_people_look_at_once(page_of, ur5e):
    """What one moves, the other sees."""
    one, two = opened(page_of, ur5e), opened(page_of, ur5e)
    slider = one.page.locator("[role=slider]").nth(3)
    slider.focus()
    slider.press("ArrowLeft")
    two.wait_until(lambda: two.page.locator("[role=slider]").nth(3).get_attribute("aria-valuenow") == "-0.601")
    type_number(number_boxes(two).nth(3), -0.5)
    one.wait_until(lambda: slider.get_attribute("aria-valuenow") == "-0.5")
    one.assert_quiet()
    two.assert_quiet()


def test_jacobian_in_a_chosen_frame(page_of, ur5e):
    """The table is J of the posture, to the last digit, in another frame too; dependent rows are marked when singular."""
    tab = opened(page_of, ur5e)
    show_tab(tab, "Jacobian")

    def table():
        cells = tab.page.locator("tr[data-row] td[data-value]").all()
        return np.array([float(cell.get_attribute("data-value")) for cell in cells]).reshape(6, 6)

    J = ks.jacobian(ur5e.session.model, REGULAR)
    tab.wait_until(lambda: tab.page.locator("tr[data-row]").count() == 6)
    tab.wait_until(lambda: np.array_equal(table(), J.array))
    choice = tab.page.locator("input.mantine-Select-input:visible")
    for key in ("ArrowDown", "ArrowDown", "Enter"):  # opens the list, goes down, takes what is reached
        choice.press(key)
    tab.wait_until(lambda: FRAMES[ur5e.page.jacobian.frame.value] is not None)
    other = J.change_frame(FRAMES[ur5e.page.jacobian.frame.value]).array
    tab.wait_until(lambda: np.array_equal(table(), other))
    assert tab.page.locator("tr.dependent").count() == 0
    ur5e.session.change(q=[*REGULAR[:4], 0.0, 0.2])
    tab.wait_until(lambda: tab.page.locator("tr.dependent").count() > 0)


def test_postures_are_kept_and_downloaded(page_of, ur5e, tmp_path):
    """A kept posture comes back exactly; the file holds it; a file of another robot is refused with the reason."""
    tab = opened(page_of, ur5e)
    show_tab(tab, "Files")
    press(tab, "keep this posture")
    tab.wait_until(lambda: bool(ur5e.page.files.kept))
    with tab.page.expect_download() as download:
        press(tab, "download the postures")
    data = json.loads(Path(download.value.path()).read_text())
    assert data["postures"][0]["q"] == REGULAR
    ur5e.session.change(q=np.zeros(6))
    press(tab, "go to it")
    tab.wait_until(lambda: np.array_equal(q_of(ur5e), REGULAR))
    other = tmp_path / "other.json"
    other.write_text(json.dumps({**data, "joints": ["a"]}))
    tab.page.locator("input[type=file]").set_input_files(other)
    tab.wait_until(lambda: "KS436" in tab.page.locator(".ks").first.inner_text())


def test_scene_opens_from_disk_without_a_network(page_of, ur5e, tmp_path):
    """The exported scene is one file that asks for nothing and shows something."""
    tab = opened(page_of, ur5e)
    show_tab(tab, "Files")
    with tab.page.expect_download(timeout=60_000) as download:
        press(tab, "download the scene")
    saved = tmp_path / "scene.html"
    download.value.save_as(saved)
    requests = []
    alone = page_of()
    alone.page.on("request", lambda request: requests.append(request.url))
    alone.page.context.set_offline(True)
    alone.page.goto(saved.as_uri())
    alone.page.locator("canvas").first.wait_for(timeout=60_000)
    alone.page.wait_for_timeout(1500)
    assert not [url for url in requests if not url.startswith(("file:", "data:", "blob:"))]
    alone.assert_quiet()


def test_report_from_the_page(page_of, ur5e, tmp_path):
    """The report is that of the present posture."""
    ur5e.session.change(q=[*REGULAR[:4], 0.0, 0.2], force=(0.0, 0.0, -50.0))
    tab = opened(page_of, ur5e)
    show_tab(tab, "Files")
    with tab.page.expect_download(timeout=120_000) as download:
        press(tab, "download a report")
    saved = tmp_path / "report.html"
    download.value.save_as(saved)
    text = saved.read_text()
    assert "ur5e" in text
    assert "singular" in text
    report = page_of(saved.as_uri())
    assert "Jacobian" in report.page.locator("body").inner_text()
    report.assert_quiet()


def test_narrow_window(page_of, ur5e):
    """On a telephone's width nothing is cut off sideways, and the sliders still work."""
    tab = opened(page_of, ur5e, width=380, height=740)
    slider = tab.page.locator("[role=slider]").nth(0)
    slider.scroll_into_view_if_needed()
    slider.focus()
    slider.press("ArrowRight")
    tab.wait_until(lambda: abs(q_of(ur5e)[0] - 0.301) < 1e-9)
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= 380
    place = slider.bounding_box()
    assert 0 <= place["x"] <= 380


def test_usable_and_answers_in_time(page_of, ur5e):
    """Usable soon after being asked for, and from a key on a slider to the shown value no wait; drawn in software.

    The goals, 5 s and 0.6 s, are for a machine that does nothing else, and are measured by benchmarks/surfaces.py. Other
    tests run beside this one: the best of three may take twice as long.
    """
    usable, shown = [], []
    for _ in range(3):
        began = time.perf_counter()
        tab = opened(page_of, ur5e)
        usable.append(time.perf_counter() - began)
        tab.page.wait_for_timeout(1500)
        slider = tab.page.locator("[role=slider]").nth(1)
        slider.focus()
        before = verdict(tab)[1]
        began = time.perf_counter()
        slider.press("ArrowRight")
        tab.wait_until(lambda tab=tab, before=before: verdict(tab)[1] != before)
        shown.append(time.perf_counter() - began)
        tab.page.close()
    assert min(usable) <= 2 * 5.0, usable
    assert min(shown) <= 2 * 0.6, shown


HOSTILE = (
    "<script>window.RAN=1</script>",
    "<img src=x onerror='window.RAN=1'>",
    '"><svg onload="window.RAN=1">',
    "<iframe srcdoc='<script>parent.RAN=1</script>'></iframe>",
    "[x](javascript:window.RAN=1)",
    "</style><script>window.RAN=1</script>",
    "{{constructor.constructor('window.RAN=1')()}}",
    "a\u202eb\nc\x0bd" + "x" * 3000,
)


@pytest.mark.parametrize("name", HOSTILE, ids=range(8))
def test_names_of_a_file_run_no_script(page_of, name):
    """Robot, links and joints with a hostile name: every tab is looked at, no script runs, nothing is asked for."""
    arm = ks.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard", name=name, joint_names=[name, f"{name}2"])
    with explore(arm, [0.3, 0.0]) as explorer:
        tab = opened(page_of, explorer)
        for word in ("Statics", "Singular", "Jacobian", "View", "Files"):
            show_tab(tab, word)
            tab.page.wait_for_timeout(60)
        assert tab.page.evaluate("window.RAN") is None
        tab.assert_quiet()
