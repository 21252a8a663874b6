"""How well hidden effects are found, measured: python -m benchmarks.discovery SECTION.

Campaigns come from the simulators, whose flight, contacts and camera share nothing with the model
that is fitted. Strength is stated as d: the root of the chi-squared that the base model leaves in
the same campaign without noise, which for a small effect is its size over its efficient standard
error. Every section prints what is asked beside what was measured and writes out/discovery-*.json.
"""

import os

# Two threads of linear algebra on such small matrices wait for each other more than they work.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
