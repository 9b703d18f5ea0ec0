"""`render` beside Mesa's llvmpipe: one thread each, one process, in turn.

    python benches/peers/render.py MODEL [side of the picture] [rounds]

The model is drawn without light, every pixel its base colour texture, backs left out, blended materials over the
others. multum decodes sRGB, draws blended faces in the order of their depth and gives 8-bit sRGB codes with alpha.
llvmpipe draws triangles as they come, once with codes taken for light (its fastest) and once with sRGB textures and an
sRGB target (the same picture); its pictures are not read back. Prints CPU and versions, then for each filter the median
of all rounds, in ms of the thread's own time, and how many times as long llvmpipe takes.
"""

import os
import platform
import statistics
import sys
import time
from dataclasses import replace
from pathlib import Path

import multum as mt

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "python"))
from render_peer import FILTERS, Llvmpipe


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def main():
    side = int(sys.argv[2]) if len(sys.argv) > 2 else 1024
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 31
    scene = mt.Scene.open(sys.argv[1])
    scene.mesh = replace(scene.mesh, materials=[replace(m, unlit=True) for m in scene.mesh.materials])
    camera, size = scene.camera("auto", (side, side)), (side, side)
    plain, srgb = (Llvmpipe(scene, camera, size, srgb=srgb) for srgb in (False, True))
    info = plain.context.info
    print(f"{cpu()}, MULTUM_SIMD={os.environ.get('MULTUM_SIMD', 'best')}, one thread")
    print(f"multum {mt.__version__}, {info['GL_VERSION']}, {info['GL_RENDERER']}")
    print(f"{Path(sys.argv[1]).name}, {len(scene.mesh.faces)} triangles, {side} x {side}, {rounds} rounds\n")
    print("| filter | multum, ms | llvmpipe, codes as light | llvmpipe, sRGB |")
    print("|---|---|---|---|")
    for filter in FILTERS:
        works = {
            "multum": lambda f=filter: mt.render(scene, camera, size, f, threads=1),
            "plain": lambda f=filter: plain.draw(f),
            "srgb": lambda f=filter: srgb.draw(f),
        }
        times = {name: [] for name in works}
        for _ in range(rounds + 2):
            for name, work in works.items():
                start = time.thread_time()
                work()
                times[name].append((time.thread_time() - start) * 1e3)
        own, *others = (statistics.median(t[2:]) for t in times.values())
        cells = [f"{other:.1f} ({other / own:.2f}x)" for other in others]
        print(f"| {filter} | {own:.1f} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
