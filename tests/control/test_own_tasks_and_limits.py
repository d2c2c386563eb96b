"""A user's task, limit and solver in plain Python, in one program with the library's."""

import copy
import pickle

import numpy as np
import pytest
import qpsolvers

import pilegrasp_ctrl as pg
from arms import ARMS, HOME, nearby, quiet_states, random_states, without_friction

LINK = {"wam7": "link4", "panda": "panda_link4"}


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


class ElbowSide:
    """Keeps a link at a distance to the side: one row, a spring and a damper."""

    def __init__(self, link, side, weight=10.0):
        self.link, self.side, self.root = link, side, np.sqrt(weight)

    def rows(self, state):
        frame = state.frame(self.link)
        wanted = 100.0 * (self.side - frame.translation[1]) - 20.0 * frame.twist[1]
        return pg.Objective(self.root * frame.J[1:2], [self.root * (wanted - frame.Jdot_v[1])])


class Wall:
    """Keeps the tool's x below a wall: the speed toward it stays below 5 / s times the distance."""

    hard = False

    def __init__(self, x, rate=500.0):
        self.x, self.rate = x, rate

    def rows(self, state):
        T, gain = 2.0 / self.rate, 5.0
        free = (gain * (self.x - state.translation[0]) - (1.0 + gain * T) * state.twist[0]) / T - state.Jdot_v[0]
        return pg.Bounds(state.J[0:1], [-np.inf], [free], ("wall",))


class Qpsolvers:
    """A solver of the user."""

    name = "mine"

    def solve(self, program):
        n = len(program.f)
        rows = np.vstack((np.eye(n), program.G))
        kept = np.isfinite(program.upper), np.isfinite(program.lower)
        G = np.vstack((rows[kept[0]], -rows[kept[1]]))
        h = np.concatenate((program.upper[kept[0]], -program.lower[kept[1]]))
        return qpsolvers.solve_qp(program.H, program.f, G, h, solver="quadprog")


def controlled(arm, solver="daqp"):
    """A tool before a wall that its target is beyond, and an elbow that goes 2 cm to the side."""
    q = HOME[arm.name]
    state = arm.update(q, 0.0 * q)
    side = state.frame(LINK[arm.name]).translation[1] + 0.02
    tool, wall = pg.FrameTask(arm), Wall(state.translation[0] + 0.05)
    tool.set_target(state.pose.moved([0.1, 0.0, 0.0]))
    tasks = [tool, ElbowSide(LINK[arm.name], side), pg.PostureTask(arm, q)]
    return pg.InverseDynamics(arm, tasks, [*pg.limits_of(arm), wall], solver)


@pytest.mark.parametrize("solver", ["daqp", "osqp", "own"])
def test_a_user_s_limit_holds_their_task_is_followed_and_the_limit_is_named(arm, solver):
    controller, q, named = controlled(arm, Qpsolvers() if solver == "own" else solver), HOME[arm.name], set()

    def torque(observation):
        output = controller.step(observation)
        assert output.fallback == ""
        named.update(output.active_limits)
        return output.command.torque

    samples = list(pg.ArmSimulation(arm).run(torque, q, 1.5))
    tips = [arm.update(sample.q, sample.v) for sample in samples]
    wall, side = controller.limits[-1].x, controller.tasks[1].side
    assert max(tip.translation[0] for tip in tips) <= wall + 1e-5
    assert tips[-1].translation[0] == pytest.approx(wall, abs=1e-3)
    assert tips[-1].frame(LINK[arm.name]).translation[1] == pytest.approx(side, abs=1e-3)
    assert "wall upper" in named


def test_without_the_limit_the_tool_goes_through_the_wall(arm):
    controller = controlled(arm)
    free = pg.InverseDynamics(arm, controller.tasks)
    *_, last = pg.ArmSimulation(arm).run(lambda o: free.step(o).command.torque, HOME[arm.name], 1.5)
    assert arm.update(last.q, last.v).translation[0] > controller.limits[-1].x + 0.03


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))])
def test_a_controller_with_a_user_s_parts_is_copied_with_them(arm, copied):
    original, q = controlled(arm), HOME[arm.name]
    for index, (q, v) in enumerate(quiet_states(arm, 5)):
        original.step(pg.Observation(0.002 * index, q, v))
    twin = copied(original)
    for index, (q, v) in enumerate(quiet_states(arm, 20)):
        observation = pg.Observation(0.01 + 0.002 * index, q, v)
        one, other = original.step(observation), twin.step(observation)
        np.testing.assert_array_equal(one.command.torque, other.command.torque)


def test_the_program_can_be_looked_at_and_solved_by_others(arm):
    q = HOME[arm.name]
    controller = controlled(arm)
    for q, v in quiet_states(arm, 5):
        controller.reset()
        observation = pg.Observation(0.0, q, v)
        problem = controller.build_qp(observation)
        assert isinstance(problem, qpsolvers.Problem)
        found = qpsolvers.solve_problem(problem, solver="quadprog").x
        np.testing.assert_allclose(found, controller.step(observation).acceleration, atol=1e-6)


def test_multipliers_say_which_limit_holds_the_solution_back(arm):
    weak = without_friction(arm.name, torque_limit=0.4 * arm.torque_limit)
    controller, seen = pg.OperationalSpaceController(weak, posture=HOME[arm.name]), 0
    for q, v in random_states(weak, 40):
        controller.tool.set_target(nearby(weak.update(q, v)))
        observation = pg.Observation(0.0, q, v)
        forces = controller.multipliers(observation)
        output = controller.step(observation, controller.tool.target)
        controller.reset()
        assert set(forces) <= set(output.active_limits)
        seen += bool(forces)
        assert all((value > 0.0) == name.endswith("lower") for name, value in forces.items())
        assembly = controller.assemble(observation)
        held = assembly.program.H @ output.acceleration + assembly.program.f
        if not forces:
            np.testing.assert_allclose(held, 0.0, atol=1e-5)
    assert seen > 10


def test_a_hard_limit_holds_where_a_soft_one_gives_way():
    arm = without_friction("panda")
    q = HOME["panda"]
    state = arm.update(q, 0.0 * q)

    class Push(Wall):
        def rows(self, state):
            return pg.Bounds(state.J[0:1], [1e3], [np.inf], ("push",))

    def acceleration(hard):
        push = Push(0.0)
        push.hard = hard
        controller = pg.InverseDynamics(arm, [pg.PostureTask(arm, q)], ["torque", push], friction=False)
        return controller.step(pg.Observation(0.0, q, 0.0 * q))

    soft, hard = acceleration(False), acceleration(True)
    assert soft.fallback == ""
    assert (state.J @ soft.acceleration)[0] > 1.0
    assert "found no accelerations" in hard.fallback


class Broken:
    """Returns what a test asks for."""

    hard = True

    def __init__(self, answer):
        self.answer = answer

    def rows(self, state):
        return self.answer


@pytest.mark.parametrize(
    ("task", "message"),
    [
        (
            Broken(pg.Objective(np.zeros((2, 6)), np.zeros(2))),
            r"Broken.rows must return Objective\(A \(m, 7\), b \(m,\)\)",
        ),
        (Broken(pg.Objective(np.zeros((2, 7)), np.zeros(3))), "Broken.rows must return Objective"),
        (Broken(None), "Broken.rows must return Objective"),
        (Broken("ab"), "Broken.rows must return Objective"),
        ("tool", "'tool' is no task"),
        (Broken, "is no task"),
        (None, "None is no task"),
    ],
)
def test_what_is_no_task_or_has_wrong_rows_is_named(task, message):
    arm = without_friction("panda")
    with pytest.raises(pg.ConfigurationError, match=message):
        pg.InverseDynamics(arm, [task]).step(pg.Observation(0.0, np.zeros(7), np.zeros(7)))


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        (Broken(pg.Bounds(np.zeros((1, 6)), [0.0], [1.0], ("x",))), "Broken.rows must return Bounds"),
        (Broken(pg.Bounds(None, [0.0], [1.0], ("x",))), "Broken.rows must return Bounds"),
        (Broken(pg.Bounds(np.zeros((1, 7)), [0.0], [1.0], ())), "Broken.rows must return Bounds"),
        (Broken(3.0), "Broken.rows must return Bounds"),
        ("power", "no limit 'power'; the limits are torque, velocity, position"),
        (ElbowSide("link4", 0.3), "is no limit; a limit has the attribute hard"),
        (Wall(0.5, rate=1000.0), "made for 1000 Hz"),
    ],
)
def test_what_is_no_limit_or_has_wrong_rows_is_named(limit, message):
    arm = without_friction("panda")

    def step():
        controller = pg.InverseDynamics(arm, [pg.PostureTask(arm)], [limit])
        controller.step(pg.Observation(0.0, HOME["panda"], np.zeros(7)))

    with pytest.raises(pg.ConfigurationError, match=message):
        step()


def test_a_task_that_is_not_finite_gives_a_fallback_and_not_a_wrong_torque(arm):
    broken = Broken(pg.Objective(np.full((1, 7), np.nan), np.zeros(1)))
    q = HOME[arm.name]
    output = pg.InverseDynamics(arm, [broken, pg.PostureTask(arm)]).step(pg.Observation(0.0, q, 0.0 * q))
    assert "not finite" in output.fallback
    np.testing.assert_allclose(output.command.torque, arm.update(q, 0.0 * q).h)


def test_a_task_without_a_target_is_named(arm):
    controller = pg.InverseDynamics(arm, [pg.FrameTask(arm)])
    with pytest.raises(pg.ConfigurationError, match="has no target; call set_target"):
        controller.step(pg.Observation(0.0, HOME[arm.name], np.zeros(7)))


def test_limits_given_as_a_string_or_missing_tasks_are_refused(arm):
    with pytest.raises(pg.ConfigurationError, match="must be a list"):
        pg.InverseDynamics(arm, [pg.FrameTask(arm)], "torque")
    with pytest.raises(pg.ConfigurationError, match="needs a task"):
        pg.InverseDynamics(arm, [])
