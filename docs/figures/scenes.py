"""Draw the figures of scenes.md from the code of the page: python docs/figures/scenes.py"""

import os
import re
import shutil
import tempfile
from pathlib import Path

DOCS = Path(__file__).parents[1]
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def main():
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        exec("\n".join(PYTHON.findall((DOCS / "scenes.md").read_text())), {"__name__": "page"})
        for name in ("tower.png", "arch.png", "dominoes.png", "wrecking.png"):
            shutil.copy(name, DOCS / "figures" / name)
        os.chdir(here)


if __name__ == "__main__":
    main()
