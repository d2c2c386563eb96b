"""Command lines: any verb with any options, and values that people mistype."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hypothesis import strategies as st

from file_inputs import recording_bytes, study_bytes
from question import Question
from scenario_inputs import SCENARIOS, settings
from values import FUNCTIONS, MINE, PATHS, texts

OUTPUTS = (
    "a.html",
    "a.png",
    "a.gif",
    "a.mp4",
    "a.npz",
    "a.csv",
    "a.parquet",
    "a.rrd",
    "a.mcap",
    "a",
    "no/a.html",
    "made",
    "/dev/null/a.html",
    "x" * 300,
)
"""Names of files to write; all of them lie in the folder of work, or cannot be made."""

SEEDS = ("0:1", "0", "1:0", "0:300000000", "-1:2", "a:b", "0:1:2", "9" * 30, f"0:{10**18}", "", "0:1000001", "٣:٤")
"""Texts behind --seeds."""

VARIED = (
    "line.speed=0.2,0.3",
    "pile.count=1,2",
    "pile.count=",
    "=1",
    "a=1",
    "line.start=[0.5,0,0.2],[0.6,0,0.2]",
    "support.kind=none,wall",
)
"""Texts behind --vary."""

OVER = (
    "strategy.speed=0.05:0.4",
    "strategy.speed=0.4:0.05",
    "strategy.speed=nan:1",
    "strategy.speed=0.1:1e300",
    "strategy.close_on=force,touches,inside",
    "order.operator=sees,alternates,no:rule",
    "pile.count=1:2",
    "pile.count=1.5:2",
    "pile.count=-9e99:9e99",
    "pile.count=1:" + "9" * 400,
    "hand=shovel,rbo_hand2",
    "hand=a,b",
    "hand=shovel,shovel",
    "support.bin_size=[0.4,0.3,0.1],[0.5,0.4,0.1]",
    "program=mine:plan,mine:other",
    "strategy.speed",
    "=1:2",
    "a=1:2",
    "name=a,b",
    "strategy.speed=::",
    "strategy.speed=0.1:0.2:0.3",
    "strategy.speed=[0.1:0.2",
    "٣=٤:٥",
)
"""Texts behind --over."""

MANY = tuple(
    f"{key}={','.join(str(0.2 + 0.01 * k) for k in range(30))}"
    for key in ("line.speed", "strategy.speed", "sensor.bias")
)
"""Texts behind --vary whose combinations are very many."""


def _option(name: str, values: st.SearchStrategy[str]) -> st.SearchStrategy[list[str]]:
    return st.one_of(st.just([]), values.map(lambda value: [name, value]))


def _names() -> st.SearchStrategy[str]:
    return st.one_of(
        st.sampled_from(sorted(SCENARIOS)),
        st.just("free_space_line"),
        st.sampled_from(("sphere_wall", "a.toml", "./", *PATHS)),
        texts(),
    )


def _plugins() -> st.SearchStrategy[list[str]]:
    """Options that name folders of modules."""
    folders = st.sampled_from((".", "mine", "no", "a.npz", "", "/dev/null", "study"))
    return st.lists(folders, max_size=2).map(lambda found: [word for name in found for word in ("--plugins", name)])


def _functions(option: str) -> st.SearchStrategy[list[str]]:
    """An option that names a function of the user, with folders of modules."""
    named = st.one_of(st.just([]), st.sampled_from(FUNCTIONS).map(lambda name: option.format(name).split()))
    return st.builds(lambda *parts: [word for part in parts for word in part], named, _plugins())


def _whole() -> st.SearchStrategy[str]:
    return st.one_of(st.integers(-2, 3).map(str), st.sampled_from(("9" * 30, "1e3", "", "nan", "0x10", "1_000", "٣")))


def _set() -> st.SearchStrategy[list[str]]:
    return settings().map(lambda found: [word for text in found for word in ("--set", text)])


def _strange() -> st.SearchStrategy[list[str]]:
    return st.one_of(
        st.just([]),
        st.just([]),
        st.lists(st.one_of(texts(), st.sampled_from(("--json", "--", "-x", "--help"))), max_size=2),
    )


@st.composite
def command_lines(draw: Callable[..., Any]) -> Question:
    """A command line."""
    verb = draw(st.sampled_from(tuple(_VERBS)))
    words = [verb, *draw(_VERBS[verb]), *draw(_strange())]
    if draw(st.integers(0, 9)) == 0:
        words = draw(st.permutations(words))
    call = tuple(word.replace("\x00", "?") for word in words)  # the kernel passes no argument with a zero
    if call[:1] == ("doctor",) or "--live" in call:
        call = (*call, "--no-such-option")  # what these do takes long and belongs to the machine
    if call and call[0].startswith("@"):
        call = ("run", *call)
    files = {"a.npz": recording_bytes(), "study/study.db": study_bytes(), "mine/mine.py": MINE, "beside.py": MINE}
    return Question("command line", call, files, writes=("made", "study"))


_OUT = st.one_of(st.just("made"), st.sampled_from(("study", "a.npz", "", "/dev/null", "no/made", "made/../made")))
_VERBS: dict[str, st.SearchStrategy[list[str]]] = {
    "run": st.builds(
        lambda name, *options: [name, *(word for option in options for word in option)],
        _names(),
        _option("--seed", _whole()),
        _set(),
        _option("--record", st.sampled_from(OUTPUTS)),
        _option("--html", st.sampled_from(OUTPUTS)),
        _option("--export", st.sampled_from(OUTPUTS)),
        st.sampled_from(([], ["--embed-recording"])),
        _functions("--set program={}"),
    ),
    "sweep": st.builds(
        lambda name, *options: [name, *(word for option in options for word in option)],
        _names(),
        st.sampled_from(SEEDS).map(lambda text: ["--seeds", text]),
        _option("--vary", st.sampled_from(VARIED)),
        st.one_of(st.just([]), st.just([word for text in MANY for word in ("--vary", text)])),
        _option("--jobs", _whole()),
        _option("--scheduler", st.sampled_from(("x", "", "tls://", "tcp://127.0.0.1:0", "http://127.0.0.1:1"))),
        _option("--record", st.sampled_from(("none", "all", "some"))),
        _functions("--measure {}"),
        _set(),
        _OUT.map(lambda path: ["--out", path]),
    ),
    "search": st.builds(
        lambda name, *options: [name, "--budget", "3", *(word for option in options for word in option)],
        _names(),
        st.lists(st.sampled_from(OVER), max_size=3).map(lambda found: [word for x in found for word in ("--over", x)]),
        _option("--vary", st.sampled_from(VARIED)),
        _option("--objective", st.sampled_from(("held", "picks", "robust", "no"))),
        _option("--seeds", st.sampled_from(SEEDS)),
        _option("--judge", st.sampled_from(SEEDS)),
        st.sampled_from(([], ["--ablate"])),
        _option("--jobs", _whole()),
        _set(),
        _OUT.map(lambda path: ["--out", path]),
    ),
    "paper": st.builds(
        lambda name, *options: [name, *(word for option in options for word in option)],
        st.one_of(st.sampled_from(("all", "fig06", "table1", "fig99")), texts()),
        _option("--attempts", _whole()),
        _option("--seeds-from", _whole()),
        _option("--jobs", _whole()),
        _plugins(),
        _OUT.map(lambda path: ["--out", path]),
    ),
    "tune": st.builds(
        lambda name, *options: [name, *(word for option in options for word in option)],
        _names(),
        _option("--trials", _whole()),
        _option("--seeds", st.sampled_from(SEEDS)),
        _option("--start", st.sampled_from(PATHS)),
        _option("--late", _whole()),
        _option("--controller", st.sampled_from(("impedance", "operational_space", "none"))),
        _functions("--set program={}"),
        _set(),
        _OUT.map(lambda path: ["--out", path]),
    ),
    "check": st.builds(
        lambda name, *options: [name, *(word for option in options for word in option)],
        st.one_of(_names(), st.sampled_from(("wam8", "shovel", "hands", "lime", "study", *PATHS))),
        _option("--tool-frame", texts()),
        _option("--joints", _whole()),
        _option("--write", st.sampled_from(("made", "study", "", "/dev/null"))),
        _option("--picture", st.sampled_from(OUTPUTS)),
        _functions("--set program={}"),
        _set(),
    ),
    "show": st.builds(
        lambda name, *options: [name, *(word for option in options for word in option)],
        _names(),
        _set(),
    ),
    "export": st.builds(
        lambda inputs, output, *options: [*inputs, output, *(word for option in options for word in option)],
        st.lists(st.sampled_from(("a.npz", "study", "b.npz", *PATHS)), max_size=3),
        st.sampled_from(OUTPUTS),
        _option("--speed", st.sampled_from(("1", "0", "-1", "nan", "inf", "1e300", "x"))),
        st.sampled_from(([], ["--embed-recording"])),
    ),
    "report": st.builds(
        lambda folder, option: [folder, *option],
        st.sampled_from(("study", "a.npz", "no", *PATHS)),
        st.one_of(_option("--recordings", st.sampled_from(("0", "-1", "9" * 30))), st.just(["--shared"])),
    ),
    "list": _option("--tag", st.one_of(texts(), st.just("paper"))),
    "bench": st.one_of(_option("--save", st.sampled_from(OUTPUTS)), _option("--compare", st.sampled_from(PATHS))),
    "doctor": st.just(["--no-such-option"]),
    "--version": st.just([]),
    "rnu": st.just([]),
    "": st.just([]),
}
"""Words behind each verb."""
