"""CG against Newton by size: a metered step changes nothing, and what is wrong with a step is found."""

from functools import partial

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.experiments.physics.contact_solver import ContactSolver
from pilegrasp_ctrl.experiments.physics.metered_stepper import MeteredStepper
from pilegrasp_ctrl.experiments.physics.solver_by_size import HEADER, SOLVERS, Measured, attempt, fall, rows
from pilegrasp_ctrl.experiments.physics.step_samples import StepSamples
from pilegrasp_ctrl.sim.objects import KINDS
from pilegrasp_ctrl.sim.scene import add_objects, new_spec
from pilegrasp_ctrl.sim.stepper import Stepper

FEW = load_scenario("spheres_wall", {"pile.count": 3})


def colliding(kind: str) -> mujoco.MjData:
    """Three objects on their way into one another in the air."""
    spec = new_spec(1e-3)
    add_objects(spec, KINDS[kind], 3, [], "product")
    data = mujoco.MjData(spec.compile())
    poses, velocities = data.qpos.reshape(3, 7), data.qvel.reshape(3, 6)
    poses[:, :3] = [[0.0, 0.0, 1.0], [0.1, 0.01, 1.01], [0.05, 0.09, 1.0]]
    velocities[:, :2] = [[1.0, 0.3], [-1.0, 0.3], [0.0, -1.0]]
    return data


@pytest.mark.parametrize("kind", ["light_sphere", "cylinder"])
def test_a_metered_step_is_the_same_step(kind):
    plain, metered = colliding(kind), colliding(kind)
    steppers = Stepper(plain.model, plain), MeteredStepper(metered.model, metered, ContactSolver(), 0, 3)
    for _ in range(150):
        for stepper in steppers:
            stepper.step()
    samples = steppers[1].samples()
    assert samples.contacts.max() > 0
    assert samples.object_error.max() < 1e-3
    np.testing.assert_array_equal(plain.qpos, metered.qpos)


def test_a_solution_that_is_not_finished_is_off_and_at_its_limit():
    data = colliding("light_sphere")
    stepper = MeteredStepper(data.model, data, ContactSolver("CG", 1), 0, 3)
    for _ in range(150):
        stepper.step()
    samples = stepper.samples()
    assert samples.iterations.max() == 1
    assert samples.object_error.max() > 1e-3


def test_an_attempt_is_solved_by_what_it_is_given():
    push = FEW.model_copy(update={"program": "push"})
    measured = attempt(push, 0, ContactSolver("Newton", 3))
    assert measured.push.iterations.max() == 3
    assert measured.push.time[0] > 1.0
    assert measured.push.seconds.min() > 0.0
    assert measured.handled.finger_error.max() > 0.0


def test_a_line_for_each_solver():
    lines = rows("3 spheres", partial(fall, FEW), [0, 1], SOLVERS[:2])
    assert [line.split(" | ")[:2] for line in lines] == [["| 3 spheres", "CG, 30"], ["| 3 spheres", "Newton, 30"]]
    assert {line.count("|") for line in lines} == {HEADER.splitlines()[1].count("|")}
    assert " | 1.00 | " in lines[0]


def test_a_wrong_step_is_counted_and_an_idle_one_is_not():
    errors = np.array([0.0, 0.4, 8.0])
    samples = StepSamples(np.arange(3.0), np.full(3, 1e-4), np.ones(3), np.array([1.0, 2.0, 30.0]), errors, errors)
    (line,) = rows("x", lambda seed, solver: Measured(samples, samples.after(0.0), True), [0, 1], SOLVERS[:1])
    assert line == "| x | CG, 30 | 2 of 2 | 1 | 100 | 1.00 | 2 | 30 | 33.3% | 2 of 4 | 8.00 | 8000.0 |"
