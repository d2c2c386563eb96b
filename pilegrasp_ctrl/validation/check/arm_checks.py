"""Checks of an arm: what its model lacks, how far it reaches with a hand, and what it can carry."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...arm.capsules import arm_capsules
from ...arm.loading import read_model
from ...arm.model import ArmModel
from ...exceptions import ModelError
from ...planning.arm_room import stated_room
from ...planning.simulated_arm import simulated_arm
from ...programs.derived_room import base_below_table, room_of
from ...robots import description, folder_of
from ...sim.hand import Hand
from ...sim.start_posture import StartPosture
from ...types import STANDARD_GRAVITY, Array, Pose
from .reach import ReachSearch
from .registry import Finding, Level, Subject, checks

LEAST_PUSH = 17.0
"""Force that every push should be able to end at, the scenarios' F_grasp [N]."""


@checks("model")
def model(subject: Subject) -> Iterator[Finding]:
    """Say what a bare model holds, and how it becomes the folder of an arm."""
    file = Path(subject.name)
    if subject.tool_frame is None:
        # The refusal of a frame that does not exist names those that do.
        try:
            read_model(file, "", subject.joints, (), {})
        except ModelError as error:
            frames = str(error).partition("; ")[2] or str(error)
            yield Finding("problem", "tool frame", f"give --tool-frame, the frame that carries the hand; {frames}")
        return
    read, numbers = read_model(file, subject.tool_frame, subject.joints, (), {})
    yield from _numbers(ArmModel(read, subject.tool_frame, **numbers))
    yield Finding("fact", "folder", "add --write DIR to make the folder of an arm from it")


@checks("arm")
def numbers(subject: Subject) -> Iterator[Finding]:
    """Say what the folder states, and what it lacks."""
    arm = ArmModel.load(_arm(subject))
    yield from _numbers(arm)
    folder = folder_of(_arm(subject))
    for gains in ("operational_space.toml", "impedance.toml"):
        if not (folder / gains).is_file():
            yield Finding("note", "gains", f"it has no {gains}, so the gains of an arm that nobody has tuned are used")
    table = description(_arm(subject))
    for key, what in (("room", "where it stands and how far it reaches"), ("postures", "where its searches begin")):
        if key not in table:
            yield Finding("note", key, f"robot.toml has no [{key}], so {what} is derived at each start")


@checks("arm")
def simulation(subject: Subject) -> Iterator[Finding]:
    """Build the simulated arm."""
    described = simulated_arm(_arm(subject))
    StartPosture(_arm(subject), Pose(np.zeros(3)), Pose(np.zeros(3)))
    beside = ", ".join(described.beside_table)
    yield Finding("fact", "contacts", f"the links that may be beside the table, below its top, are {beside}")


@checks("arm")
def reach(subject: Subject) -> Iterator[Finding]:
    """Say how far each hand reaches, whether that agrees with what is stated, and what the arm can carry there."""
    robot = _arm(subject)
    stated, described, bare = stated_room(robot), simulated_arm(robot), ArmModel.load(robot)
    shapes = arm_capsules(robot, bare)
    for name in subject.hands:
        hand = Hand.load(name)
        room = room_of(robot, hand)
        arm = ArmModel.load(robot, tool=hand.mass_properties(), tool_frame=hand.transform_tool_to_flange)
        height = room.base_below_table if stated else base_below_table(robot)
        found = ReachSearch(arm, hand.theta, height, shapes, described.beside_table).best(described.postures)
        if found is None:
            yield Finding(
                "problem", f"reach with {name}", f"no posture brings {name} onto a table {height:g} m above the base"
            )
            continue
        yield Finding(
            "fact",
            f"reach with {name}",
            f"its fingertips reach {found.near:.2f} to {found.far:.2f} m from the arm's axis, on a table {height:g} m "
            f"above the base, at least {found.margin:.2f} rad from every joint limit",
        )
        # The longest push gives way to shorter ones, so the shortest one must be in reach.
        for what, distance, short in (
            ("min_touch_distance", room.min_touch_distance, found.near - room.min_touch_distance),
            ("the shortest reach", room.reach[-1], room.reach[-1] - found.far),
        ):
            if short > 0.01:
                yield Finding(
                    "note",
                    f"reach with {name}",
                    f"{what} = {distance:g} m in [room] is {1000 * short:.0f} mm beyond what this search found",
                )
        yield from _strength(arm, name, found.postures)


def _numbers(arm: ArmModel) -> Iterator[Finding]:
    torques = ", ".join(f"{limit:g}" for limit in arm.torque_limit)
    yield Finding("fact", "joints", f"it has {arm.nv} joints with torque limits of {torques} N·m")
    if not np.isfinite(arm.velocity_limit).all():
        yield Finding("note", "joints", "it has no velocity limits, so nothing limits the speed; state joints.velocity")
    if not arm.friction_coulomb.any() and not arm.friction_viscous.any():
        yield Finding("note", "joints", "it has no joint friction, which real arms have; state joints.friction_coulomb")
    if not np.any(arm.pinocchio_model.armature):
        yield Finding("note", "joints", "it has no inertia of its drives; state joints.armature")
    for joint, lower, upper in zip(arm.joint_names, arm.q_lower, arm.q_upper, strict=True):
        if not np.isfinite([lower, upper]).all():
            yield Finding("note", "joints", f"{joint} has no position limits")


def _strength(arm: ArmModel, hand: str, postures: tuple[Array, ...]) -> Iterator[Finding]:
    """Say what the torque limits leave for a load and for a push, in the weakest posture."""
    load, push = np.inf, np.inf
    for q in postures:
        state = arm.update(q, np.zeros(arm.nv))
        left = arm.torque_limit - arm.friction_coulomb
        down, along = -STANDARD_GRAVITY[2] * state.J[2], state.J[0]
        load = min(load, _largest(state.h, down, left))
        # The table pushes back against the motion.
        push = min(push, _largest(state.h, along, left))
    yield Finding(
        "problem" if load <= 0.0 else "fact",
        f"payload with {hand}",
        f"beyond {hand} it holds up to {max(0.0, load):.1f} kg anywhere on its way, standing still",
    )
    level: Level = "problem" if push < LEAST_PUSH else "fact"
    yield Finding(level, f"push with {hand}", f"it pushes with up to {max(0.0, push):.0f} N anywhere on its way")


def _largest(bias: Array, share: Array, limit: Array) -> float:
    """Return the largest x for which every |bias + x share| stays within the limit."""
    room = np.where(share >= 0.0, limit - bias, limit + bias)
    size = np.abs(share)
    return float(np.min(np.where(size > 1e-9, room / np.maximum(size, 1e-9), np.where(room >= 0.0, np.inf, 0.0))))


def _arm(subject: Subject) -> str:
    """Return the name of an arm as a scenario takes it: a folder's path has a slash."""
    return f"{subject.name}/" if Path(subject.name).is_dir() and "/" not in subject.name else subject.name
