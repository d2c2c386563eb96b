"""Proposals of candidates: points that cover the space evenly, then those of optuna's sampler."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import optuna
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution

from ..study.spread import even_shares
from .space import Choice, Parameter, Space

SAMPLER_SEED = 20200312
"""Seed of the sampler (chosen)."""
BATCH = 4
"""Number of candidates that are proposed together (chosen), so that proposals do not depend on the workers' speed."""
EVEN_SHARE = 0.5
"""Share of the candidates that cover the space evenly before the sampler proposes (chosen)."""

Proposal = tuple[optuna.trial.Trial | None, dict[str, Any]]
"""A trial of optuna, and the values that it proposes."""


class Proposer:
    """Proposes values from earlier scores.

    The same scores in the same order give the same proposals, so that a search that was killed goes on with them.
    A space that is small enough is listed completely.
    """

    def __init__(self, space: Space, wanted: int) -> None:
        """Take the space and the number of candidates that are wanted, without the start."""
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._space, self._even = space, max(BATCH, round(EVEN_SHARE * wanted))
        self._keys = [parameter.key for parameter in space.parameters]
        self._distributions = {parameter.key: _distribution(parameter) for parameter in space.parameters}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            sampler = optuna.samplers.TPESampler(
                seed=SAMPLER_SEED, multivariate=True, constant_liar=True, n_startup_trials=min(self._even, 10)
            )
        self._study = optuna.create_study(direction="maximize", sampler=sampler)
        self._listed = self._every_combination() if space.size <= wanted else None
        self._count = 0

    def _every_combination(self) -> list[dict[str, Any]]:
        columns = []
        for parameter in self._space.parameters:
            count = int(parameter.size)
            columns.append([parameter.value((place + 0.5) / count) for place in range(count)])
        return [dict(zip(self._keys, values, strict=True)) for values in product(*columns)]

    def tell_start(self, score: float) -> None:
        """Tell the score of the start, if it lies in the space."""
        shares = {each.key: each.share(self._space.start[each.key]) for each in self._space.parameters}
        known = {key: share for key, share in shares.items() if share is not None}
        if len(known) == len(shares):
            trial = optuna.trial.create_trial(params=self._asked(known), distributions=self._distributions, value=score)
            self._study.add_trial(trial)

    def ask(self, count: int) -> list[Proposal]:
        """Return up to `count` proposals; fewer at the end of a space that is listed."""
        if self._listed is not None:
            found, self._listed = self._listed[:count], self._listed[count:]
            return [(None, values) for values in found]
        return [self._next() for _ in range(count)]

    def _next(self) -> Proposal:
        self._count += 1
        if self._count <= self._even:
            shares = dict(zip(self._keys, even_shares(self._count, len(self._keys)), strict=True))
            self._study.enqueue_trial(self._asked(shares))
        trial = self._study.ask(self._distributions)
        return trial, self._space.values(
            {parameter.key: _share(parameter, trial.params[parameter.key]) for parameter in self._space.parameters}
        )

    def _asked(self, shares: Mapping[str, float]) -> dict[str, Any]:
        """Return the numbers that optuna gets for shares."""
        return {
            parameter.key: min(int(shares[parameter.key] * parameter.size), int(parameter.size) - 1)
            if isinstance(parameter, Choice)
            else shares[parameter.key]
            for parameter in self._space.parameters
        }

    def tell(self, proposals: Sequence[Proposal], scores: Sequence[float]) -> None:
        """Tell the scores of proposals."""
        for (trial, _), score in zip(proposals, scores, strict=True):
            if trial is not None:
                self._study.tell(trial, score)


def _distribution(parameter: Parameter) -> BaseDistribution:
    if isinstance(parameter, Choice):
        return CategoricalDistribution(range(len(parameter.values)))
    return FloatDistribution(0.0, 1.0)


def _share(parameter: Parameter, number: float) -> float:
    return (number + 0.5) / parameter.size if isinstance(parameter, Choice) else number
