"""The example of `docs/disturbances.md` runs, and does what the page says."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "disturbances.md"


def test_the_example_runs(disk_cache, capsys):
    found = re.search(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    assert found
    names = {}
    exec(found.group(1), names)
    assert capsys.readouterr().out.startswith("True ")
    plan, moved = names["plan"], names["found"].plan
    assert plan.satisfied and moved.satisfied
    assert (moved.states[:12] == plan.states[:12]).all()
    assert moved.states[12].tolist() == [-4.0, 3.0]
