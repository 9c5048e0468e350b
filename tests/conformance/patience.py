"""How long the checks wait for what must come. A mutant is judged with less patience: what it leaves out never comes."""

LONGEST = 60.0  # [s]
