"""The laws draw the same examples in every run; GCOMP_FUZZ=1 draws new ones, to look for what nobody thought of."""

import os

from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.register_profile("new", derandomize=False)
settings.load_profile("new" if os.environ.get("GCOMP_FUZZ") else "same")
