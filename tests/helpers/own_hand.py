"""The folder of a hand of the user's own, as small as it can be, for tests to change."""

from pathlib import Path

SCOOP = """\
<mujoco model="scoop">
  <default><geom type="box"/></default>
  <worldbody>
    <geom name="strut" type="capsule" fromto="0 0 0 -0.02 0 0.04" size="0.01" mass="0.05" contype="0" conaffinity="0"/>
    <body name="scoop" pos="-0.02 0 0.16" xyaxes="0.342 0 0.940 0 -1 0">
      <site name="edge"/>
      <geom name="floor" pos="-0.060 0 0.0015" size="0.060 0.070 0.0015" mass="0.2"/>
      <geom name="back" pos="-0.1185 0 0.035" size="0.0015 0.070 0.035" mass="0.08"/>
    </body>
  </worldbody>
</mujoco>
"""
"""MJCF of a scoop with a floor of 0.12 x 0.14 m, a back wall, and a strut that only carries."""

TABLES = {
    "hand": {"mjcf": "scoop.xml", "tool_frame": "edge", "theta_deg": 10.0, "controller": "impedance"},
    "surface": {"lateral": 0.4, "restitution": 0.5},
    "use": {"can": ["scoop"], "scoop_angle_deg": 45.0, "normal_force": 5.0},
}
"""The tables of its `robot.toml`."""


def write_hand(folder, changes=None, model=SCOOP):
    """Write a hand's folder; return it.

    Args:
        folder: Folder to make.
        changes: Dotted keys of `robot.toml` and their values; None takes a key away.
        model: Content of `scoop.xml`; None for none.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    tables = {name: dict(table) for name, table in TABLES.items()}
    for name, value in (changes or {}).items():
        table, _, key = name.partition(".")
        tables.setdefault(table, {})[key] = value
        if value is None:
            del tables[table][key]
    lines = []
    for name, table in tables.items():
        lines += [f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    (folder / "robot.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    if model is not None:
        (folder / "scoop.xml").write_text(model, encoding="utf-8")
    return folder


def _toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else str(value)
