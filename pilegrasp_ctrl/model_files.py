"""An MJCF with its includes and meshes, read from one folder and from nowhere else."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from .exceptions import ModelError
from .files import MAX_MESH_SIZE, read_file

MAX_XML_SIZE = 1 << 20
"""Largest XML file of a model that is read [bytes]; chosen, 30 times the largest that ships."""

MAX_FILES = 200
"""Largest number of files of a model that are read [-]; chosen, three times that of a published hand."""

ASSETS = {"mesh": "meshdir", "texture": "texturedir"}
"""Elements that may name a file -> attribute of <compiler> with the folder of that file."""

_FOLDERS = ("assetdir", "meshdir", "texturedir", "strippath")


@dataclass(slots=True)
class ModelText:
    """An MJCF that names no file on disk.

    Attributes:
        root: Root of the XML; the content of included files stands in the place of each <include>.
        assets: Content of every mesh and texture, by the name that the XML gives it.
    """

    root: ElementTree.Element
    assets: dict[str, bytes] = field(default_factory=dict)

    def text(self) -> str:
        """Return the XML as text."""
        return ElementTree.tostring(self.root, encoding="unicode")


def read_mjcf_folder(folder: Path, name: str) -> ModelText:
    """Read an MJCF and all files that it names. The caller hands the result to MuJoCo, which then opens no file.

    A model that somebody else made may therefore not read other files of this machine.

    Args:
        folder: Folder of the model.
        name: Path of the MJCF in this folder.

    Raises:
        ModelError: A file is missing, too large or no MJCF, or a path leads out of the folder.
    """
    files = _Folder(folder)
    root = files.read_xml(_inside(folder, folder, name, "mjcf"))
    directories = _asset_folders(root, folder)
    model = ModelText(root)
    for element in root.iter():
        named = [key for key in element.attrib if key.startswith("file")]
        if not named:
            continue
        if element.tag not in ASSETS or named != ["file"]:
            raise ModelError(
                f"{folder / name}: <{element.tag}> names a file; only {', '.join(ASSETS)} and include may; remove it"
            )
        file = _inside(folder, directories[element.tag], element.attrib["file"], element.tag)
        key = f"{len(model.assets)}{file.suffix.lower()}"
        model.assets[key] = files.read(file, MAX_MESH_SIZE, "of a mesh")
        element.attrib.setdefault("name", file.stem)
        element.attrib["file"] = key
    return model


class _Folder:
    """Reads the files of a model and counts them."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._count = folder, 0

    def read(self, file: Path, limit: int, what: str) -> bytes:
        self._count += 1
        if self._count > MAX_FILES:
            raise ModelError(f"{self._folder}: its model has more than {MAX_FILES} files; join them")
        return read_file(file, limit, what, ModelError)

    def read_xml(self, file: Path, including: tuple[Path, ...] = ()) -> ElementTree.Element:
        """Return the root of an MJCF, with the children of each included file in the place of its <include>."""
        try:
            root = ElementTree.fromstring(self.read(file, MAX_XML_SIZE, "of a model"))
        except (ElementTree.ParseError, LookupError, ValueError, RecursionError) as error:
            raise ModelError(f"{file}: is not XML: {error}") from None
        if root.tag != "mujoco" and not (including and root.tag == "mujocoinclude"):
            raise ModelError(f"{file}: has the root <{root.tag}>; an MJCF has the root <mujoco>")
        for parent in list(root.iter()):
            for index, child in reversed(list(enumerate(parent))):
                if child.tag != "include":
                    continue
                inner = _inside(self._folder, file.parent, child.attrib.get("file", ""), "include")
                if inner in (file, *including):
                    raise ModelError(f"{file}: <include> of {inner.name} includes itself; remove it")
                parent[index : index + 1] = list(self.read_xml(inner, (file, *including)))
        return root


def _asset_folders(root: ElementTree.Element, folder: Path) -> dict[str, Path]:
    """Return the folders of meshes and textures, and take their attributes off <compiler>."""
    stated: dict[str, str] = {}
    for compiler in root.iter("compiler"):
        stated |= {key: compiler.attrib.pop(key) for key in _FOLDERS if key in compiler.attrib}
    found = {tag: stated.get(key, stated.get("assetdir", "")) for tag, key in ASSETS.items()}
    return {tag: _inside(folder, folder, place or ".", ASSETS[tag]) for tag, place in found.items()}


def _inside(folder: Path, start: Path, name: str, what: str) -> Path:
    """Return the file `name` seen from the folder `start`.

    Raises:
        ModelError: The path is empty, or leads out of `folder`, also by a symbolic link.
    """
    try:
        file = (start / name).resolve()
        inside = bool(name) and file.is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        inside = False
    if not inside:
        raise ModelError(
            f"{folder}: the path {name!r} of its <{what}> leads out of the folder of the model; "
            "put the file into the folder, and name it by a relative path"
        )
    return file
