"""`controller.keep_clear` keeps arm and palm off the walls of a bin, by limits of the scenario's controller."""

import pytest

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.config import build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.strategy import tool_rotation
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.primitives.primitive import Setpoint
from pilegrasp_ctrl.programs.controller import controller_factory
from pilegrasp_ctrl.programs.keep_clear import keep_clear
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.sim.start_posture import StartPosture
from pilegrasp_ctrl.types import Pose, Reference


def parts(**overrides):
    """Return scenario, hand, layout and arm of an order."""
    scenario = load_scenario("bin_picking", overrides)
    hand = Hand.load(scenario.hand)
    layout = make_layout(scenario.support, scenario.pile, objects_of(scenario.pile).diameter, scenario.order)
    arm = ArmModel.load(
        scenario.robot,
        tool=hand.mass_properties(),
        tool_frame=hand.transform_tool_to_flange,
        base=layout.transform_base_to_world,
        gravity=layout.gravity,
    )
    return scenario, hand, layout, arm


def test_a_scenario_that_does_not_say_it_keeps_its_hash():
    plain, without, clear = (
        load_scenario("bin_picking", overrides).config_hash()
        for overrides in ({}, {"controller.keep_clear": False}, {"controller.keep_clear": True})
    )
    assert plain == without != clear


def test_it_is_refused_without_a_bin():
    with pytest.raises(ConfigurationError, match=r"controller\.keep_clear has no effect without a bin"):
        build_scenario({}, {"controller.keep_clear": True})


def test_links_and_sensor_keep_off_walls_and_the_palm_off_rims():
    scenario, _, layout, arm = parts()
    links, palm = keep_clear(scenario, arm, layout.walls)
    assert {"collision[link4 | bin_near]", "collision[flange | order_left]"} <= set(links.pairs)
    assert not [name for name in links.pairs if "rim" in name]
    assert set(palm.pairs) == {f"collision[flange | {wall.name} rim]" for wall in layout.walls}
    for wall, rim in zip(layout.walls, palm.obstacles, strict=True):
        top = wall.center[2] + wall.half_size[2]
        assert rim.pose.translation[2] + 0.5 * rim.size[2] == pytest.approx(top)
        assert rim.size[2] == pytest.approx(0.02)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["operational_space", "impedance"])
def test_a_hand_that_is_sent_into_the_near_wall_keeps_its_wrist_off(kind):
    least = {}
    for clear in (False, True):
        scenario, hand, layout, arm = parts(**{"controller.keep_clear": clear, "controller.kind": kind})
        search = StartPosture(scenario.robot, hand.transform_tool_to_flange, layout.transform_base_to_world)
        start = Pose([0.75, 0.0, 0.22], tool_rotation(0.0, hand.theta))
        q = search.solve(start)
        control = controller_factory(scenario, hand, layout.walls)(arm, q)
        target, watch = Reference(start.moved([-0.16, 0.0, -0.20])), keep_clear(scenario, arm, layout.walls)[0]
        distances = []

        def torque(observation, control=control, arm=arm, watch=watch, target=target, distances=distances):
            state = arm.update(observation.q, observation.v)
            distances.append(min(watch.distances(state).values()))
            return control(observation, Setpoint(target, 0.0), state).command.torque

        list(ArmSimulation(arm, substeps=1).run(torque, q, 2.0))
        assert distances[0] > watch.margin
        least[clear] = min(distances)
    assert least[False] < 0.0
    assert least[True] > watch.margin - 1e-3
