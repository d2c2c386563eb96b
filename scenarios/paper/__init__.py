"""The paper's experiments and its claims.

Each module imports only from those before it: conditions, evidence, charts, experiment; figures_objects, figures_piles
and figures_mechanism; plan; judgement and motion_verdict; claims_objects, claims_piles and claims_mechanism; ledger,
page, run. A figure and the claims about it may be reworded without a new study: the measures that the study keeps of
each recording are in `pilegrasp_ctrl.analysis.motion`.
"""
