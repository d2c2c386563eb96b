"""The verdict on the motion pattern follows the measures."""

from pilegrasp_ctrl.scenarios.paper.motion_verdict import motion_verdict


def rows(approach: list[float], spread: list[float], agreed: list[bool | None]) -> list[dict]:
    return [
        {"approach_speed": a, "spread_speed": s, "held": [] if g is None else ["a"], "agreed": g}
        for a, s, g in zip(approach, spread, agreed, strict=True)
    ]


def test_the_verdict_follows_the_numbers():
    fast, wide, narrow = [0.05, 0.06, 0.055], [0.03, 0.031, 0.032], [0.02, 0.021, 0.022]
    good = {"none": rows(fast, wide, [None] * 3), "wall": rows(fast, narrow, [True] * 3)}
    answer = motion_verdict(good | {"corner": rows(fast, narrow, [True] * 3)})
    assert {name: part["verdict"] for name, part in answer.items()} == dict.fromkeys(answer, "holds")
    swapped = {"none": good["wall"], "wall": good["none"], "corner": rows([-x for x in fast], wide, [False] * 3)}
    worse = motion_verdict(swapped)
    assert worse["wall"]["verdict"] == "fails"
    assert worse["approach"]["verdict"] == "fails"
    assert worse["separation"]["agreed"] == 3
    assert worse["separation"]["verdict"] == "fails"
    assert worse["separation"]["ci_low"] < 0.5 < worse["separation"]["ci_high"]
    nothing = motion_verdict(dict.fromkeys(("none", "wall", "corner"), rows([None], [None], [None])))
    assert {part["verdict"] for part in nothing.values()} == {"undecided"}
