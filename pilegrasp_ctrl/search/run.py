"""A search over strategies on the machinery of a study: one folder, one store, workers here or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from ..config import Scenario, load_scenario
from ..exceptions import ConfigurationError, PilegraspError
from ..files import make_folder, read_toml
from ..provenance import code_digest, version_of
from ..scenarios import find
from ..study import FIRST_JUDGING_SEED, MAX_JOBS
from ..study.condition import Attempt, Condition, conditions
from ..study.dispatch import Pool
from ..study.run import open_pool, run_study
from ..study.scheduler import Scheduler
from . import MAX_BUDGET, MAX_CHOICES
from .ablation import Ablation, ablate, changes, most_candidates
from .choice import choose, tied
from .judgement import Judgement, judge
from .race import FIRST, LEAST, MIN_CANDIDATES, Candidate, Race
from .samples import OBJECTIVES, Objective, Samples
from .space import Parameter, Space

Progress = Callable[[str, int, int], None]
"""A callback that gets what happens now, and the finished and expected attempts."""


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """The definition of a search.

    Attributes:
        name: Scenario's name or file.
        overrides: Dotted keys and values that all candidates share.
        space: What is varied.
        objective: What is made large.
        worlds: Values of other keys, one mapping for each world.
        budget: Largest number of attempts of the race.
        seeds: Seeds of the race.
        judging: Seeds of the judgement.
        folder: Folder to which everything is written.
    """

    name: str
    overrides: Mapping[str, Any]
    space: Space
    objective: Objective
    worlds: tuple[Mapping[str, Any], ...]
    budget: int
    seeds: range
    judging: range
    folder: Path

    @property
    def scenario(self) -> Scenario:
        """The start."""
        return load_scenario(self.name, self.overrides)

    def configuration(self) -> dict[str, Any]:
        """Return the values that two runs must share to be one search, as JSON values; budget and ends may grow."""
        table = {key: value for key, value in read_toml(find(self.name)).items() if key not in ("summary", "tags")}
        return {
            "verb": "search",
            "scenario": table,
            "set": dict(self.overrides),
            "over": [asdict(parameter) for parameter in self.space.parameters],
            "objective": self.objective.name,
            "worlds": [dict(world) for world in self.worlds],
            "first seed": self.seeds.start,
            "first judging seed": self.judging.start,
            "origins": {"optuna": version_of("optuna"), "the search's code": code_digest("search")},
        }

    def condition(self, candidate: Candidate, world: Mapping[str, Any]) -> Condition:
        """Return the condition of a candidate in a world.

        Raises:
            ConfigurationError: Its values exclude one another.
        """
        own = {} if candidate.number == 0 else dict(candidate.values)
        return Condition(
            load_scenario(self.name, {**self.overrides, **own, **world}), {**dict(candidate.values), **world}
        )


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """The result of a search.

    Attributes:
        search: Search.
        race: Race with all candidates.
        tied: Candidates among which `RULE` of `choice` chose, the leader first.
        winner: Chosen candidate.
        judgement: Comparison of the winner and the start on fresh seeds.
        recordings: Files of recordings of winner and start on the first judging seed, as far as there are any.
        ablation: Which of the winner's changes suffice; None if that was not asked for.
    """

    search: Search
    race: Race
    tied: tuple[Candidate, ...]
    winner: Candidate
    judgement: Judgement
    recordings: tuple[Path, ...] = ()
    ablation: Ablation | None = None


def plan_search(
    name: str,
    over: Sequence[Parameter],
    folder: Path,
    *,
    overrides: Mapping[str, Any] | None = None,
    objective: str = "held",
    vary: Mapping[str, Sequence[Any]] | None = None,
    budget: int = 1000,
    seeds: range = range(0, 1000),
    judging: range = range(30_000, 30_100),
) -> Search:
    """Return a search that can run.

    Args:
        name: Name of a scenario that ships, or a TOML file.
        over: Keys to vary.
        folder: Folder to write to.
        overrides: Dotted keys and values that all candidates share.
        objective: Name of an objective.
        vary: Values by key whose combinations are the worlds of the robust objective.
        budget: Largest number of attempts of the race.
        seeds: Seeds of the race.
        judging: Seeds of the judgement.

    Raises:
        ConfigurationError: A key, value, number or seed cannot be used.
    """
    shared, varied = dict(overrides or {}), dict(vary or {})
    if objective not in OBJECTIVES:
        raise ConfigurationError(f"--objective {objective!r:.80} is not known; choose from {', '.join(OBJECTIVES)}")
    if (objective == "robust") != bool(varied):
        raise ConfigurationError("--objective robust and --vary, which names its worlds, belong together")
    for key in {each.key for each in over} & varied.keys():
        raise ConfigurationError(f"{key} is in --over and --vary; leave out one of the two")
    _check_seeds(seeds, judging)
    space = Space.around(name, over, shared)
    worlds = [each.varied for each in conditions(name, varied, shared)] if varied else [{}]
    if len(worlds) > MAX_CHOICES:
        raise ConfigurationError(f"--vary has {len(worlds)} worlds; {MAX_CHOICES} are allowed")
    from ..programs.attempt import check

    start = load_scenario(name, shared)
    if not start.traits.touches or not start.pile.count:
        raise ConfigurationError("a search needs a scenario with a pile to grasp from, such as spheres_wall")
    check(start)
    least = MIN_CANDIDATES * LEAST * len(worlds)
    if not least <= budget <= MAX_BUDGET:
        raise ConfigurationError(
            f"--budget {budget} must be from {least}, {LEAST} seeds for {MIN_CANDIDATES} candidates in every world, to "
            f"{MAX_BUDGET}"
        )
    return Search(name, shared, space, OBJECTIVES[objective], tuple(worlds), budget, seeds, judging, folder)


def _check_seeds(seeds: range, judging: range) -> None:
    if seeds.stop > FIRST_JUDGING_SEED:
        raise ConfigurationError(
            f"--seeds {seeds.start}:{seeds.stop} holds seeds that are kept for judging; search on seeds below "
            f"{FIRST_JUDGING_SEED}"
        )
    if len(seeds) < FIRST:
        raise ConfigurationError(f"--seeds must name at least {FIRST} seeds, as in 0:1000")
    if judging.start < seeds.stop and seeds.start < judging.stop:
        raise ConfigurationError("--judge and --seeds must not share a seed, because the winner was chosen on --seeds")


def run_search(
    search: Search,
    jobs: int = 2,
    scheduler: Scheduler | None = None,
    progress: Progress | None = None,
    ablate: bool = False,
) -> SearchResult:
    """Run the missing attempts of a search, and judge its winner.

    The proposals follow from the results, and each attempt is stored as it ends. A search that was killed repeats its
    steps with the stored results, and goes on where it was.

    Args:
        search: Search to run.
        jobs: Number of worker processes on this machine; the result does not depend on it.
        scheduler: Dask scheduler whose workers are used instead.
        progress: Callback before each step and after each attempt.
        ablate: Whether to find out which of the winner's changes suffice.

    Raises:
        PilegraspError: The folder holds another search or is damaged, or the workers cannot start.
    """
    if not 1 <= jobs <= MAX_JOBS:
        raise ConfigurationError(f"jobs = {jobs} must be at least 1 and at most {MAX_JOBS}")
    make_folder(search.folder)
    with ExitStack() as stack:
        runner = _Runner(search, stack.enter_context(open_pool(jobs, scheduler)), jobs, progress or _ignore)
        race = Race(search.space, search.objective, search.budget, len(search.worlds), len(search.seeds))
        race.run(runner.measure, runner.report)
        ties = tied(race)
        winner = choose(race, ties)
        result = runner.judged(race, ties, winner)
        return runner.ablated(result) if ablate else result


def _ignore(words: str, done: int, total: int) -> None:
    """Show nothing."""


@dataclass(slots=True, eq=False)
class _Runner:
    """Runs attempts of candidates in the study of a search."""

    search: Search
    pool: Pool
    jobs: int
    progress: Progress
    known: dict[int, list[Condition]] = field(default_factory=dict)
    hashes: dict[str, int] = field(default_factory=dict)
    words: str = "preparing"
    spent: int = 0

    def report(self, words: str, spent: int) -> None:
        """Note what happens next."""
        self.words, self.spent = words, spent

    def measure(self, wanted: Sequence[tuple[Candidate, int]]) -> None:
        """Run candidates on the first seeds of the search."""
        ready = [(candidate, n) for candidate, n in wanted if self._conditions(candidate)]
        rows = self._rows(ready, self.search.seeds, "none", self.search.budget)
        for candidate, n in ready:
            candidate.samples = rows[candidate.number].part(0, n)

    def _conditions(self, candidate: Candidate) -> list[Condition]:
        """Return the conditions of a candidate, one for each world; none if it cannot run."""
        if candidate.number not in self.known and not candidate.impossible:
            from ..programs.attempt import check

            try:
                found = [self.search.condition(candidate, world) for world in self.search.worlds]
                for condition in found:
                    check(condition.scenario)
            except PilegraspError as error:
                candidate.impossible = str(error)
                return []
            twin = self.hashes.setdefault(found[0].config_hash, candidate.number)
            if twin != candidate.number:
                candidate.impossible = f"means the same as candidate {twin}"
                candidate.twin = twin
                return []
            self.known[candidate.number] = found
        return self.known.get(candidate.number, [])

    def _rows(
        self, wanted: Sequence[tuple[Candidate, int]], seeds: range, record: Any, total: int
    ) -> dict[int, Samples]:
        """Return the samples of candidates on the first seeds, after running what is missing."""
        attempts: list[Attempt] = [
            (condition, seed)
            for candidate, n in wanted
            for seed in seeds[:n]
            for condition in self.known[candidate.number]
        ]
        before = self.spent
        store = run_study(
            attempts,
            self.search.folder,
            jobs=self.jobs,
            pool=self.pool,
            record=record,
            configuration=self.search.configuration(),
            progress=lambda study: self.progress(self.words, min(before + study.finished, total), total),
        )
        with store:
            rows = {(row.config_hash, row.seed): row for row in store.attempts(attempts)}
        found = {}
        for candidate, n in wanted:
            worlds = self.known[candidate.number]
            table = [[rows[condition.config_hash, seed] for condition in worlds] for seed in seeds[:n]]
            found[candidate.number] = Samples.of(table, self.search.objective, worlds[0].scenario)
        return found

    def judged(self, race: Race, ties: Sequence[Candidate], winner: Candidate) -> SearchResult:
        """Run winner and start on the judging seeds, and compare them."""
        start, n = race.candidates[0], len(self.search.judging)
        if start.samples is None:
            raise ConfigurationError(f"the start cannot run: {start.impossible}")
        both = list({each.number: each for each in (start, winner)}.values())
        self.report("judging", 0)
        total = n * len(both) * len(self.search.worlds)
        samples = self._rows([(each, n) for each in both], self.search.judging, "first", total)
        judgement = judge(self.search.objective, samples[start.number], samples[winner.number])
        first = self.search.judging.start
        files = [
            self.search.folder / "recordings" / f"{self.known[each.number][0].config_hash}-{first}.npz"
            for each in reversed(both)
        ]
        kept = tuple(file for file in files if file.is_file())
        return SearchResult(self.search, race, tuple(ties), winner, judgement, kept)

    def ablated(self, result: SearchResult) -> SearchResult:
        """Return a result with the ablation of its winner, on the judging seeds."""
        search, winner = self.search, result.winner
        start = dict(search.space.start)
        changed = changes(start, winner.values)
        known, n = list(result.race.candidates), len(search.judging)
        total = most_candidates(len(changed)) * n * len(search.worlds)
        self.report("ablation", 0)

        def run(kept: Mapping[str, Any]) -> Samples | None:
            values = {**start, **kept}
            candidate = next((each for each in known if each.values == values), None)
            if candidate is None:
                candidate = Candidate(len(known), values)
                known.append(candidate)
            self._conditions(candidate)
            number = candidate.number if candidate.twin is None else candidate.twin
            if number not in self.known:
                return None
            samples = self._rows([(known[number], n)], search.judging, "none", total)[number]
            self.spent += n * len(search.worlds)
            return samples

        fresh = self._rows([(winner, n)], search.judging, "first", total)[winner.number]
        return replace(result, ablation=ablate(search.objective, changed, fresh, run))
