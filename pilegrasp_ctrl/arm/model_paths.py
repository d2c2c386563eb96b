"""Paths inside a model file of a folder: whatever a received URDF or MJCF names lies in its folder."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

from ..exceptions import ModelError
from ..files import MAX_MESH_SIZE, read_file, resolved

_FOLDERS = ("meshdir", "texturedir", "assetdir")
"""Attributes of MJCF's element compiler that name a folder."""

_PACKAGE = "package://"
"""Beginning of the name of a URDF's mesh that lies in a ROS package."""


def check_paths(file: Path, folder: Path) -> None:
    """Refuse a model file that names a file outside its folder: a mesh, a texture, an include, by path or by link.

    Args:
        file: URDF or MJCF; included files are looked at too.
        folder: Folder of the robot.

    Raises:
        ModelError: The file or one that it names is outside, or it includes itself.
    """
    _check(file, resolved(folder, ModelError), file.parent, ())


def package_folders(file: Path, folder: Path) -> list[str]:
    """Return the folders in which the packages of a URDF's meshes are looked for: those from the file's to the robot's.

    The folder that holds the robot's counts as well, because the robot's own may be the package.
    """
    top, place = resolved(folder, ModelError), resolved(file, ModelError).parent
    above = [place, *place.parents]
    return [str(each) for each in above if each.is_relative_to(top)] + [str(top.parent)]


def _check(file: Path, top: Path, beside: Path, including: tuple[Path, ...]) -> None:
    place = resolved(file, ModelError)
    if place in including:
        raise ModelError(f"{file}: includes itself; take the include out")
    if not place.is_relative_to(top):
        raise ModelError(f"{file}: leads out of the folder {top.name}; copy it into the folder")
    root = _parse(file)
    compilers = [element for element in root.iter() if element.tag == "compiler"]
    folders = [beside / compiler.get(key, "") for compiler in compilers for key in _FOLDERS] or [beside]
    for element in root.iter():
        named = [value for key, value in element.attrib.items() if key.startswith("file") and value]
        named += [element.get(key, "") for key in _FOLDERS if element.tag == "compiler" and element.get(key)]
        for name in named:
            if element.tag == "include":
                _check(beside / name, top, beside, (*including, place))
            elif not all(_is_inside(name, place, file, top) for place in (beside, *folders)):
                raise ModelError(
                    f"{file}: <{element.tag}> names {name!r:.80}, which leads out of the folder {top.name}; copy the "
                    "file into it"
                )


def _is_inside(name: str, place: Path, file: Path, top: Path) -> bool:
    if not name.startswith(_PACKAGE):
        return resolved(place / name.removeprefix("file://"), ModelError).is_relative_to(top)
    found = [Path(each) / name.removeprefix(_PACKAGE) for each in package_folders(file, top)]
    # A mesh that is nowhere is no way out; whoever needs it says that it is missing.
    return (
        all(resolved(each, ModelError).is_relative_to(top) for each in found if os.path.exists(each))
        and ".." not in Path(name).parts
    )


def _parse(file: Path) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(read_file(file, MAX_MESH_SIZE, "of a robot's model", ModelError))
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise ModelError(f"{file}: not a URDF or MJCF file, because it is not XML: {error}") from None
