"""The kept results are those of the first edition of the claims: their counts follow from the attempts beside them."""

import json
import lzma

import pytest

from pilegrasp_ctrl.files import STUDY_FILE
from pilegrasp_ctrl.scenarios.paper.ledger import first_pass
from pilegrasp_ctrl.scenarios.paper.run import gather_evidence
from pilegrasp_ctrl.study.store import StudyStore
from places import DOCS

RESULTS = DOCS / "results"
SAME = ("C1", "C2", "C3", "C4", "C6", "C7", "C9", "C10", "C15")
"""Claims whose conditions are the same in both editions, at least in part; C11 follows the width of the shovel."""


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    (folder / STUDY_FILE).write_bytes(lzma.decompress((RESULTS / f"{STUDY_FILE}.xz").read_bytes()))
    document = json.loads((RESULTS / "claims.json").read_text(encoding="utf-8"))
    with StudyStore(folder) as store:
        yield document, gather_evidence(store), sum(1 for _ in store.attempts())


def test_all_attempts_are_there(kept):
    document, _, attempts = kept
    assert attempts == document["attempts"]


def test_the_counts_of_every_condition_follow_from_the_attempts(kept):
    document, evidence, _ = kept
    now = first_pass(evidence)
    compared = 0
    for claim in document["claims"]:
        samples = now[claim["id"]].samples
        shared = samples.keys() & claim["conditions"].keys() if claim["id"] in SAME else ()
        assert shared or claim["id"] not in SAME
        for name in shared:
            assert samples[name].as_dict() == claim["conditions"][name], (claim["id"], name)
            compared += 1
    assert compared > 40
