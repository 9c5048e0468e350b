"""How long the checks wait for what must come. A mutant is judged with less patience: what it leaves out never comes."""

LONGEST = 20.0  # [s]
