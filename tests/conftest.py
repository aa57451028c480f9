"""Settings of all tests."""

import os

import hypothesis

# the first call of a compiled kernel takes seconds; in CI the same examples every time
hypothesis.settings.register_profile("local", deadline=None)
hypothesis.settings.register_profile("ci", deadline=None, derandomize=True)
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "local")
