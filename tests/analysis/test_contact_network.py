"""Force chains: known contacts give known chains."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from pilegrasp_ctrl.analysis.contact_network import force_chains
from pilegrasp_ctrl.analysis.motion import measure
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pilegrasp_ctrl.recording_parts import Contacts
from pushed_pile import RESTLESS, moving, push_recording


def with_contacts(bodies: list[tuple[int, int]], forces: list[list[float]], walls: int = 0) -> dict:
    """Return the force chains of four objects (bodies 1 to 4) with the same contacts in each frame."""
    motions = {f"o{k}": moving(0.05 + 0.06 * k, 0.0, 0.02, 0.0) for k in range(1, 5)}
    recording = push_recording(motions, rigid=True)
    wall = replace(recording.bodies[0], name="wall", role="support")
    frames = recording.frame_time.size
    contacts = Contacts(
        start=np.arange(frames + 1) * len(bodies),
        bodies=np.tile(np.array(bodies, dtype=np.int32).reshape(-1, 2), (frames, 1)),
        position=np.zeros((frames * len(bodies), 3)),
        force=np.tile(np.array(forces, dtype=np.float32).reshape(-1, 3), (frames, 1)),
    )
    scene = SimpleNamespace(contacts=contacts, bodies=(*recording.bodies, wall), frame_time=recording.frame_time)
    return force_chains(scene, PushMotion.of(recording))


def test_a_chain_follows_the_strong_contacts_from_the_hand_to_the_wall():
    pairs = [(0, 1), (1, 2), (2, 3), (3, 4), (3, 5)]
    strong = [[-5.0, 0, 0], [-5.0, 0, 0], [-5.0, 0, 0], [0.1, 0, 0], [-5.0, 0, 1.0]]
    found = with_contacts(pairs, strong)
    assert found == {"objects": 3.0, "to_support": 1.0, "at_end": ["o1", "o2", "o3"]}
    resting = [*strong[:4], [0.1, 0.0, 5.0]]
    assert with_contacts(pairs, resting)["to_support"] == 0.0


def test_a_weak_contact_ends_a_chain():
    found = with_contacts([(0, 1), (1, 2), (3, 4)], [[-5.0, 0, 0], [0.1, 0, 0], [9.0, 0, 0]])
    assert found["at_end"] == ["o1"]
    untouched = with_contacts([(3, 4)], [[9.0, 0, 0]])
    assert untouched == {"objects": None, "to_support": None, "at_end": []}


def test_without_contacts_there_are_no_chains():
    recording = push_recording({"a": RESTLESS})
    assert force_chains(recording, PushMotion.of(recording)) is None
    assert "force_chains" not in measure(recording)
