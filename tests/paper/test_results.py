"""The kept results: the ledger follows from the attempts beside it."""

import json
import lzma

from pilegrasp_ctrl.files import STUDY_FILE
from pilegrasp_ctrl.scenarios.paper.ledger import judge_claims, ledger_documents
from pilegrasp_ctrl.scenarios.paper.run import gather_evidence
from pilegrasp_ctrl.study.store import StudyStore
from places import DOCS

RESULTS = DOCS / "results"


def test_the_ledger_follows_from_the_attempts(tmp_path):
    (tmp_path / STUDY_FILE).write_bytes(lzma.decompress((RESULTS / f"{STUDY_FILE}.xz").read_bytes()))
    with StudyStore(tmp_path) as store:
        claims = ledger_documents(judge_claims(gather_evidence(store)))
    kept = json.loads((RESULTS / "claims.json").read_text(encoding="utf-8"))["claims"]
    for claim in (*claims, *kept):
        # Only some of the recordings are kept.
        claim.pop("recordings")
    assert json.loads(json.dumps(claims)) == kept
