"""How fast videos are rendered, and where the time goes: `python benchmarks/render.py [--frames N] [--clip FILE]`.

Times are of one run, on whatever else the machine is doing; CPU seconds (of this process and of ffmpeg) are printed
beside them, since they say what the work costs when the machine is busy.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from engines.motion import Motion
from tests.viewers import poses
from tests.viewers.textured import checkers, textured
from viewers.camera import Camera
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene
from viewers.video import render, write_video

SIZE, FPS = (1280, 720), 30.0


def cpu() -> tuple[float, float]:
    """CPU seconds so far: this process and its finished children (ffmpeg)."""
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime, children.ru_utime + children.ru_stime


def measured(name: str, frames: int, work: Callable[[], object]) -> None:
    """Print a row: milliseconds a frame, frames a second and times real time, CPU milliseconds a frame."""
    before, start = cpu(), time.perf_counter()
    work()
    wall, after = time.perf_counter() - start, cpu()
    own, children = (1000 * (b - a) / frames for a, b in zip(before, after, strict=True))
    rate = frames / wall
    print(f"{name:44s} {1000 * wall / frames:7.1f} {rate:7.1f} {rate / FPS:6.2f}x {own:8.1f} {children:8.1f}")


def parts(scene: Scene, frames: int) -> None:
    """The parts of a frame, each waited for (drawn all together they overlap)."""
    with Renderer(*SIZE) as renderer, renderer.staged(scene, np.arange(frames) / FPS) as stage:
        gl, targets = renderer.graphics.gl, renderer.targets
        pixels = np.empty((SIZE[1], SIZE[0], 4), np.uint8)
        renderer.draw(stage, 0)
        matrix = stage.view_projections

        def each(work: Callable[[int], object]) -> Callable[[], None]:
            def run() -> None:
                for moment in range(frames):
                    work(moment)
                    gl.finish()

            return run

        measured("  figures", frames, each(lambda i: renderer._figures(stage, i, matrix[i])))
        measured("  shadows", frames, each(lambda i: renderer._shadow_atlas(stage, i)))
        measured("  whole picture", frames, each(lambda i: renderer.draw(stage, i)))
        measured("  read-back", frames, each(lambda _: targets.read_into(pixels)))


def main() -> None:
    """Render one body in several ways and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--clip", type=Path, help="a motion to render instead of the made-up walk")
    options = parser.parse_args()
    motion: Motion = poses.stride(int(options.frames / FPS * 20))
    if options.clip:
        from engines import formats

        motion = formats.read(options.clip)
    scenes = {
        "following camera": Scene.of(motion),
        "still camera": Scene.of(motion, camera=Camera("left")),
        "following, ghosts, trail, contacts": Scene.of(motion, ghosts=8, trail=True, contacts=True),
        "four bodies": Scene.of([motion] * 4),
        "a texture": Scene.of(motion, body=textured(checkers(1024))),
        "as many faces without": Scene.of(motion, body=replace(textured(checkers(1024)), uv=None, texture=None)),
    }
    with Renderer(*SIZE) as renderer:
        print(f"{renderer.graphics.gl.info['GL_RENDERER']}; {SIZE[0]}x{SIZE[1]}, 4 samples, {FPS:g} fps")
        renderer.frame(Scene((Actor(motion),)))
    print(f"{'':44s} {'ms':>7s} {'fps':>7s} {'real':>7s} {'CPU own':>8s} {'ffmpeg':>8s}   (ms a frame)")
    with tempfile.TemporaryDirectory() as folder:
        for name, scene in scenes.items():
            frames = len(scene.times(FPS))
            measured(f"MP4, {name}", frames, lambda s=scene: render(s, Path(folder) / "a.mp4"))
        scene = scenes["following camera"]
        frames = len(scene.times(FPS))
        parts(scene, frames)
        with Renderer(*SIZE) as renderer:
            drawn = [picture.copy() for picture in renderer.pictures(scene, scene.times(FPS)[:60])]
        measured("  encoding alone", 60, lambda: write_video(drawn, Path(folder) / "b.mp4", FPS))
        gif = 20 * len(motion) / motion.fps
        measured("GIF, 480x270 at 20 fps", int(gif), lambda: render(scene, Path(folder) / "a.gif"))


if __name__ == "__main__":
    main()
