"""Quadratic programs that every solver has to solve, with exact answers.

Usage: python tests/helpers/qp_programs.py [record], to prove the answers anew, as after a change of `SOFT_WEIGHT`, or
to record other programs

The programs are those of closed loops of both arms. An optimum is found in rational arithmetic: the active set that a
solver proposes is taken as equations, these are solved without rounding, and every bound and the sign of every
multiplier is compared without rounding. If one is wrong, the set is changed and the equations are solved again. With
H positive definite this proves the optimum, independently of the solver. A combination of its rows proves that a
program has no solution. The file stores the optimum, rounded to the nearest floating-point numbers.
"""

import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import islice

import daqp
import numpy as np
import pytest
import qpsolvers
from scipy.optimize import linprog

from arms import ARMS, HOME, load, simulate, without_friction
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.qp.program import QuadraticProgram, Solver, make_solver
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from places import DATA
from recorded_program import RecordedProgram, load_programs, save_programs

FILE = DATA / "qp_programs.npy"
COUNT = 10
CLEARLY = 1e-3  # smallest gap of an infeasible program [rad/s², N·m]
TINY = Fraction(1, 10**6)
SOLVERS = tuple(dict.fromkeys(("daqp", "osqp", "proxqp", "quadprog", *qpsolvers.available_solvers)))


def installed(name: str) -> Solver:
    """Return the solver of that name; the test is skipped if its package is absent."""
    if name not in ("daqp", "osqp", *qpsolvers.available_solvers):
        pytest.skip(f"pip install 'pilegrasp[{name}]'")
    return make_solver(name)


def recorded() -> tuple[RecordedProgram, ...]:
    return load_programs(FILE)


# What is proved about a program, in rational arithmetic.


def fractions(array) -> np.ndarray:
    """Return the numbers as Fractions; an infinite bound stays a float, which compares with them correctly."""
    return np.vectorize(lambda value: Fraction(value) if np.isfinite(value) else value, otypes=[object])(array)


def solve_exactly(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return A⁻¹ b by Gaussian elimination; a singular A raises ZeroDivisionError."""
    A, b = A.copy(), b.copy()
    n = len(b)
    for column in range(n):
        pivot = next((row for row in range(column, n) if A[row, column] != 0), column)
        A[[column, pivot]], b[[column, pivot]] = A[[pivot, column]], b[[pivot, column]]
        for row in range(column + 1, n):
            if A[row, column] != 0:
                factor = A[row, column] / A[column, column]
                A[row, column:] -= factor * A[column, column:]
                b[row] -= factor * b[column]
    x = np.zeros(n, dtype=object)
    for row in reversed(range(n)):
        x[row] = (b[row] - A[row, row + 1 :] @ x[row + 1 :]) / A[row, row]
    return x


def positive_definite(H: np.ndarray) -> bool:
    H = fractions(H)
    for k in range(len(H)):
        if H[k, k] <= 0:
            return False
        H[k + 1 :, k + 1 :] -= np.outer(H[k + 1 :, k], H[k, k + 1 :]) / H[k, k]
    return True


def exact_optimum(problem: QuadraticProgram, guess: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x (n,) and multipliers (n + m,) as Fractions, from a guess of the signs of the multipliers."""
    H, f, G, lower, upper = (fractions(array) for array in problem)
    if not positive_definite(problem.H):
        raise ValueError("H is not positive definite")
    n = len(f)
    rows = np.vstack((fractions(np.eye(n)), G))
    side = np.sign(guess).astype(int)
    for _ in range(50):
        active = np.flatnonzero(side)
        C, bound = rows[active], np.where(side[active] > 0, lower[active], upper[active])
        zero = fractions(np.zeros((len(active), len(active))))
        solved = solve_exactly(np.block([[H, -C.T], [C, zero]]), np.concatenate((-f, bound)))
        x, multipliers = solved[:n], fractions(np.zeros(len(rows)))
        multipliers[active] = solved[n:]
        values = rows @ x
        pulled = (side != 0) & (multipliers * side < 0) & (lower != upper)
        missing = np.where(values < lower, 1, np.where(values > upper, -1, 0))
        if not pulled.any() and not missing.any():
            return x, multipliers
        side = np.where(missing != 0, missing, np.where(pulled, 0, side))
    raise ValueError("no active set was right")


def kkt_residual(problem: QuadraticProgram, x: np.ndarray, multipliers: np.ndarray) -> float:
    """Return the largest violation of the optimality conditions, relative to the terms of its sum.

    It is evaluated without rounding, so that it belongs to the given numbers: stationarity, bounds, and for each
    multiplier the distance to the bound of its sign.
    """
    H, f, G, lower, upper = (fractions(array) for array in problem)
    x, multipliers = fractions(x), fractions(multipliers)
    rows = np.vstack((fractions(np.eye(len(f))), G))
    terms = (H * x, f[:, None], -rows.T * multipliers)
    worst = [abs(sum(row)) / max(sum(abs(row)), TINY) for row in np.hstack(terms)]
    for row, low, high, multiplier in zip(rows, lower, upper, multipliers, strict=True):
        value, size = row @ x, sum(abs(row * x)) + TINY
        gap = max(low - value, value - high, 0)
        if multiplier != 0:
            gap = max(gap, value - low if multiplier > 0 else high - value)
        worst.append(gap / size)
    return float(max(worst))


def gap_of(certificate: np.ndarray, problem: QuadraticProgram) -> Fraction:
    """Return min yᵀ z over z within the bounds on G x, less max yᵀ G x over x within its bounds.

    A positive gap proves that no x exists. The unit is the relaxation that all bounds together would need.
    """
    _, _, G, lower, upper = (fractions(array) for array in problem)
    y, n = fractions(certificate), len(problem.f)
    c = y @ G
    least = sum(min(a * low, a * high) for a, low, high in zip(y, lower[n:], upper[n:], strict=True))
    most = sum(max(a * low, a * high) for a, low, high in zip(c, lower[:n], upper[:n], strict=True))
    return (least - most) / max(sum(abs(y)) + sum(abs(c)), TINY)


def find_certificate(problem: QuadraticProgram) -> np.ndarray:
    """Return the y with the largest `gap_of`, by linear programming over y, Gᵀ y, their sizes and both sums' terms."""
    _, _, G, lower, upper = problem
    n, m = len(problem.f), len(G)
    Y, C, Z = np.eye(m, 4 * m + 3 * n), np.hstack((G.T, np.zeros((n, 3 * m + 3 * n)))), np.zeros((1, 4 * m + 3 * n))
    size_y, size_c = np.roll(Y, m, axis=1), np.eye(n, 4 * m + 3 * n, 2 * m)
    least, most = np.eye(m, 4 * m + 3 * n, 2 * m + n), np.eye(n, 4 * m + 3 * n, 3 * m + n)
    Z[0, m : 2 * m + n] = 1.0
    rows = [sign * Y - size_y for sign in (-1.0, 1.0)] + [sign * C - size_c for sign in (-1.0, 1.0)]
    rows += [least - bound[n:, None] * Y for bound in (lower, upper)]
    rows += [bound[:n, None] * C - most for bound in (lower, upper)]
    A = np.vstack((*rows, Z))
    cost = most.sum(axis=0) - least.sum(axis=0)
    answer = linprog(cost, A, np.append(np.zeros(len(A) - 1), 1.0), bounds=(None, None))
    return answer.x[:m]


# The loops whose programs are recorded.


def loop(arm: ArmModel, q, displacement, speed: float, weight: float = 1e-4, push=None, ticks: int | None = None):
    """Track a line from rest at q; return active limits, program and smallest singular value of J of every tick."""
    controller = OperationalSpaceController(arm, posture=PostureTask(arm, q, weight=weight))
    line = StraightLine(arm.update(q, np.zeros(arm.nv)).pose, displacement, speed)
    seen = []

    def step(observation):
        output = controller.step(observation, line.at(observation.time))
        program = QuadraticProgram(*(np.array(array) for array in controller.assemble(observation).program))
        smallest = np.linalg.svd(arm.update(observation.q, observation.v).J)[1][-1]
        seen.append((output.active_limits, program, smallest))
        return output.command.torque

    external = None if push is None else lambda q, v: push
    for _ in islice(simulate(arm, step, q, line.duration, external=external), ticks):
        pass
    return seen


def pushed(name: str, share: float, seeds: range, torque: float, velocity: float = 1.0) -> Iterator[tuple]:
    """Yield the ticks of loops with weak drives under constant external torques of `share` times the true limits."""
    true = load(name)
    changes = {"torque_limit": torque * true.torque_limit, "velocity_limit": velocity * true.velocity_limit}
    if true.joint_to_motor is not None:
        changes |= {
            "joint_to_motor": true.joint_to_motor,
            "motor_torque_limit": 0.99 * torque * true.motor_torque_limit,
        }
    for seed in seeds:
        push = share * true.torque_limit * np.random.default_rng(seed).choice([-1.0, 1.0], 7)
        yield from loop(without_friction(name, **changes), HOME[name], [0.0, 0.1, 0.05], 0.5, push=push, ticks=100)


def named(*kinds: str) -> Callable[[tuple[str, ...]], bool]:
    return lambda limits: any(name.startswith(kinds) for name in limits)


def ticks_of(name: str) -> dict[str, list]:
    """Return the candidate ticks of each kind of program."""
    q, true = HOME[name], load(name)
    home = without_friction(name)
    slow = without_friction(name, velocity_limit=0.2 * true.velocity_limit)
    narrow = without_friction(
        name, q_lower=np.maximum(true.q_lower, q - 0.1), q_upper=np.minimum(true.q_upper, q + 0.1)
    )
    stretched, wrist = q.copy(), q.copy()
    stretched[3] = 0.25 if name == "wam7" else -0.35
    wrist[5] = 0.02
    weak = [tick for share in (0.1, 0.2) for tick in pushed(name, share, range(3), 0.3)]
    ticks = {
        "nominal": [tick for tick in loop(home, q, [0.0, 0.2, 0.05], 0.25) if not tick[0]],
        "torque": [tick for tick in weak if named("torque", "motor")(tick[0])],
        "velocity": loop(slow, q, [0.0, 0.25, 0.1], 0.5),
        "position": loop(narrow, q, [0.0, 0.25, 0.1], 0.3),
        "infeasible": [*pushed(name, 0.3, range(2), 0.3), *pushed(name, 0.3, range(2, 4), 0.3, 0.3)],
        "stretched": [*loop(home, stretched, [0.1, 0.1, 0.0], 0.25), *loop(slow, stretched, [0.0, 0.2, 0.2], 0.5)],
        "wrist": [*loop(home, wrist, [0.1, 0.0, 0.1], 0.25), *loop(home, wrist, [0.0, 0.1, 0.1], 0.25)],
        "weight": [
            *loop(home, q, [0.0, 0.2, 0.05], 0.25, weight=1e-8),
            *loop(slow, q, [0.0, 0.25, 0.1], 0.5, weight=1e-8),
        ],
    }
    for kind in ("velocity", "position"):
        ticks[kind] = [tick for tick in ticks[kind] if named(kind)(tick[0])]
    ticks["stretched"] = sorted(ticks["stretched"], key=lambda tick: tick[2])[: 60 * COUNT]
    return ticks


def varied(ticks: list) -> Iterator[QuadraticProgram]:
    """Yield every program once, new active sets first."""
    groups: dict[tuple[str, ...], list] = {}
    for limits, program, _ in ticks:
        groups.setdefault(limits, []).append(program)
    rank = 0
    while groups:
        # The golden ratio's multiples are spread evenly, however many of them there are.
        for limits in list(groups):
            yield groups[limits].pop(int(rank * 0.618034 * len(groups[limits])) % len(groups[limits]))
            if not groups[limits]:
                del groups[limits]
        rank += 1


def prove(name: str, kind: str, problem: QuadraticProgram) -> RecordedProgram | None:
    """Return the program with its proof, or None if it is of another kind."""
    n = len(problem.f)
    feasible = make_solver("daqp").solve(problem) is not None
    if feasible == (kind == "infeasible"):
        return None
    certificate = np.zeros(n)
    if not feasible:
        certificate = find_certificate(problem)
        if gap_of(certificate, problem) < CLEARLY:
            return None
    solved = problem if feasible else problem.softened()
    kinds = np.zeros(len(solved.lower), dtype=np.int32)
    # DAQP's multipliers have the other sign.
    guess = -daqp.solve(solved.H, solved.f, solved.G, solved.upper, solved.lower, kinds, primal_tol=1e-9)[3]["lam"]
    x, multipliers = exact_optimum(solved, guess)
    x, multipliers = x.astype(float), multipliers.astype(float)[-2 * n :]
    excess = np.zeros(n) if feasible else x[n:]
    return RecordedProgram(name, kind, feasible, problem, x[:n], excess, multipliers, certificate)


def record() -> dict[tuple[str, str], list[RecordedProgram]]:
    programs = {}
    for name in sorted(ARMS):
        for kind, ticks in ticks_of(name).items():
            proved = (prove(name, kind, program) for program in varied(ticks))
            programs[name, kind] = list(islice((program for program in proved if program is not None), COUNT))
    return programs


def prove_again() -> dict[tuple[str, str], list[RecordedProgram]]:
    programs: dict[tuple[str, str], list[RecordedProgram]] = {}
    for name, kind, _, problem, *_ in recorded():
        proved = prove(name, kind, problem)
        if proved is None:
            sys.exit(f"{FILE}: a program of {name} is no longer {kind}; record others")
        programs.setdefault((name, kind), []).append(proved)
    return programs


def main() -> None:
    """Write the file and print what is in it."""
    programs = record() if sys.argv[1:] == ["record"] else prove_again()
    for (name, kind), group in programs.items():
        bound = [int((program.multipliers != 0.0).sum()) for program in group]
        print(f"{name:6}{kind:12}{len(group):3} programs with {min(bound)} to {max(bound)} active bounds")
    FILE.parent.mkdir(exist_ok=True)
    save_programs(FILE, [program for group in programs.values() for program in group])
    print(f"{FILE.name}: {FILE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
