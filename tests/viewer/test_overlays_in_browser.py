"""The overlays in a real browser: each shows what was recorded, at its time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pilegrasp_ctrl.viewer.scene.commands import node_path

pytestmark = [pytest.mark.browser, pytest.mark.slow]


NOW = "document.querySelector('.moment').textContent"


OVERLAY = 'pilegrasp.viewer.scene_tree.find(["Overlays", "NAME"]).object'


def overlay(name):
    return OVERLAY.replace("NAME", name)


def switched(browser, *names):
    """Switch these overlays on and the others off, as a user does."""
    browser.evaluate(f"""document.querySelectorAll("[data-overlay]").forEach((box) => {{
      if (box.checked !== {list(names)}.includes(box.dataset.overlay)) box.click();
    }})""")


def test_contact_forces_are_arrows_at_the_recorded_places(paused, attempt):
    switched(paused, "contacts")
    paused.evaluate("pilegrasp.seek(5)")
    arrows = paused.evaluate(f"""{overlay("contacts")}.children[0].children.map((mesh) => {{
      const matrix = new MeshCat.THREE.Matrix4();
      if (mesh.count) mesh.getMatrixAt(0, matrix);
      const color = mesh.material.color.getHex();
      return {{ count: mesh.count, color, place: matrix.elements.slice(12, 15), length: matrix.elements.slice(4, 7) }};
    }})""")
    # One on the hand, one from the table, and both directions between two balls; each with shaft and head.
    assert [arrow["count"] for arrow in arrows] == [1, 1, 1, 1, 2, 2]
    shaft, head = arrows[:2]
    frame = int(np.searchsorted(attempt.frame_time, 5.0, side="right")) - 1
    np.testing.assert_allclose(shaft["place"], attempt.contacts.position[attempt.contacts.at(frame)][0], atol=1e-4)
    np.testing.assert_allclose(np.add(shaft["length"], head["length"]), (-0.08, 0.0, 0.0), atol=1e-4)
    switched(paused)
    assert paused.evaluate(f"{overlay('contacts')}.children[0].visible") is False
    switched(paused, "contacts")
    paused.evaluate("pilegrasp.seek(1)")
    assert paused.evaluate(f"{overlay('contacts')}.children[0].children.map((mesh) => mesh.count)") == [0] * 6


def test_trails_end_where_the_objects_are(paused, attempt):
    switched(paused, "trails")
    paused.evaluate("pilegrasp.seek(5.21)")
    ends = paused.evaluate(f"""{overlay("trails")}.children[0].children.map(({{ geometry }}) => {{
      const last = geometry.drawRange.count - 1;
      return [0, last].map((k) => [0, 1, 2].map((axis) => geometry.attributes.position.array[3 * k + axis]));
    }})""")
    objects = [body.role == "object" for body in attempt.bodies]
    moved = np.ptp(attempt.body_position[:, objects], axis=0).max(axis=1) > 1e-3
    begins = attempt.body_position[0, objects][moved]
    frame = np.interp(5.21, attempt.frame_time, np.arange(len(attempt.frame_time)))
    share, frame = np.modf(frame)
    near = attempt.body_position[:, objects][:, moved]
    now = (1 - share) * near[int(frame)] + share * near[int(frame) + 1]
    assert len(ends) == moved.sum()
    np.testing.assert_allclose([end[0] for end in ends], begins, atol=0.3e-3)
    np.testing.assert_allclose([end[1] for end in ends], now, atol=0.4e-3)


def test_the_motion_field_belongs_to_the_push(paused):
    switched(paused, "field")
    shown = f"{overlay('field')}.children[0].visible"
    counts = f"{overlay('field')}.children[0].children.filter((c) => c.isInstancedMesh).map((c) => c.count)"
    seen = {}
    for moment in (1.0, 5.0, 9.0):
        paused.evaluate(f"pilegrasp.seek({moment})")
        seen[moment] = paused.evaluate(shown)
    assert seen == {1.0: False, 5.0: True, 9.0: False}
    paused.evaluate("pilegrasp.seek(5)")
    inside, _, outside, _ = paused.evaluate(counts)
    assert inside > 0
    assert inside + outside <= 18
    switched(paused)
    assert paused.evaluate(shown) is False


def test_the_separated_object_is_outlined_from_its_moment_on(paused, attempt):
    switched(paused, "separated")
    names = [body.name for body in attempt.bodies]
    index = names.index("light_sphere_01")
    path = [*node_path(index, attempt.bodies[index]).strip("/").split("/"), "<object>"]
    skins = f"""(() => {{
      const found = [];
      const {{ object }} = pilegrasp.viewer.scene_tree.find({path});
      object.traverse((c) => c.isMesh && c.material.side === 1 && found.push(c.visible));
      return found;
    }})()"""
    for moment, visible in ((5.4, False), (5.6, True), (9.0, True)):
        paused.evaluate(f"pilegrasp.seek({moment})")
        assert paused.evaluate(skins) == [visible] * 2
    switched(paused)
    assert paused.evaluate(skins) == [False] * 2


def test_fingers_are_bent_tubes_that_end_at_their_tips(paused, attempt):
    paused.evaluate(f"pilegrasp.seek({attempt.frame_time[250]})")
    tubes = paused.evaluate("""(() => {
      const found = [];
      pilegrasp.viewer.scene_tree.find(["Hand"]).object.traverse((c) => {
        if (c.name !== "tube") return;
        const position = c.geometry.attributes.position;
        const last = position.count - 1;
        found.push([position.getX(last), position.getY(last), position.getZ(last)]);
      });
      return found;
    })()""")
    names = [body.name for body in attempt.bodies]
    tips = []
    for finger in ("finger0_5", "finger1_5", "finger2_5", "finger3_5", "thumb_3"):
        index = names.index(finger)
        (shape,) = attempt.bodies[index].shapes
        turn = Rotation.from_quat(attempt.body_quaternion[250, index], scalar_first=True)
        end = np.array(shape.position) + np.array([0.0, 0.0, shape.size[0] + shape.size[1]])
        tips.append(attempt.body_position[250, index] + turn.apply(end))
    np.testing.assert_allclose(tubes, tips, atol=1.5e-3)
    index = names.index("finger0_2")
    path = [*node_path(index, attempt.bodies[index]).strip("/").split("/"), "<object>"]
    assert paused.evaluate(f"pilegrasp.viewer.scene_tree.find({path}).object.visible") is False


def test_the_keys_switch_overlays_and_the_camera(paused):
    switched(paused, "wrench")
    key = "document.body.dispatchEvent(new KeyboardEvent('keydown', {key: KEY, bubbles: true}))"
    assert paused.evaluate(f"{overlay('wrench')}.visible") is True
    paused.evaluate(key.replace("KEY", "'1'"))
    assert paused.evaluate(f"{overlay('wrench')}.visible") is False
    paused.evaluate(key.replace("KEY", "'3'"))
    assert paused.evaluate(f"{overlay('paths')}.visible") is True
    height = "pilegrasp.viewer.camera.position.clone().sub(pilegrasp.viewer.controls.target).normalize().y"
    paused.evaluate(key.replace("KEY", "'t'"))
    assert paused.evaluate(height) > 0.99
    paused.evaluate(key.replace("KEY", "'r'"))
    assert paused.evaluate(height) < 0.8
