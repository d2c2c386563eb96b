"""A bin with three goals and an order's crate, for tests of orders without a simulation."""

import math

import numpy as np

from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.push_goal import PushGoal
from pilegrasp_ctrl.programs.pick_order import delivery_pose
from pilegrasp_ctrl.sections import OrderConfig, PileConfig, SupportConfig

BIN = {"program": "order", "support.bin": True, "support.tilt_deg": 5.0}
LAYOUT = make_layout(SupportConfig(bin=True), PileConfig(), 0.054, OrderConfig()).with_goals(
    [
        PushGoal("wall", np.array([1.0, 0.0]), 0.0, (-0.03, 0.12), 0.3),
        PushGoal("corner_left", np.array([1.0, 0.19]), math.radians(30.0), (0.0, 0.0), 0.4),
        PushGoal("corner_right", np.array([1.0, -0.19]), math.radians(-20.0), (0.09, 0.12), 0.36),
    ]
)
CRATE, DELIVERY = LAYOUT.order_crate, delivery_pose(LAYOUT, 0.9)
HIGH = np.array([0.85, 0.0, 0.2])
