"""All claims of the paper, in the order of their names."""

from __future__ import annotations

from pilegrasp_ctrl.scenarios.paper import claims_mechanism, claims_objects, claims_piles

CLAIMS = (*claims_objects.CLAIMS, *claims_piles.CLAIMS, *claims_mechanism.CLAIMS)
