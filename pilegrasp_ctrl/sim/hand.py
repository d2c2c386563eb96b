"""The simulated hand: a folder with a model and a `robot.toml`, and the changes of a scenario's `hand_model`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from .. import hand_folder
from ..exceptions import ModelError
from ..hand_description import BUILDER_PARAMETERS, HandDescription, vary
from ..planning.hand_use import HandUse
from ..plugins import explain, load_plugin
from ..sections import HandModelConfig
from ..types import Array, MassProperties, Pose
from .contact import END_EFFECTOR_RANK, Surface
from .hand_drive import HandDrive
from .hand_geometry import at_rest, half_width_of, heel_of, mass_properties_of, outline_of
from .hand_mjcf import PREFIX, add_mjcf_hand, hand_spec
from .hand_parts import add_wrist_sensor, finger_directions
from .pad import Pad


@dataclass(frozen=True)
class Hand:
    """An end-effector: its bodies for a scene, and the numbers for controller and primitives.

    Attributes:
        name: Name of its folder.
        parameters: Parsed `robot.toml`, with the scenario's factors and the defaults of sensor and surface.
        folder: Folder of the hand.
    """

    name: str
    parameters: dict[str, Any] = field(repr=False)
    folder: Path = field(repr=False)

    @classmethod
    def load(cls, name: str | Path, model: HandModelConfig | None = None) -> Hand:
        """Read a hand with the changes of the scenario's `hand_model`, if any.

        Args:
            name: Name of a hand that ships, or its folder: a `Path`, or a text with a slash.
            model: Changes of its numbers.

        Raises:
            ModelError: No hand has this name, or its folder does not describe a hand.
        """
        source = f"{name}/" if isinstance(name, Path) else name
        parameters, label = hand_folder.parameters(source), hand_folder.label(source)
        description = HandDescription.of(parameters, label)
        for table in ("sensor", "surface"):
            parameters[table] = getattr(description, table).model_dump() | parameters.get(table, {})
        return cls(label, vary(parameters, model) if model else parameters, hand_folder.folder(source))

    @cached_property
    def description(self) -> HandDescription:
        """The checked tables of `robot.toml`, with the scenario's factors."""
        return HandDescription.of(self.parameters, self.name)

    def add_to(self, spec: mujoco.MjSpec, flange: Any) -> None:
        """Mount wrist sensor and hand on the site `flange` of `spec`, as the body `sensor` and its children.

        None of their geoms collides by itself: a scene adds the contact pairs that it needs.

        Raises:
            ModelError: The hand's MJCF or builder cannot be used.
        """
        known = {actuator.name for actuator in spec.actuators}
        body = flange.parent.add_body(name="sensor", pos=flange.pos, quat=flange.quat)
        add_wrist_sensor(spec, body, self.parameters["sensor"])
        mount = self.description.hand
        if mount.builder is not None:
            builder = load_plugin(mount.builder, f"{self.name}: hand.builder", BUILDER_PARAMETERS, named=True)
            try:
                builder.function(spec, body, self.parameters)
            except Exception as error:
                raise ModelError(f"{self.name}: hand.builder = {mount.builder!r} failed: {explain(error)}") from error
        else:
            add_mjcf_hand(spec, body, self.folder, self.description)
        for geom in body.find_all("geom"):
            geom.contype = geom.conaffinity = 0
        force = self.description.use.closing_force
        if force is not None:
            for actuator in spec.actuators:
                if actuator.name not in known:
                    actuator.forcelimited, actuator.forcerange = True, [-force, force]

    def standalone_spec(self) -> mujoco.MjSpec:
        """Return a spec of sensor and hand on a fixed flange."""
        spec = mujoco.MjSpec()
        spec.compiler.degree = False
        self.add_to(spec, spec.worldbody.add_site(name="flange"))
        return spec

    @cached_property
    def model(self) -> mujoco.MjModel:
        """Compiled sensor and hand on a fixed flange.

        Raises:
            ModelError: MuJoCo cannot compile them.
        """
        try:
            return self.standalone_spec().compile()
        except ValueError as error:
            reason = str(error).strip().replace("\n", ", ")
            raise ModelError(f"{self.name}: MuJoCo cannot compile the hand: {reason}") from None

    @cached_property
    def contact_geoms(self) -> tuple[str, ...]:
        """Names of the geoms that touch objects and table: the sensor's housing, and what `contact_geoms` says.

        Raises:
            ModelError: The hand has no geom of a stated name.
        """
        names = [geom.name for geom in self.standalone_spec().geoms]
        mount = self.description.hand
        prefix = PREFIX if mount.mjcf else ""
        if mount.contact_geoms is not None:
            touching = {prefix + name for name in mount.contact_geoms}
        elif mount.mjcf:
            own = hand_spec(self.folder, mount.mjcf).geoms
            touching = {prefix + geom.name for geom in own if geom.contype or geom.conaffinity}
        else:
            touching = set(names)
        for name in touching.difference(names):
            raise ModelError(
                f"{self.name}: contact_geoms names {name.removeprefix(prefix)!r}, which is no geom of the hand; "
                f"choose from {', '.join(other.removeprefix(prefix) for other in names if other != 'sensor')}"
            )
        return tuple(name for name in names if name in touching or name == "sensor")

    @cached_property
    def pads(self) -> Mapping[str, Pad]:
        """The soft geoms by name.

        Raises:
            ModelError: A pattern of `pad.geoms` matches no geom that touches.
        """
        table = self.description.pad
        names = [name for pattern in table.geoms for name in self._matching("pad.geoms", pattern)]
        return {name: Pad(table.give, self.inverse_mass(name)) for name in names}

    @cached_property
    def touching_pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of the hand's own geoms that touch one another.

        Raises:
            ModelError: A pattern of `touch.pairs` matches no geom that touches.
        """
        found: dict[tuple[str, str], None] = {}
        for patterns in self.description.touch.pairs:
            for one, other in product(*(self._matching("touch.pairs", pattern) for pattern in patterns)):
                if one != other:
                    found[min(one, other), max(one, other)] = None
        return tuple(found)

    def inverse_mass(self, geom: str) -> float:
        """Return the inverse of the mass with which a geom resists a push, as MuJoCo's `invweight0` has it [1/kg]."""
        return float(self.model.body_invweight0[self.model.geom(geom).bodyid[0], 0])

    def _matching(self, key: str, pattern: str) -> list[str]:
        """Return the geoms that touch and whose names match a pattern of `key`."""
        prefix = PREFIX if self.description.hand.mjcf else ""
        names = [name for name in self.contact_geoms if fnmatchcase(name, prefix + pattern)]
        if not names:
            known = ", ".join(name.removeprefix(prefix) for name in self.contact_geoms)
            raise ModelError(f"{self.name}: {key} has {pattern!r}, which no geom matches; these touch: {known}")
        return names

    @property
    def controller(self) -> str:
        """Name of the hand's default controller."""
        return self.description.hand.controller

    @property
    def theta(self) -> float:
        """Slope of the finger bases (or the scoop's floor) against the table [rad]."""
        return math.radians(self.description.hand.theta_deg)

    @cached_property
    def use(self) -> HandUse:
        """The hand's numbers for planning and primitives."""
        numbers, width = self.description.use, self.description.hand.width
        parts = [name for name in self.contact_geoms if name != "sensor"]
        touching = outline_of(self.model, self.transform_tool_to_flange, parts)
        half_width = half_width_of(touching) if width is None else 0.5 * width
        return HandUse(
            theta=self.theta,
            press_depth=numbers.press_depth,
            normal_force=numbers.normal_force,
            preshape=numbers.preshape,
            closing_time=numbers.closing_time,
            advance=numbers.advance,
            scoop_angle=math.radians(numbers.scoop_angle_deg),
            heel=heel_of(touching) if numbers.heel is None else numbers.heel,
            outline=self.outline(),
            half_width=half_width,
            aim_half_width=half_width if numbers.aim_width is None else 0.5 * numbers.aim_width,
            closes="close" in numbers.can,
        )

    @cached_property
    def drive(self) -> HandDrive:
        """How a closure moves the hand's actuators.

        Raises:
            ModelError: `closure` names an actuator that the hand lacks, or an actuator has no range of controls.
        """
        model, numbers = self.model, self.description.use
        prefix = PREFIX if self.description.hand.mjcf else ""
        names = [model.actuator(index).name for index in range(model.nu)]
        for name in numbers.closure:
            if prefix + name not in names:
                known = ", ".join(other.removeprefix(prefix) for other in names) or "none"
                raise ModelError(f"{self.name}: use.closure names {name!r}; the actuators of the hand are: {known}")
        stated = {prefix + name: ends for name, ends in numbers.closure.items()}
        ends = []
        for index, name in enumerate(names):
            if name not in stated and not model.actuator_ctrllimited[index]:
                raise ModelError(f"{self.name}: actuator {name!r} has no ctrlrange; add it, or add it to use.closure")
            ends.append(stated.get(name, model.actuator_ctrlrange[index]))
        if "close" in numbers.can and not names:
            raise ModelError(f"{self.name}: 'close' needs an actuator, and the hand has none; take it out of use.can")
        opened, closed = np.array(ends, dtype=float).reshape(-1, 2).T
        return HandDrive(opened, closed, numbers.stroke_time)

    @property
    def surface(self) -> Surface:
        """Friction and restitution of the hand."""
        return Surface(**self.parameters["surface"], rank=END_EFFECTOR_RANK)

    @cached_property
    def transform_tool_to_flange(self) -> Pose:
        """Pose of the tool frame: x along the fingers, z normal to the palm, origin in the middle of the fingertips.

        Raises:
            ModelError: The hand has no site of the name `tool_frame`.
        """
        mount = self.description.hand
        if mount.tool_origin is not None:
            along, normal = finger_directions(mount.finger_angle_deg)
            return Pose(np.array(mount.tool_origin), np.column_stack([along, np.cross(normal, along), normal]))
        name = (PREFIX if mount.mjcf else "") + str(mount.tool_frame)
        sites = {self.model.site(index).name: index for index in range(self.model.nsite)}
        if name not in sites:
            known = [site.removeprefix(PREFIX) for site in sites if site not in ("flange", "wrist_sensor")]
            raise ModelError(
                f"{self.name}: tool_frame = {mount.tool_frame!r} is no site of the hand; "
                f"its sites are: {', '.join(known) or 'none'}"
            )
        data = at_rest(self.model)
        return Pose(data.site_xpos[sites[name]], data.site_xmat[sites[name]].reshape(3, 3))

    def outline(self) -> Array:
        """Return balls (n, 4) that span sensor and hand at rest: centre in the tool frame and radius [m]."""
        return outline_of(self.model, self.transform_tool_to_flange)

    def mass_properties(self) -> MassProperties:
        """Return mass, centre of mass and inertia of sensor and hand at rest, in the flange's axes."""
        return mass_properties_of(self.model)
