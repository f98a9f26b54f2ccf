"""``python -m benchmarks robots``: rows, notes and refusals of a folder; with gymnasium installed all of its models."""

from __future__ import annotations

import pytest

from benchmarks import robots

pytest.importorskip("mujoco")
MODEL = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1" pos="0 0 {floor}"/>
    <body name="box" pos="0 0 .2"><freejoint/><geom type="box" size=".1 .1 .1"/><body name="arm" pos="0 0 .2">
    <joint name="hinge" axis="0 1 0" armature=".1"/><geom type="capsule" fromto="0 0 0 .2 0 .1" size=".03"/></body>
    </body></worldbody><actuator><motor joint="hinge" ctrlrange="-1 1" ctrllimited="true"/></actuator></mujoco>"""
MODELS = [file for folder in robots.installed() for file in sorted(folder.glob("*.xml"))]


def test_a_folder_has_a_row_a_file_what_is_not_understood_and_what_is_refused(tmp_path, capsys):
    (tmp_path / "stands.xml").write_text(MODEL.format(floor=0.1))
    (tmp_path / "sunk.xml").write_text(MODEL.format(floor=0.12))
    (tmp_path / "none.xml").write_text("<mujoco><worldbody><body/><bodi/></worldbody></mujoco>")
    assert robots.main([str(tmp_path)]) == 0
    said = capsys.readouterr().out
    rows = {line.split(" | ")[0]: line.split(" | ") for line in said.splitlines() if line.startswith("| s")}
    assert float(rows["| stands.xml"][3]) < 1e-6 and int(rows["| stands.xml"][6]) == 0
    assert float(rows["| sunk.xml"][3]) < 1e-6
    assert "sunk.xml: the floor is lowered by 0.05 m, floor and box overlap at the start" in said
    assert "**stands.xml**\n- solref, solimp, margin" in said
    assert "2 of 3 files are read; the others are refused:\n\n- none.xml: " in said
    assert "bodi" in said
    assert robots.main([str(tmp_path / "empty")]) == 2


@pytest.mark.peers
@pytest.mark.filterwarnings("ignore::nonsmooth.NotUnderstoodWarning")
@pytest.mark.skipif(not MODELS, reason="gymnasium is not installed")
@pytest.mark.parametrize("file", MODELS, ids=lambda file: file.stem)
def test_models_of_gymnasium_move_as_in_mujoco(file):
    assert robots.off_mujoco(file) < 1e-6
