"""A scene that a browser shows, by viser: bodies as meshes with poses, lines, points of contacts, the time.

A server in a thread of its own sends what is set here to every browser that opens its address, on this machine alone.
It answers until the process ends, so that the last state can be looked at, and the next run is shown in the same place.
Bodies of one form and one colour are one batch, and one message moves them all.
"""

from __future__ import annotations

import atexit
import io
import math
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from typing import Any

import numpy as np

from nonsmooth.drawing.live.meshes import Mesh

HOST = "127.0.0.1"  # chosen: nobody else's browser is answered
PORT = 8080  # chosen: the first one that is tried
FIELD_OF_VIEW = math.radians(50.0)  # chosen: of the camera
SAME_FORM = 6  # chosen: decimals of corners, of the size of a body, that make two bodies one form
LINE_WIDTH, POINT_PART = 2.0, 0.012  # chosen: pixels; of the size of the scene
LINE_COLOUR, CONTACT_COLOUR = (8, 48, 107), (217, 95, 2)  # chosen: colours


_idle: list[Any] = []  # servers whose run has ended


def new_server() -> Any:
    """One that answers until the process ends, and says its address on stderr."""
    import viser

    with redirect_stdout(io.StringIO()):  # it talks there, whatever ``verbose`` is
        server = viser.ViserServer(host=HOST, port=PORT, verbose=False)
    for stop in (server.stop, server._websock_server.stop):  # which talk there too, and wait for browsers
        atexit.unregister(stop)
    print(f"nonsmooth: live view at http://{HOST}:{server.get_port()}", file=sys.stderr, flush=True)
    return server


class Window:
    """An address with a scene, empty at first.

    Parameters
    ----------
    title : str
    centre : (3,)
        What is looked at [m].
    radius : float
        About it, what is seen [m].
    is_planar : bool
        Whether it is looked at along -z.
    """

    def __init__(self, title: str, centre: np.ndarray, radius: float, is_planar: bool) -> None:
        self.server, self.radius = _idle.pop() if _idle else new_server(), radius
        self.server.scene.reset()
        self.server.gui.reset()
        self.server.gui.set_panel_label(title)
        self.batches: list[tuple[Any, np.ndarray]] = []  # of each its bodies
        self.lines: Any = None
        self.contacts: Any = None
        self.clock = self.server.gui.add_markdown("")
        self._look_at(centre, is_planar)

    def _look_at(self, centre: np.ndarray, is_planar: bool) -> None:
        direction = np.array([0.0, 0.0, 1.0] if is_planar else [1.0, -1.0, 0.7])
        far = self.radius / math.sin(FIELD_OF_VIEW / 2)
        self.server.scene.set_up_direction("+y" if is_planar else "+z")
        camera = self.server.initial_camera
        camera.fov = FIELD_OF_VIEW
        camera.near, camera.far = far / 1e3, far * 1e2
        for seen_by in (camera, *(client.camera for client in self.server.get_clients().values())):
            seen_by.look_at, seen_by.position = centre, centre + far * direction / np.linalg.norm(direction)

    def add_bodies(self, meshes: Sequence[Mesh], colours: Sequence[str], is_seen_behind: bool) -> None:
        """Bodies at the origin; those of one form, which may differ in size, are one batch."""
        sizes = np.array([mesh.size for mesh in meshes])
        batches: dict[Any, list[int]] = {}
        for b, (mesh, colour) in enumerate(zip(meshes, colours, strict=True)):
            form = np.round(mesh.corners / sizes[b], SAME_FORM) + 0.0  # no -0
            batches.setdefault((colour, form.tobytes(), mesh.triangles.tobytes()), []).append(b)
        for number, ((colour, *_), members) in enumerate(batches.items()):
            mesh, bodies = meshes[members[0]], np.array(members)
            handle = self.server.scene.add_batched_meshes_simple(
                f"/bodies/{number}", np.float32(mesh.corners / sizes[members[0]]), np.uint32(mesh.triangles),
                np.tile(np.array([1, 0, 0, 0], np.float32), (len(bodies), 1)), np.zeros((len(bodies), 3), np.float32),
                batched_scales=np.float32(sizes[bodies]), batched_colors=rgb(colour), lod="off", flat_shading=True,
                side="double" if is_seen_behind else "front", cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
            self.batches.append((handle, bodies))

    def move(self, position: np.ndarray, turn: np.ndarray) -> None:
        """Let all bodies be at positions (n_b, 3) with turns (n_b, 4), unit quaternions."""
        for handle, bodies in self.batches:
            handle.batched_positions, handle.batched_wxyzs = np.float32(position[bodies]), np.float32(turn[bodies])

    def draw_lines(self, segments: np.ndarray) -> None:
        """Segments (n, 2, 3) instead of those before."""
        if self.lines is None:
            self.lines = self.server.scene.add_line_segments(
                "/lines", np.float32(segments), LINE_COLOUR, thickness=LINE_WIDTH, thickness_units="screen"
            )
        else:
            self.lines.points = np.float32(segments)

    def draw_contacts(self, points: np.ndarray) -> None:
        """Points (n, 3) instead of those before."""
        if self.contacts is not None:
            self.contacts.points = np.float32(points)
        elif len(points):
            self.contacts = self.server.scene.add_point_cloud(
                "/contacts", np.float32(points), CONTACT_COLOUR, point_size=POINT_PART * self.radius,
                point_shape="circle", precision="float32", point_shading="flat",
            )  # fmt: skip

    def say(self, words: str) -> None:
        """Words beside the scene."""
        self.clock.content = words

    def close(self) -> None:
        """Send what was set; the next run may take the place."""
        self.server.flush()
        _idle.append(self.server)


def rgb(colour: str) -> tuple[int, int, int]:
    """#rrggbb as three numbers."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
