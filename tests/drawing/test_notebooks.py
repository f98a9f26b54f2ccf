"""Notebooks, executed as a reader would: each cell that asks for an image, an animation or the player holds it."""

import base64
import io
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="notebooks are executed by nbclient of the extra [test]")
nbclient = pytest.importorskip("nbclient", reason="notebooks are executed by nbclient of the extra [test]")
pytest.importorskip("ipykernel", reason="notebooks are executed by ipykernel of the extra [test]")

NOTEBOOKS = Path(__file__).parents[2] / "docs" / "notebooks"
PATIENCE = 300  # s, for a cell that compiles on a busy machine

pytestmark = pytest.mark.filterwarnings(
    "ignore::DeprecationWarning", "ignore::ResourceWarning"
)  # of jupyter's packages


def executed(name, folder):
    """What the cells show, by their source: mime types and data, after a round trip through the saved file."""
    notebook = nbformat.read(NOTEBOOKS / name, as_version=4)
    nbclient.NotebookClient(notebook, timeout=PATIENCE, kernel_name="python3").execute()
    nbformat.write(notebook, folder / name)
    shown = {}
    for cell in nbformat.read(folder / name, as_version=4).cells:
        if cell.cell_type == "code":
            results = [output.data for output in cell.outputs if output.output_type == "execute_result"]
            shown[cell.source.splitlines()[-1]] = results[0] if results else {}
    return shown


def size_of(data):
    from PIL import Image

    return Image.open(io.BytesIO(base64.b64decode(data))).size


@pytest.mark.upkeep
@pytest.mark.parametrize("name", ["rod.ipynb", "boxes.ipynb"])
def test_each_cell_of_a_notebook_shows_its_image_animation_or_player_without_a_magic_line(name, tmp_path):
    shown = executed(name, tmp_path)
    assert shown["sol"]["text/html"].startswith("<pre>") and len(shown["sol"]["text/plain"].splitlines()) <= 20
    drawn = [source for source in shown if ".plot" in source or ".picture" in source]
    assert len(drawn) >= 2
    for source in drawn:
        assert min(size_of(shown[source]["image/png"])) > 300, source
    (gif,) = [data["text/html"] for source, data in shown.items() if ".animate" in source]
    assert min(size_of(gif.split("base64,")[1].split('"')[0])) > 200
    player = shown["sol.view()"]["text/html"]
    assert player.startswith("<iframe") and "window.player" in player and "srcdoc" in player
    for source, data in shown.items():
        assert len(data.get("text/plain", "").splitlines()) <= 20, source
