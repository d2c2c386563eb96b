"""Every number of a URDF that matters is checked before the parser prints about it; the others are not read."""

import re

import numpy as np
import pytest

from pilegrasp_ctrl import ArmModel
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.robots import path as robot_path

TEXT = robot_path("wam7", "wam7.urdf").read_text()
SHAPES = '<visual><geometry><box size="1 2"/></geometry></visual><collision><origin xyz="x"/></collision></link>'


def load(folder, text):
    (folder / "a.urdf").write_text(text)
    return ArmModel.from_urdf(folder / "a.urdf", tool_frame="flange")


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        ('<dynamics damping="1e400"/>', r"the dynamics damping of joint '\w+' is '1e400'; it must be finite numbers"),
        ('<dynamics friction="{}"/>', r"the dynamics friction of joint '\w+' is '\{\}'; it must be a number"),
        ('<mimic joint="j1" multiplier="x"/>', r"the mimic multiplier of joint '\w+' is 'x'; it must be a number"),
        ('<mimic joint="j1" offset="1_0"/>', r"the mimic offset of joint '\w+' is '1_0'; it must be a number"),
        ('<origin xyz="0 0 ٣"/>', r"the origin xyz of joint '\w+' is '٣'; it must be a number"),
    ],
)
def test_a_number_that_the_parser_would_refuse_is_named_and_nothing_else_is_printed(tmp_path, capfd, part, sentence):
    with pytest.raises(ModelError, match=sentence):
        load(tmp_path, re.sub(r"(<joint [^>]*>)", rf"\1{part}", TEXT, count=1))
    assert capfd.readouterr().err == ""


def test_shapes_and_colours_of_a_urdf_are_not_read(tmp_path, capfd):
    odd = load(tmp_path, TEXT.replace("</link>", SHAPES).replace("</robot>", '<material name="a"/></robot>'))
    plain, q, v = load(tmp_path, TEXT), np.full(7, 0.3), np.full(7, 0.2)
    assert np.array_equal(odd.update(q, v).M, plain.update(q, v).M)
    assert np.array_equal(odd.update(q, v).h, plain.update(q, v).h)
    assert capfd.readouterr().err == ""


def test_a_folder_whose_model_is_a_link_to_itself_is_refused(tmp_path):
    for name in ("robot.toml", "wam7.xml"):
        (tmp_path / name).write_bytes(robot_path("wam7", name).read_bytes())
    (tmp_path / "wam7.urdf").symlink_to("wam7.urdf")
    # Since Python 3.13 such a link does not exist.
    with pytest.raises(ModelError, match=r"cannot be read: |no such URDF"):
        ArmModel.load(tmp_path)
