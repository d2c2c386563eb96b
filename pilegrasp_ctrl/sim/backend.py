"""The backend of an attempt: the few methods through which the closed loop reaches a robot and its scene."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..exceptions import ConfigurationError
from ..recording_parts import Body
from ..types import Array, Observation


class SceneView(Protocol):
    """What recordings and live pages show: the drawn bodies of a scene and the contacts between them."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The B drawn bodies, at least one; they are the same throughout the attempt."""

    def poses(self) -> tuple[Array, Array]:
        """Return the positions (B, 3) [m] and quaternions (B, 4) wxyz of the bodies, body to scene."""

    def contacts(self) -> tuple[NDArray[np.int32], Array, Array]:
        """Return the bodies (K, 2), positions (K, 3) [m] and forces (K, 3) [N] of the contacts.

        A row of the bodies holds two indices in `bodies`. The force is what the second body does to the first.
        """


class Backend(Protocol):
    """A robot with a hand among objects, advanced one control period at a time.

    The loop of an attempt (`episode.run_attempt`) reaches robot and scene through these methods alone. Each control
    period it calls `observe`, `apply`, `step` and `find_collision`, in this order. A robot in a laboratory offers the
    first four methods itself. It needs a camera for `object_poses`, and `view` may be None.

    Arrays that a method returns belong to the caller: a later step does not change them. Arrays that a method takes
    are only read during the call. Wrenches are in the world axes of the arm's model, poses in the frame of the scene.
    """

    def observe(self) -> Observation:
        """Return time, joint angles, joint velocities and wrench; called once a control period."""

    def tare(self) -> None:
        """Take the last wrench as zero, and forget a saturated sensor; called while nothing touches the hand."""

    def apply(self, torque: Array, closure: float) -> None:
        """Command the joint torques (nv,) [N·m] and the hand's closure in [0, 1]; they hold until the next call."""

    def step(self) -> None:
        """Advance by one control period: integrate it, or wait for it.

        Raises:
            SimulationError: What happens cannot be believed any more; the attempt has no result.
        """

    def find_collision(self) -> str | None:
        """Return a sentence that names a contact which the robot must not make, or None; the primitive then fails."""

    def object_poses(self) -> Array:
        """Return the present poses (n, 7) of the objects: position [m] and quaternion wxyz.

        Only a verdict and an order's operator use them, no primitive.
        """

    @property
    def view(self) -> SceneView | None:
        """What recordings and live pages show; None if the backend draws nothing."""


def check_backend(backend: Backend, *, drawn: bool) -> None:
    """Check that a backend has every method, and a view if the attempt is `drawn`: recorded, or shown to an observer.

    Raises:
        ConfigurationError: It has not.
    """
    name = type(backend).__name__
    missing = [member for member in dir(Backend) if not member.startswith("_") and not hasattr(backend, member)]
    if missing:
        raise ConfigurationError(
            f"the backend {name} has no {', '.join(missing)}; it needs all that pilegrasp_ctrl.sim.backend.Backend has"
        )
    if drawn and backend.view is None:
        raise ConfigurationError(
            f"the view of the backend {name} is None, so it draws nothing; give it a view, or run the attempt without "
            "record and on_frame"
        )
