"""The player on a plain page in Chromium: what it shows, and that every way of driving it works."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from PIL import Image

from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.viewers.web.conftest import PlayerPage
from tests.viewers.web.synthetic import walk
from viewers.web import payload

pytestmark = [pytest.mark.ui, pytest.mark.timeout(240)]
Open = Callable[..., PlayerPage]

PROJECTED = """(() => {
    const { take, pose, root } = player.actors[0];
    const at = take.skeleton.joints.indexOf(joint) * 3;
    return root.clone().fromArray(pose.places, at).project(player.stage.camera).toArray();
})()"""
"""Where `joint` of the first figure is in the picture: -1..1 from left to right and from bottom to top."""
NAME = "(e) => e?.getAttribute('aria-label') || e?.textContent.trim()"
"""What a control is called."""
OUTLINE = "(({ outlineStyle, outlineWidth }) => [outlineStyle, outlineWidth])(getComputedStyle(root.activeElement))"


def picture(player: PlayerPage) -> np.ndarray:
    """The stage as pixels (H, W, 3)."""
    player.pictures(2)
    player.still()
    shot = player.page.locator(".motion-player .stage").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=np.int64)


def positions(player: PlayerPage, actor: int = 0) -> np.ndarray:
    """(J, 3) joints as the browser has computed them."""
    player.pictures(2)
    return np.reshape(player.js("Array.from(player.actors[argument].pose.places)", actor), (-1, 3))


# ---- what is shown ---------------------------------------------------------------------------------------


def test_the_figure_is_drawn_and_moves(open_player: Open):
    player = open_player(walk(4.0, wave=True), body="anny", in_place=True, controls="none")
    first = picture(player)
    player.set("frame", 60)
    second = picture(player)
    player.set("frame", 0)
    again = picture(player)
    changed = (np.abs(first - second).sum(-1) > 40).mean()
    assert 0.01 < changed < 0.4
    assert (np.abs(first - again).sum(-1) > 40).mean() < 0.001
    middle = first[:, first.shape[1] // 2 - 40 : first.shape[1] // 2 + 40].reshape(-1, 3)
    assert len(np.unique(middle // 16, axis=0)) > 40, "a shaded figure has many tones, the empty backdrop has few"


def test_upright_and_facing_the_viewer_at_camera_front(open_player: Open):
    player = open_player(walk(2.0), body="anny", camera="front", in_place=True)
    player.still()
    names = ["head", "pelvis", "left_ankle", "left_shoulder", "right_shoulder"]
    seen = dict(zip(names, player.js(f"argument.map((joint) => {PROJECTED})", names), strict=True))
    assert seen["head"][1] > seen["pelvis"][1] > seen["left_ankle"][1]
    assert seen["left_shoulder"][0] > 0 > seen["right_shoulder"][0], "its left is on the viewer's right"
    assert all(abs(x) < 0.9 and abs(y) < 0.95 for x, y, _ in seen.values())


@pytest.mark.parametrize("toggles", [{}, {"mirror": True}, {"in_place": True}, {"mirror": True, "in_place": True}])
def test_joints_are_where_python_says(open_player: Open, toggles: dict[str, bool]):
    motion = walk(2.0, turn=0.8, wave=True)
    player = open_player(motion, **toggles)
    shown = motion.mirror() if toggles.get("mirror") else motion
    shown = shown.in_place() if toggles.get("in_place") else shown
    for frame in (0, 17, 39):
        player.set("frame", frame)
        assert np.abs(positions(player) - shown.positions[frame]).max() < 5e-4


def test_between_frames_rotations_are_slerped(open_player: Open):
    motion = walk(1.0)
    player = open_player(motion)
    halves = motion.resample(40.0)
    player.js("player.clock.at = 7.5")
    assert np.abs(positions(player) - halves.positions[15]).max() < 5e-4


def test_limbs_stretch_to_other_bone_lengths(open_player: Open):
    tall = SMPL22.scaled({"left_knee": 1.3, "right_knee": 1.3})
    motion = walk(1.0, skeleton=tall)
    player = open_player([walk(1.0), motion], body="anny")
    assert np.abs(positions(player, 1) - motion.positions[0]).max() < 5e-4
    assert player.js("player.actors[1].skin.binding.stretch.map((s, j) => s ? j : -1).filter((j) => j >= 0)") == [1, 2]
    assert player.js("player.actors[0].skin.binding.stretch.every((s) => s === null)")


@pytest.mark.parametrize("show", ["body", "skeleton", "both"])
def test_body_and_bones(open_player: Open, show: str):
    player = open_player(walk(1.0), body="anny", show=show)
    visible = player.js("[player.actors[0].solid.visible, player.actors[0].bones.object.visible]")
    assert visible == [show != "skeleton", show != "body"]


def test_without_a_body_the_bones_show(open_player: Open):
    player = open_player(walk(1.0), body=None)
    assert player.js("player.actors[0].bones.object.visible")
    assert (picture(player).max(axis=-1) > 150).mean() > 0.002


def test_ghosts_stand_at_multiples_before_the_playhead(open_player: Open):
    motion = walk(4.0)
    player = open_player(motion, ghosts=8, frame=30)
    player.pictures(2)
    roots = player.js("player.actors[0].ghosts.pool.filter((g) => g.object.visible).map((g) => g.root.toArray())")
    assert np.allclose(roots, motion.positions[[24, 16, 8, 0], 0], atol=5e-4)


def test_contacts_and_trail(open_player: Open):
    motion = walk(2.0)
    frame = int(np.flatnonzero(motion.contacts[:, 0, 0])[3])
    player = open_player(motion, contacts=True, trail=True, frame=frame)
    player.pictures(2)
    strengths = player.js("Array.from(player.actors[0].rings.object.geometry.attributes.strength.array)")
    assert strengths == motion.contacts[frame].reshape(-1).astype(float).tolist()
    dots = player.js("Array.from(player.actors[0].trail.object.geometry.attributes.position.array)")
    assert np.allclose(np.reshape(dots, (-1, 3))[:, [0, 2]], motion.positions[:, 0][:, [0, 2]], atol=1e-4)


def test_sixteen_figures_side_by_side_or_in_one_place(open_player: Open):
    player = open_player([walk(1.0)] * 16, spacing=1.0, show="skeleton")
    places = "player.actors.map((actor) => actor.object.position.toArray())"
    front, back = np.split(np.array(player.js(places)), 2)
    assert np.allclose(np.diff(front[:, 0]), 1.0)
    assert np.allclose(np.diff(back[:, 0]), 1.0)
    assert (back[:, 2] < front[:, 2] - 1).all(), "many stand in two rows"
    player.set("arrangement", "overlay")
    assert not np.any(player.js(places))


def test_light_theme_is_light(open_player: Open):
    player = open_player(walk(1.0), theme="dark")
    dark = picture(player).mean()
    player.set("theme", "light")
    assert player.js("root.querySelector('.player').dataset.theme") == "light"
    assert picture(player).mean() > dark + 80


# ---- transport -------------------------------------------------------------------------------------------


def test_readout_and_go_to_frame(open_player: Open):
    player = open_player(walk(9.4), frame=52)
    readout = player.page.locator(".motion-player .readout")
    player.pictures(2)
    assert readout.inner_text().replace("\n", " ").startswith("0:02.60 / 0:09.40 · frame")
    box = player.page.get_by_label("Go to frame")
    assert box.input_value() == "52"
    box.fill("100")
    box.press("Enter")
    assert player.frame == 100
    assert player.page.get_by_role("status").inner_text() == "Frame 100, 5.00 seconds"
    box.fill("9999")
    box.press("Enter")
    assert player.frame == 187


def test_keys(open_player: Open):
    player = open_player(walk(4.0))
    player.focus()
    steps = [
        ("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), (".", 2), (",", 1), ("Shift+ArrowRight", 11),
        ("Shift+ArrowLeft", 1), ("End", 79), ("ArrowRight", 79), ("Home", 0), ("ArrowLeft", 0),
    ]  # fmt: skip
    for key, frame in steps:
        player.press(key)
        assert player.frame == frame, key
    toggles = [
        ("g", "ghosts", 8), ("g", "ghosts", 0), ("s", "show", "skeleton"), ("s", "show", "both"), ("s", "show", "body"),
        ("l", "loop", "selection"), ("l", "loop", "off"), ("l", "loop", "all"),
        ("t", "trail", True), ("c", "contacts", True),
        ("1", "camera", "front"), ("2", "camera", "back"), ("3", "camera", "left"), ("4", "camera", "right"),
        ("0", "camera", "orbit"), ("f", "camera", "follow"), ("f", "camera", "orbit"),
        ("Space", "playing", True), ("Space", "playing", False),
    ]  # fmt: skip
    for key, trait, value in toggles:
        player.press(key)
        assert player.get(trait) == value, key


@pytest.mark.parametrize(("key", "axis", "sign"), [("1", 2, 1), ("2", 2, -1), ("3", 0, 1), ("4", 0, -1)])
def test_fixed_views_look_from_their_side(open_player: Open, key: str, axis: int, sign: int):
    player = open_player(walk(1.0), in_place=True)
    player.focus()
    player.press(key)
    player.still()
    arm = np.subtract(
        *player.js("[player.stage.camera.position.toArray(), player.cameraman.controls.target.toArray()]")
    )
    assert arm[axis] * sign > 0.95 * np.linalg.norm(arm)


def test_follow_keeps_the_figure_in_the_middle(open_player: Open):
    motion = walk(8.0)
    player = open_player(motion, camera="follow")
    player.set("frame", 150)
    player.still()
    target = player.js("player.cameraman.controls.target.toArray()")
    assert np.allclose(np.take(target, [0, 2]), motion.positions[150, 0, [0, 2]], atol=2e-3)


def test_a_long_way_is_followed_from_the_start(open_player: Open):
    player = open_player(walk(10.0))
    assert player.get("camera") == "follow"


def test_keys_are_left_alone_while_typing_and_outside(open_player: Open):
    player = open_player(walk(4.0), ghosts=8)
    box = player.page.get_by_label("A ghost every so many frames")
    box.fill("12")
    box.press("ArrowUp")
    box.press("s")
    assert (player.frame, player.get("show")) == (0, "body")
    player.page.evaluate("document.activeElement.blur()")
    player.press("ArrowRight")
    assert player.frame == 0
    player.set("global_keys", True)
    player.press("ArrowRight")
    assert player.frame == 1


def test_buttons_do_what_they_say(open_player: Open):
    player = open_player(walk(4.0))
    click = [
        ("Next frame", lambda: player.frame == 1), ("Last frame", lambda: player.frame == 79),
        ("Previous frame", lambda: player.frame == 78), ("First frame", lambda: player.frame == 0),
        ("Skeleton", lambda: player.get("show") == "skeleton"), ("Trail", lambda: player.get("trail")),
        ("Ghosts", lambda: player.get("ghosts") == 8), ("Contacts", lambda: player.get("contacts")),
        ("In place", lambda: player.get("in_place")), ("Mirror", lambda: player.get("mirror")),
        ("Floor", lambda: not player.get("floor")), ("Back view", lambda: player.get("camera") == "back"),
        ("Light or dark", lambda: player.get("theme") == "light"), ("Play", lambda: player.get("playing")),
        ("Pause", lambda: not player.get("playing")),
    ]  # fmt: skip
    for name, done in click:
        player.page.get_by_role("button", name=name, exact=True).click()
        assert done(), name
    assert player.page.get_by_role("button", name="Trail", exact=True).get_attribute("aria-pressed") == "true"
    player.page.get_by_label("Speed").select_option("0.5")
    player.page.get_by_label("Loop").select_option("off")
    assert (player.get("speed"), player.get("loop")) == (0.5, "off")


def test_scrubbing_with_the_pointer_and_the_keyboard(open_player: Open):
    player = open_player(walk(4.0))
    slider = player.page.get_by_role("slider", name="Scrub")
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    player.page.mouse.move(box["x"] + box["width"] * 0.25, y)
    player.page.mouse.down()
    assert player.frame == 20
    player.page.mouse.move(box["x"] + box["width"] * 0.75 + 1, y + 60)
    assert player.frame == 60
    player.page.mouse.move(box["x"] + box["width"] + 50, y)
    player.page.mouse.up()
    assert (player.frame, player.get("frame")) == (79, 79)
    slider.press("ArrowLeft")
    player.pictures(2)
    assert slider.get_attribute("aria-valuenow") == "78"
    assert slider.get_attribute("aria-valuetext") == "frame 78, 0:03.90"
    assert slider.get_attribute("aria-valuemax") == "79"


def test_shift_drag_selects_what_loops(open_player: Open):
    player = open_player(walk(4.0))
    box = player.page.get_by_role("slider", name="Scrub").bounding_box()
    y = box["y"] + 8
    player.page.keyboard.down("Shift")
    player.page.mouse.move(box["x"] + box["width"] * 0.5 + 1, y)
    player.page.mouse.down()
    player.page.mouse.move(box["x"] + box["width"] * 0.25 + 1, y)
    player.page.mouse.up()
    player.page.keyboard.up("Shift")
    assert (player.get("selection"), player.get("loop")) == ([20, 41], "selection")
    player.set("playing", True)
    player.page.wait_for_timeout(700)
    assert 20 <= player.frame < 41


def test_in_and_out_keys_mark_the_selection(open_player: Open):
    player = open_player(walk(4.0), frame=10)
    player.focus()
    player.press("i")
    assert player.get("selection") == [10, 80]
    player.press("Shift+ArrowRight", "o")
    assert player.get("selection") == [10, 21]
    assert player.get("loop") == "selection"


def test_labels_lead_to_their_frames(open_player: Open):
    player = open_player(walk(4.0))
    block = player.page.get_by_role("button", name="wave left")
    block.click()
    assert player.frame == 40
    block.dblclick()
    assert (player.get("selection"), player.get("loop")) == ([40, 68], "selection")
    left = block.bounding_box()["x"] - player.page.get_by_role("slider").bounding_box()["x"]
    assert left == pytest.approx(0.5 * player.page.get_by_role("slider").bounding_box()["width"], abs=2)


# ---- time ------------------------------------------------------------------------------------------------


def test_playing_takes_its_time_and_stops_at_the_end(open_player: Open):
    player = open_player(walk(1.0), loop="off", show="skeleton")
    player.set("playing", True)
    player.page.wait_for_function("() => !window.motionPlayer.model.get('playing')")
    assert player.get("frame") == 19
    player.set("playing", True)  # starts over
    player.pictures(2)
    assert player.js("player.clock.at") < 15


def test_frames_are_reported_five_times_a_second_at_most_and_at_rest(open_player: Open):
    player = open_player(walk(4.0), show="skeleton")
    player.page.evaluate(
        """() => {
            const { model } = window.motionPlayer, set = model.set.bind(model);
            window.sent = [];
            model.set = (name, value) => {
                if (name === 'frame') sent.push([performance.now(), value]);
                set(name, value);
            };
            model.set('playing', true);
        }"""
    )
    player.page.wait_for_function("() => window.sent.length >= 6")
    player.set("playing", False)
    times, frames = np.array(player.page.evaluate("window.sent")).T
    assert (np.diff(times)[:-1] >= 199).all(), "all but the last, which pausing sent"
    assert frames[-1] == player.frame == player.get("frame")


def test_clock(open_player: Open):
    player = open_player(walk(4.0), show="skeleton")
    advance = "(([loop, speed, elapsed]) => { const c = player.clock; Object.assign(c, { at: 0, loop, speed });"
    cases = [
        ("all", 1.0, 0.5, 10.0), ("all", 2.0, 0.5, 20.0), ("all", 1.0, 4.25, 5.0), ("all", 0.1, 1.0, 2.0),
        ("off", 1.0, 9.0, 79.0),
    ]  # fmt: skip
    for *given, at in cases:
        assert player.js(advance + " c.advance(elapsed); return c.at; })(argument)", given) == pytest.approx(at), given


def test_takes_of_other_rates_and_lengths_share_the_seconds(open_player: Open):
    short, fast = walk(1.0, 20.0), walk(3.0, 60.0)
    player = open_player([short, fast])
    assert player.js("player.clock.frames") == 60
    player.set("frame", 30)  # 1.5 s
    assert np.abs(positions(player, 0) - short.positions[19]).max() < 5e-4
    assert np.abs(positions(player, 1) - fast.positions[90]).max() < 5e-4


def test_another_version_of_the_same_keeps_its_place(open_player: Open):
    player = open_player(walk(2.0, wave=True), frame=25, camera="left")
    camera = player.js("player.stage.camera.position.toArray()")
    other, longer = (payload.encode_takes([payload.Actor(walk(seconds))]) for seconds in (2.0, 3.0))
    send = "model.set('take_data', Uint8Array.from(atob(argument), (letter) => letter.charCodeAt(0)))"
    player.js(send, base64.b64encode(other).decode())
    player.pictures(2)
    assert (player.frame, player.get("frame")) == (25, 25)
    assert player.js("player.stage.camera.position.toArray()") == camera
    player.js(send, base64.b64encode(longer).decode())
    assert (player.frame, player.get("frame")) == (0, 0)


def test_a_frame_that_does_not_exist_comes_back_corrected(open_player: Open):
    player = open_player(walk(1.0))
    player.set("frame", 500)
    assert player.get("frame") == 19
    player.focus()
    player.press("ArrowLeft")
    player.set("frame", 19)
    player.press("ArrowLeft")
    assert player.get("frame") == 18


def test_nothing_is_drawn_while_nothing_moves(open_player: Open):
    player = open_player(walk(2.0))
    player.still()
    before = player.js("player.stage.pictures")
    player.page.wait_for_timeout(500)
    assert player.js("player.stage.pictures") == before
    player.set("frame", 10)
    player.still()
    assert before < player.js("player.stage.pictures") < before + 10


def test_nothing_is_drawn_out_of_sight(open_player: Open):
    player = open_player(walk(2.0), playing=True)
    player.pictures(3)
    player.page.evaluate("document.querySelector('#player').style.marginTop = '5000px'")
    player.page.wait_for_function("() => !document.querySelector('.motion-player').player.stage.visible")
    before = player.js("player.stage.pictures")
    player.page.wait_for_timeout(400)
    assert player.js("player.stage.pictures") == before
    player.page.evaluate("document.querySelector('#player').style.marginTop = '0'")
    player.page.wait_for_function(
        "(before) => document.querySelector('.motion-player').player.stage.pictures > before", arg=before
    )


def test_calm_is_respected(open_player: Open):
    player = open_player(walk(2.0), playing=True, context={"reduced_motion": "reduce"})
    assert player.get("playing") is False
    player.focus()
    player.press("3")
    player.pictures(1)
    assert player.js("player.cameraman.glide") is None
    player.press("Space")
    assert player.get("playing") is True, "asked for, it plays"


# ---- picking, size, life ---------------------------------------------------------------------------------


def test_clicking_a_figure_or_its_name_picks_it(open_player: Open):
    player = open_player([walk(1.0), walk(1.0)], labels=["one", "two"], body="anny")
    player.still()
    x, y = player.js(
        "(() => { const v = player.actors[1].root.clone().project(player.stage.camera), c = player.stage.canvas;"
        "return [(v.x + 1) / 2 * c.clientWidth, (1 - v.y) / 2 * c.clientHeight]; })()"
    )
    view = player.page.locator(".motion-player .view")
    view.click(position={"x": x, "y": y})
    assert player.get("selected") == 1
    assert player.js("player.actors[1].outline.visible && !player.actors[0].outline.visible")
    view.click(position={"x": 5, "y": 200})
    assert player.get("selected") == 1, "a click beside the figures changes nothing"
    name = player.page.get_by_role("button", name="one", exact=True)
    name.focus()
    name.press("Enter")
    assert player.get("selected") == 0
    assert name.get_attribute("aria-pressed") == "true"


def test_timeline_is_that_of_the_picked_take(open_player: Open):
    player = open_player([walk(4.0), walk(4.0, labels=False).labelled("jump")])
    assert player.page.get_by_role("button", name="wave left").count() == 1
    player.set("selected", 1)
    assert player.page.get_by_role("button", name="wave left").count() == 0
    assert player.page.get_by_role("button", name="jump").count() == 1


def test_it_fills_its_container(open_player: Open):
    player = open_player(walk(1.0))
    player.page.set_viewport_size({"width": 700, "height": 500})
    player.page.wait_for_function(
        """() => {
            const { player, shadowRoot } = document.querySelector('.motion-player');
            const { clientWidth, clientHeight } = shadowRoot.querySelector('.stage');
            return clientWidth === 700 && Math.abs(player.stage.camera.aspect - clientWidth / clientHeight) < 1e-6;
        }"""
    )
    assert player.js("root.querySelector('.player').scrollWidth <= 700")
    assert player.js("host.getBoundingClientRect().height") == 500


def test_pixel_ratio_is_capped(open_player: Open):
    player = open_player(walk(1.0), context={"device_scale_factor": 4, "viewport": {"width": 300, "height": 300}})
    player.js("Object.assign(player.stage, { thrifty: false }), player.resize(300, 300)")  # as with a graphics card
    assert player.js("player.stage.canvas.width / player.stage.canvas.clientWidth") == 2


def test_picture_downloads(open_player: Open):
    player = open_player(walk(1.0), labels=["A walk"], frame=7)
    player.focus()
    with player.page.expect_download() as waiting:
        player.press("p")
    assert waiting.value.suggested_filename == "A-walk-frame-0007.png"
    image = Image.open(waiting.value.path())
    assert image.size[0] >= player.js("player.stage.canvas.clientWidth")
    corner = np.asarray(image.convert("RGB"), dtype=float)[:20, :20].mean(axis=(0, 1))
    assert np.abs(corner - [0x15, 0x18, 0x1D]).max() < 16, "the background is in it"
    assert len(image.convert("RGB").getcolors(1 << 24)) > 500


def test_frame_in_the_address(open_player: Open):
    player = open_player(walk(4.0), sync_url=True, fragment="#tab=2&frame=30")
    assert player.frame == 30
    player.focus()
    player.press("ArrowRight")
    assert player.page.url.endswith("#tab=2&frame=31")
    player.page.evaluate("location.hash = '#frame=12'")
    player.page.wait_for_function("() => document.querySelector('.motion-player').player.frame === 12")


def test_the_address_is_left_alone_unless_asked(open_player: Open):
    player = open_player(walk(4.0), fragment="#frame=30")
    assert player.frame == 0
    player.focus()
    player.press("ArrowRight")
    assert player.page.url.endswith("#frame=30")


def test_several_players_and_taking_one_down(open_player: Open):
    player = open_player(walk(2.0))
    player.page.evaluate(
        """async () => {
            const source = new Blob([document.getElementById('bundle').textContent], { type: 'text/javascript' });
            const { mount } = await import(URL.createObjectURL(source));
            const el = document.body.appendChild(document.createElement('div'));
            el.style.height = '300px';
            el.id = 'second';
            window.second = mount(el, JSON.parse(document.getElementById('values').textContent));
        }"""
    )
    player.focus()
    player.press("ArrowRight")
    assert player.page.evaluate("[motionPlayer.model.get('frame'), second.model.get('frame') ?? 0]") == [1, 0]
    gone = player.page.evaluate(
        """() => {
            const { stage } = document.querySelector('#second .motion-player').player;
            const context = stage.renderer.getContext();
            window.second.dispose();
            return [document.querySelector('#second').children.length, context.isContextLost(), stage.stopped];
        }"""
    )
    assert gone == [0, True, True]
    player.press("ArrowRight")
    assert player.frame == 2


def test_missing_webgl_is_said_in_words(open_player: Open, chromium: Any):
    fine = open_player(walk(1.0))
    page = chromium.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(fine.path.as_uri())
    assert "WebGL 2" in page.get_by_role("alert").inner_text()
    assert "WebGL 2" in page.evaluate("motionPlayer.model.get('error')")
    page.close()


def test_damaged_motions_are_said_in_words(open_player: Open, chromium: Any):
    fine = open_player(walk(1.0))
    page = chromium.new_page()
    page.goto(fine.path.as_uri())
    page.evaluate(
        """async () => {
            const source = new Blob([document.getElementById('bundle').textContent], { type: 'text/javascript' });
            const { mount } = await import(URL.createObjectURL(source));
            const el = document.body.appendChild(document.createElement('div'));
            window.bad = mount(el, { take_data: btoa('nonsense') });
        }"""
    )
    assert "not a motionloom payload" in page.get_by_role("alert").inner_text()
    assert "not a motionloom payload" in page.evaluate("bad.model.get('error')")
    page.close()


# ---- for everybody ---------------------------------------------------------------------------------------


def test_every_control_has_a_name_and_can_be_reached(open_player: Open):
    player = open_player([walk(4.0), walk(4.0)], ghosts=8)
    player.pictures(2)
    controls = player.js(
        """[...root.querySelectorAll('button, input, select, [role=slider], [tabindex]')]
            .filter((e) => e.checkVisibility()).map((e) => ({
                tag: e.outerHTML.slice(0, 80),
                name: (NAME)(e),
                tabindex: e.tabIndex,
            }))""".replace("NAME", NAME)
    )
    assert len(controls) > 25
    assert [c["tag"] for c in controls if not c["name"] or c["tabindex"] < 0] == []
    player.page.evaluate("document.activeElement.blur()")
    reached = set()
    for _ in range(len(controls) + 2):
        player.press("Tab")
        reached.add(
            player.js("root.activeElement?.getAttribute('aria-label') || root.activeElement?.textContent.trim()")
        )
    assert {c["name"] for c in controls} <= reached


def test_focus_is_seen(open_player: Open):
    player = open_player(walk(1.0))
    for _ in range(3):
        player.press("Tab")
    outline = player.js(
        "getComputedStyle(root.activeElement).outlineStyle + getComputedStyle(root.activeElement).outlineWidth"
    )
    assert outline == "solid2px"


def test_help_opens_and_closes(open_player: Open):
    player = open_player(walk(1.0))
    player.focus()
    player.press("?")
    dialog = player.page.get_by_role("dialog")
    assert dialog.is_visible()
    player.press("Tab", "ArrowRight")
    assert player.js("root.activeElement.getAttribute('aria-label')") == "Close help"
    assert player.frame == 0, "keys rest while help is open"
    player.press("Escape")
    assert not dialog.is_visible()
    assert player.js("root.activeElement.className") == "view"


def test_a_motion_of_one_frame(open_player: Open):
    still = Motion(SMPL22, walk(1.0).rotations[:1], walk(1.0).translation[:1], 20.0)
    player = open_player(still, playing=True, trail=True, contacts=True, ghosts=3)
    player.pictures(3)
    assert player.frame == 0
