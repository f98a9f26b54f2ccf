"""The pictures of the tutorials: the program of each page is run, and draws them.

python docs/figures/tutorials.py
"""

import contextlib
import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

DOCS = Path(__file__).parents[1]
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def main():
    for page in sorted((DOCS / "tutorials").glob("*.md")):
        drawn = re.findall(r"\.\./figures/tutorials/(\w+\.png)", page.read_text())
        with TemporaryDirectory() as folder, contextlib.chdir(folder):
            script = Path(folder) / "page.py"  # a file: model functions are read back from their source
            script.write_text("\n".join(PYTHON.findall(page.read_text())))
            exec(compile(script.read_text(), script, "exec"), {"__name__": "page"})
            for name in drawn:
                shutil.move(name, DOCS / "figures/tutorials" / name)
                print(DOCS / "figures/tutorials" / name)


if __name__ == "__main__":
    main()
