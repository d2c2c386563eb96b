"""The paper's experiments and its claims.

Each module imports only from those before it: comparisons, conditions, printed, columns, evidence, charts, experiment;
figures_objects, figures_piles, figures_mechanism and figures_nulls; plan; judgement, verdicts, repetition and
motion_verdict; claims_objects, claims_piles, claims_mechanism and claims_nulls; paper_numbers, ledger, page, run. A
figure and the claims about it may be reworded without a new study: the measures that the study keeps of each recording
are in `pilegrasp_ctrl.analysis.motion`.
"""
